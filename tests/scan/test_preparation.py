"""Which goal fits two surfaces, and why."""

from __future__ import annotations

import pytest

from touchwarp.scan.preparation import choose_goal
from touchwarp.scan.soundness import Soundness


def closed(genus: int) -> Soundness:
    """A closed surface by its Euler characteristic, 2 − 2g."""
    return Soundness(1, 0, 0, 0, 0, 0, 0, 2 - 2 * genus, False)


@pytest.mark.parametrize("genus", [0, 1, 2, 3])
def test_surfaces_with_as_many_handles_are_matched(genus: int) -> None:
    kind, why = choose_goal(closed(genus), closed(genus))
    assert kind == "match"
    # which handle shows on which is a choice only where there are several
    assert ("each is shown on the one beside it" in why) == (genus > 1)


def test_surfaces_with_other_numbers_of_handles_are_not() -> None:
    kind, why = choose_goal(closed(1), closed(2))
    assert kind == "direction"
    assert "the prop has 1 handle and the virtual object 2 handles" in why


def test_a_surface_with_a_hole_is_not() -> None:
    kind, why = choose_goal(Soundness(1, 3, 1, 0, 0, 0, 0, 1, False), closed(0))
    assert kind == "direction"
    assert "the prop's mesh has" in why
