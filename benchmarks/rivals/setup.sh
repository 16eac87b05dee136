#!/usr/bin/env bash
# Makes the rivals' own environment, benchmarks/rivals/.venv, with touchwarp beside them in it.
set -euo pipefail
here="$(cd "$(dirname "$0")" && pwd)"
python="${PYTHON:-python3}"
"$python" -m venv "$here/.venv"
"$here/.venv/bin/python" -m pip install --quiet -r "$here/requirements.txt"
"$here/.venv/bin/python" -m pip install --quiet -e "$here/../.."
"$here/.venv/bin/python" - <<'PY'
from importlib.metadata import version

import pyFM.functional
import rtree

print("pyfmaps", version("pyfmaps"), "| rtree", rtree.__version__, "| trimesh", version("trimesh"))
PY
