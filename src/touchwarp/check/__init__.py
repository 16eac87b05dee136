"""The certificate: every promise of a warp, checked on this warp, with pictures."""

from touchwarp.check.certify import check
from touchwarp.check.report import Check, Report

__all__ = ["Check", "Report", "check"]
