"""The document of the certificate tells every check, and none that does not exist."""

from __future__ import annotations

import re
from pathlib import Path

CHECKOUT = Path(__file__).resolve().parents[2]
SOURCE = CHECKOUT / "src" / "touchwarp" / "check"
DOCUMENT = CHECKOUT / "docs" / "certificate.md"
CAUSES = ("table", "bias", "noise", "latency", "pose")
FAMILIES = (
    "contact edges bounds continuity identity estimate field folds gain reach offset normal pinch "
    "curvature below budget energy surface virtual map"
)
NAME = rf"(?:{'|'.join(FAMILIES.split())})\.[a-zA-Z0-9_]+"


def in_source() -> set[str]:
    text = "\n".join(path.read_text(encoding="utf-8") for path in SOURCE.glob("*.py"))
    assert 'f"budget.{cause}"' in text
    return {*re.findall(rf'"({NAME})"', text), *(f"budget.{cause}" for cause in CAUSES)}


def in_document() -> set[str]:
    return set(re.findall(rf"`({NAME})`", DOCUMENT.read_text(encoding="utf-8")))


def test_every_check_is_told() -> None:
    assert in_source() - in_document() == set()


def test_no_check_is_told_that_does_not_exist() -> None:
    assert in_document() - in_source() == set()
