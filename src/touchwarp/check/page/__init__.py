"""The certificate as one self-contained page: no network, one file."""

from touchwarp.check.page.render import render

__all__ = ["render"]
