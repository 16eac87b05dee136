"""Automorphisms of a surface's group that maps of the surface induce: its mapping classes.

Two one-to-one maps between the same surfaces can be deformed into each other just where they are of
one class, and the classes are without number. The twists generate all of them (Dehn 1938). Maps
that also keep handles handles and tunnels tunnels are few among them: half turns of a handle, its
waist's twists, swaps of two handles, and slides of one over the other generate those of genus 2
(Scharlemann 2004).
"""

from __future__ import annotations

import itertools

from touchwarp.goals.maps.hyperbolic.words import (
    Images,
    Shortener,
    Word,
    canonical_word,
    compose,
    identity,
    inverse,
)

Moves = dict[str, dict[int, Word]]
SHORT = 9
"""Letters for each handle in the images of a short move; the identity's have two."""


def opposite(names: str) -> str:
    """The names of the move that undoes a sequence of them; a prime marks an inverse."""
    return " ".join(
        name[:-1] if name.endswith("'") else name + "'" for name in reversed(names.split())
    )


def twists(genus: int) -> Moves:
    """Dehn twists, and swaps of neighbouring handles, by name; of each its inverse too.

    A, B: about the two loops of a handle; C: about a loop through two handles; W: about the waist
    of one; S: two handles change places.
    """
    moves: Moves = {}

    def add(name: str, there: Images, back: Images) -> None:
        moves[name] = {**identity(genus), **there}
        moves[name + "'"] = {**identity(genus), **back}

    for i in range(1, genus + 1):
        a, b = 2 * i - 1, 2 * i
        add(f"A{i}", {b: (b, a)}, {b: (b, -a)})
        add(f"B{i}", {a: (a, b)}, {a: (a, -b)})
        waist = (a, b, -a, -b)
        turned = {k: (*waist, k, *inverse(waist)) for k in (a, b)}
        add(f"W{i}", turned, {k: (*inverse(waist), k, *waist) for k in (a, b)})
    for i in range(1, genus):
        a, b, c, d = range(2 * i - 1, 2 * i + 3)
        z = (-b, c, d, -c)
        add(
            f"C{i}",
            {a: (a, *inverse(z)), b: (*z, b, *inverse(z)), c: (*z, c)},
            {a: (a, *z), b: (*inverse(z), b, *z), c: (*inverse(z), c)},
        )
        w, v = (a, b, -a, -b), (c, d, -c, -d)
        add(
            f"S{i}",
            {a: (*w, c, *inverse(w)), b: (*w, d, *inverse(w)), c: (a,), d: (b,)},
            {a: (c,), b: (d,), c: (*inverse(v), a, *v), d: (*inverse(v), b, *v)},
        )
    return moves


def near_moves(genus: int) -> Moves:
    """`handle_moves`, and products of two of them whose words are short too."""
    shorten = Shortener(canonical_word(genus))
    single = handle_moves(genus)
    found = dict(single)
    seen = {tuple(move.values()) for move in (identity(genus), *single.values())}
    for (name, first), (other, second) in itertools.product(single.items(), repeat=2):
        move = {letter: shorten(word) for letter, word in compose(first, second).items()}
        words = tuple(move.values())
        if words not in seen and sum(len(word) for word in words) <= SHORT * genus:
            seen.add(words)
            found[f"{name} {other}"] = move
    return found


def handle_moves(genus: int) -> Moves:
    """Moves that keep loops round handles, and loops through tunnels, what they are in homology."""
    moves = twists(genus)
    named: dict[str, str] = {}
    for i in range(1, genus + 1):
        named[f"W{i}"] = f"W{i}"
        named[f"R{i}"] = f"A{i} B{i}' A{i} A{i} B{i}' A{i}"
    for i in range(1, genus):
        named[f"S{i}"] = f"S{i}"
        slide = f"C{i} B{i}' B{i + 1}'"
        for name, k in ((f"P{i}", i + 1), (f"Q{i}", i)):
            quarter = f"A{k} B{k}' A{k}"
            named[name] = f"{quarter} {slide} {opposite(quarter)}"
            named[name + "*"] = f"{opposite(quarter)} {slide} {quarter}"
    shorten = Shortener(canonical_word(genus))
    found: Moves = {}
    for name, names in named.items():
        for key, sequence in ((name, names), (name + "'", opposite(names))):
            images = identity(genus)
            for each in sequence.split():
                images = compose(moves[each], images)
            found[key] = {letter: shorten(word) for letter, word in images.items()}
    return found
