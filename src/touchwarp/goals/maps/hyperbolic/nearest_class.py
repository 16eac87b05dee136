"""Mapping classes that nearest points suggest.

Of two things that stand in each other's place the class that one means is about that of the nearest
points. These make no map: they jump. But drawn along the virtual surface wherever they jump, they
take loops to loops, and a class is told by what it does to loops. Where the relator goes to the
identity it is a homomorphism, and of the classes to try one of the first.
"""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np
from numpy.typing import NDArray

from touchwarp.goals.maps.hyperbolic.marking import Marking
from touchwarp.goals.maps.hyperbolic.springs import Springs
from touchwarp.goals.maps.hyperbolic.words import (
    Shortener,
    Word,
    canonical_word,
    homology_matrix,
    identity,
    substitute,
)

Int = NDArray[np.int64]

NORMAL_SHARES = (0.0, 0.1, 0.3, 0.6, 1.0)
"""Of normals beside positions: they keep the inside of a wall from its outside."""


def nearest_classes(prop: Marking, virtual: Marking) -> Iterator[dict[int, Word]]:
    """Images of the prop's letters in canonical ones, in the classes that nearest points suggest.

    Nearest are vertices of both coarse meshes, in space and once more with both boxes made alike.
    """
    genus = prop.springs.mesh.genus
    shorten = Shortener(canonical_word(genus))
    form = np.kron(np.eye(genus), np.array([[0, 1], [-1, 0]]))
    own = np.linalg.inv(homology_matrix(prop.images))
    for alike in (False, True):
        for share in NORMAL_SHARES:
            there = _nearest(prop.springs, virtual.springs, alike, share)
            drawn = [virtual.springs.drawn(there[loop]) for loop in prop.springs.loops]
            images = {
                letter: shorten(substitute(drawn[letter - 1], virtual.images))
                for letter in prop.images  # keys of classes are told in this order
            }
            counts = homology_matrix(images) @ own
            # crossings of loops are kept: it covers the virtual surface once
            covers = np.allclose(counts.T @ form @ counts, form)
            if covers and shorten(substitute(prop.springs.relator, images)) == ():
                # the same class, about the base point of shortest words
                yield prop.springs.moved(images, identity(genus))


def _nearest(prop: Springs, virtual: Springs, alike: bool, normal_share: float) -> Int:
    """(n,): of each vertex of the prop's coarse mesh, the nearest of the virtual one's."""
    from scipy.spatial import cKDTree

    places = [springs.mesh.vertices for springs in (prop, virtual)]
    if alike:
        low = [points.min(axis=0) for points in places]
        places = [(points - low[k]) / np.ptp(points, axis=0) for k, points in enumerate(places)]
    else:
        places = [points / prop.mesh.diagonal for points in places]
    one, other = (
        np.concatenate([points, normal_share * springs.mesh.vertex_normals], axis=1)
        for points, springs in zip(places, (prop, virtual), strict=True)
    )
    return np.asarray(cKDTree(other).query(one)[1])
