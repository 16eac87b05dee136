"""The fundamental group: words, mapping classes, and the deck group as matrices."""

from __future__ import annotations

import numpy as np
import pytest

from touchwarp.errors import GoalError
from touchwarp.goals.maps.hyperbolic.deck import METRIC, Deck, evaluate, matrix_of
from touchwarp.goals.maps.hyperbolic.mapping_classes import handle_moves, near_moves, twists
from touchwarp.goals.maps.hyperbolic.words import (
    Shortener,
    canonical_word,
    compose,
    free,
    homology_matrix,
    inverse,
    substitute,
    to_canonical,
)


def standard_form(genus: int) -> np.ndarray:
    return np.kron(np.eye(genus, dtype=int), np.array([[0, 1], [0, 0]]))


@pytest.mark.parametrize("genus", [2, 3])
def test_the_relator_is_the_identity_and_half_of_it_is_not(genus: int) -> None:
    relator = canonical_word(genus)
    shorten, deck = Shortener(relator), Deck(genus)
    assert shorten((3, *relator, -3)) == ()
    assert deck.element(relator) == 0
    half = relator[: 2 * genus]
    assert shorten(half) != ()
    assert deck.element(half) != 0
    generators = deck.tables[0][1 : 2 * genus + 1]
    # halves, as products of far matrices lose as many digits as they reach far, twice
    one, other = (evaluate(word, generators) for word in (half, inverse(relator[2 * genus :])))
    assert one == pytest.approx(other, abs=1e-11 * one.max())
    assert np.abs(one - np.eye(3)).max() > 1  # the twin


def test_elements_are_lorentz_matrices_and_negatives_are_inverses() -> None:
    deck = Deck(2)
    for word in ((1, 2), (1, 1, -2), (4, 3, -1), (1, 2, -1, -2)):
        element = deck.element(word)
        matrix = matrix_of(deck.tables, element)
        assert matrix.T @ METRIC @ matrix == pytest.approx(METRIC, abs=1e-9 * matrix.max() ** 2)
        assert matrix == pytest.approx(evaluate(word, deck.tables[0][1:5]), rel=1e-9, abs=1e-9)
        assert deck.element(inverse(word)) == -element


def test_tables_that_are_full_are_told() -> None:
    with pytest.raises(GoalError, match="more often than the tables of the hyperbolic plane hold"):
        Deck(2, most=4).element((1, 2))


def test_any_relator_of_one_vertex_becomes_canonical() -> None:
    relator = (1, 2, 3, -1, -2, 4, -3, -4)
    images = to_canonical(relator)
    assert substitute(relator, images) == canonical_word(2)


@pytest.mark.parametrize("genus", [2, 3])
def test_mapping_classes_keep_the_relator_and_have_inverses(genus: int) -> None:
    shorten = Shortener(canonical_word(genus))
    for moves in (twists(genus), handle_moves(genus)):
        for name, move in moves.items():
            assert shorten(substitute(canonical_word(genus), move)) == ()
            other = moves[name[:-1] if name.endswith("'") else name + "'"]
            back = compose(other, move)
            assert all(shorten((*word, -letter)) == () for letter, word in back.items())
    broken = {1: (1, 2, 2, 3), **{k: (k,) for k in range(2, 2 * genus + 1)}}  # the twin
    assert shorten(substitute(canonical_word(genus), broken)) != ()


def test_near_moves_keep_handles_handles_and_a_twist_does_not() -> None:
    form = standard_form(2)
    moves = near_moves(2)
    assert len(moves) > len(handle_moves(2))
    for move in moves.values():
        change = homology_matrix(move)
        assert (change.T @ form @ change == form).all()
    twist = homology_matrix(twists(2)["A1"])
    assert not (twist.T @ form @ twist == form).all()


def test_free_words_have_no_letter_beside_its_inverse() -> None:
    assert free((1, 2, -2, -1, 3)) == (3,)
