"""Words: elements of the fundamental group of a closed surface, and automorphisms of it.

The letters ±1 … ±2g are loops and their inverses. The group has one relator, a word of 4g letters
in which each letter and its inverse occur once. The canonical one is Π [2i − 1, 2i], i = 1 … g.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np
from numpy.typing import NDArray

Word = tuple[int, ...]
Images = Mapping[int, Word]
"""The word that each of the letters 1 … 2g goes to."""


def canonical_word(genus: int) -> Word:
    """The canonical relator, of 4·genus letters."""
    word: list[int] = []
    for a in range(1, 2 * genus, 2):
        word += [a, a + 1, -a, -a - 1]
    return tuple(word)


def free(word: Sequence[int]) -> Word:
    """The word without letters that stand beside their inverse."""
    out: list[int] = []
    for letter in word:
        if out and out[-1] == -letter:
            out.pop()
        else:
            out.append(letter)
    return tuple(out)


def inverse(word: Word) -> Word:
    """The word of the inverse element."""
    return tuple(-letter for letter in reversed(word))


def substitute(word: Sequence[int], images: Images) -> Word:
    """The word with each letter replaced by its image."""
    out: list[int] = []
    for letter in word:
        out += images[letter] if letter > 0 else inverse(images[-letter])
    return free(out)


def identity(genus: int) -> dict[int, Word]:
    """Each letter to itself."""
    return {letter: (letter,) for letter in range(1, 2 * genus + 1)}


def compose(outer: Images, inner: Images) -> dict[int, Word]:
    """Letter → outer(inner(letter))."""
    return {letter: substitute(word, outer) for letter, word in inner.items()}


def homology_matrix(images: Images) -> NDArray[np.int64]:
    """(2g, 2g): column k counts the letters in the image of letter k + 1, inverses negative."""
    matrix = np.zeros((len(images), len(images)), np.int64)
    for letter, word in images.items():
        for each in word:
            matrix[abs(each) - 1, letter - 1] += np.sign(each)
    return matrix


class Shortener:
    """Dehn's algorithm: more than half of the relator is replaced by the inverse of the rest.

    In the group of a surface of genus 2 or more it brings exactly the words of the identity to the
    empty word (Dehn 1912). Other words come out short, though not in one form.
    """

    def __init__(self, relator: Word) -> None:
        length = len(relator)
        self._lengths = range(length, length // 2, -1)
        self._shorter: dict[Word, Word] = {}
        for word in (relator, inverse(relator)):
            for start in range(length):
                turned = word[start:] + word[:start]
                for count in self._lengths:
                    self._shorter[turned[:count]] = inverse(turned[count:])

    def __call__(self, word: Sequence[int]) -> Word:
        short = free(word)
        while (found := self._find(short)) is not None:
            start, count, instead = found
            short = free(short[:start] + instead + short[start + count :])
        return short

    def _find(self, word: Word) -> tuple[int, int, Word] | None:
        for count in self._lengths:
            for start in range(len(word) - count + 1):
                instead = self._shorter.get(word[start : start + count])
                if instead is not None:
                    return start, count, instead
        return None


def to_canonical(relator: Word) -> dict[int, Word]:
    """Images of a relator's letters in canonical letters, under which it becomes canonical.

    Where x … y … x⁻¹ … y⁻¹ occur in this order, cutting and gluing brings them together: the word
    V x P y Q x⁻¹ R y⁻¹ S is V R Q P S and one handle (Brahana 1921).
    """
    rest, steps = relator, []
    while rest:
        x, y, parts = _nearest_linked(rest)
        steps.append((x, y, parts))
        before, p, q, r, after = parts
        rest = free(before + r + q + p + after)
    images: dict[int, Word] = {}
    for count, (x, y, parts) in reversed(list(enumerate(steps))):
        a = 2 * count + 1
        v, p, q, r = (substitute(part, images) for part in parts[:4])
        ahead = free(v + r + q)
        for letter, word in (
            (x, free((*inverse(v), a, *ahead))),
            (y, free((*inverse(p), *inverse(ahead), a + 1, *ahead, *inverse(q)))),
        ):
            images[abs(letter)] = word if letter > 0 else inverse(word)
    assert substitute(relator, images) == canonical_word(len(relator) // 4)
    return images


def _nearest_linked(word: Word) -> tuple[int, int, tuple[Word, Word, Word, Word, Word]]:
    """Letters x, y with x P y Q x⁻¹ R y⁻¹ in the word, and V, P, Q, R, S; nearest to its start."""
    place = {letter: k for k, letter in enumerate(word)}
    best, found = len(word) + 1, (0, 0)
    for x in word:
        k, end = place[x], place[-x]
        for y in word[k + 1 : end]:
            last = place[-y]
            if last > end and last < best:
                best, found = last, (x, y)
    assert best <= len(word), "the word of an orientable surface has linked letters"
    x, y = found
    k, m, end, last = place[x], place[y], place[-x], place[-y]
    parts = (word[:k], word[k + 1 : m], word[m + 1 : end], word[end + 1 : last], word[last + 1 :])
    return x, y, parts
