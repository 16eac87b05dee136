"""What a misspelt word was probably meant to be."""

from __future__ import annotations

import difflib
from collections.abc import Iterable


def suggest(came: str, known: Iterable[str]) -> str:
    """A sentence that names the nearest known word, if any is near, and lists them all."""
    words = list(known)
    near = difflib.get_close_matches(came.lower(), [w.lower() for w in words], n=1, cutoff=0.5)
    listing = "Known: " + ", ".join(words) + "."
    if not near:
        return listing
    meant = next(w for w in words if w.lower() == near[0])
    return f"Did you mean '{meant}'? {listing}"
