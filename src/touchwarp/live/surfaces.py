"""Surfaces for the page to draw and colour: fine enough for values at vertices, not too fine."""

from __future__ import annotations

import numpy as np
import trimesh
from numpy.typing import NDArray

from touchwarp.goals.surface_tree import SurfaceTree

MOST_FACES = 20_000
DIVISIONS_ALONG = 45
"""Edges longer than the object over this are divided."""
CREASE = np.radians(35.0)
"""Across edges that turn by more, vertices are doubled: there the shading breaks."""


def pack_surface(
    prop: NDArray[np.float64], virtual: NDArray[np.float64], faces: NDArray[np.int64]
) -> bytes:
    """A prop's surface with where each vertex shall appear, as the page reads it.

    u32 number of vertices n, u32 number of faces m, then float32 (n, 3) prop and (n, 3) virtual
    vertices in m, scene frame, then u32 (m, 3) faces; little-endian.

    Args:
        prop: (n, 3) m.
        virtual: (n, 3) m, row by row of the same points.
        faces: (m, 3).
    """
    both = np.hstack([prop, virtual])
    if len(faces) > MOST_FACES:
        both, faces = _thinned(both, faces)
    else:
        both, faces = _divided(both, faces)
    both, faces = _creased(both, faces)
    head = np.array([len(both), len(faces)], "<u4")
    parts = (head, both[:, :3].astype("<f4"), both[:, 3:].astype("<f4"), faces.astype("<u4"))
    return b"".join(np.ascontiguousarray(part).tobytes() for part in parts)


def _thinned(
    both: NDArray[np.float64], faces: NDArray[np.int64]
) -> tuple[NDArray[np.float64], NDArray[np.int64]]:
    """Fewer faces, whose vertices are points of the prop beside where those shall appear."""
    import fast_simplification

    prop = both[:, :3]
    scale = float(np.ptp(prop, axis=0).max())
    thin, few = fast_simplification.simplify(
        (prop / scale).astype(np.float32), faces.astype(np.int32), target_count=MOST_FACES
    )
    used, few = np.unique(np.asarray(few, dtype=np.int64), return_inverse=True)
    # nearest vertices would not do: among thin triangles they turn faces over
    tree = SurfaceTree(prop, faces)
    found = tree.nearest(thin[used].astype(np.float64) * scale)
    points = np.einsum("nk,nkd->nd", tree.weights(found), both[faces[found.elements]])
    return points, few.reshape(-1, 3)


def _divided(
    both: NDArray[np.float64], faces: NDArray[np.int64]
) -> tuple[NDArray[np.float64], NDArray[np.int64]]:
    """Long edges divided, which changes no shape: values between a mesh's own vertices show."""
    longest = float(np.ptp(both, axis=0).max()) / DIVISIONS_ALONG
    while True:
        # edges are measured in both spaces at once: (n, 6)
        subdivided = trimesh.remesh.subdivide_to_size(  # type: ignore[no-untyped-call]
            both, faces, longest, max_iter=30
        )
        fine, few = subdivided
        if len(few) <= 2 * MOST_FACES:
            break
        longest *= 1.5
    points, index = np.unique(np.round(fine, 9), axis=0, return_inverse=True)
    return points, index.reshape(-1)[few]


def _creased(
    both: NDArray[np.float64], faces: NDArray[np.int64]
) -> tuple[NDArray[np.float64], NDArray[np.int64]]:
    """Vertices doubled along sharp edges of the prop, one for each smooth part that meets there."""
    mesh = trimesh.Trimesh(both[:, :3], faces, process=False)
    smooth = mesh.face_adjacency[mesh.face_adjacency_angles < CREASE]
    part = trimesh.graph.connected_component_labels(  # type: ignore[no-untyped-call]
        smooth, node_count=len(faces)
    )
    corners = np.stack([faces.ravel(), np.repeat(part, 3)], axis=1)
    kept, index = np.unique(corners, axis=0, return_inverse=True)
    return both[kept[:, 0]], index.reshape(-1, 3)
