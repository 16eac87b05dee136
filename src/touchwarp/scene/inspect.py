"""What there is to say about a mesh file or a scene before solving."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

import numpy as np

from touchwarp.scene.goal_spec import GoalSpec
from touchwarp.scene.interaction import Tracking
from touchwarp.scene.mesh_file import read_raw_mesh
from touchwarp.scene.scene import Fixed, Outer, Scene
from touchwarp.scene.surface import Surface
from touchwarp.scene.table import within
from touchwarp.scene.topology import bodies, duplicate_count, edge_counts, loop_count
from touchwarp.scene.units import METRES, metres_per_unit
from touchwarp.scene.weld import weld


@dataclass(frozen=True)
class MeshFacts:
    """A mesh's counts and size, after welding equal vertices.

    Attributes:
        name: the file's name, or the prop's.
        vertices, faces: how many.
        watertight: every edge has exactly two faces.
        bodies: pieces that share no vertex.
        boundary_loops: chains of edges with one face only: the rims of holes.
        nonmanifold_edges: edges with more than two faces.
        duplicate_faces: faces with the same corners as an earlier one.
        dropped_faces: faces of the file that had two corners at one point.
        genus: of a watertight mesh of one body, else None.
        size_mm: extent in x, y, z of the file's axes, mm; None where the unit is not known.
        size_by_unit_mm: the extent that each unit would give, mm; empty where the unit is known.
    """

    name: str
    vertices: int
    faces: int
    watertight: bool
    bodies: int
    boundary_loops: int
    nonmanifold_edges: int
    duplicate_faces: int
    dropped_faces: int
    genus: int | None
    size_mm: tuple[float, float, float] | None
    size_by_unit_mm: dict[str, tuple[float, float, float]]

    def rows(self) -> list[tuple[str, str]]:
        """(label, text) pairs for a table."""
        sizes = [("size", _size_text(self.size_mm))] if self.size_mm else []
        sizes += [(f"size if in {u}", _size_text(s)) for u, s in self.size_by_unit_mm.items()]
        return [
            ("mesh", self.name),
            *sizes,
            ("vertices", f"{self.vertices:,}"),
            ("faces", f"{self.faces:,}"),
            ("watertight", "yes" if self.watertight else "no"),
            ("bodies", f"{self.bodies:,}"),
            ("genus", "–" if self.genus is None else str(self.genus)),
            ("boundary loops", f"{self.boundary_loops:,}"),
            ("non-manifold edges", f"{self.nonmanifold_edges:,}"),
            ("duplicate faces", f"{self.duplicate_faces:,}"),
            ("dropped faces", f"{self.dropped_faces:,}"),
        ]


def inspect_mesh(path: str | Path, unit: str | float | None = None) -> MeshFacts:
    """Count and measure a mesh file; with no unit the size is given for every unit.

    Raises:
        SceneError: as `read_mesh`, but never for a missing unit.
    """
    path = Path(path)
    raw = read_raw_mesh(path)
    metres = raw.metres
    if unit is not None:
        with within(path.name):
            metres = metres_per_unit(unit)
    vertices, faces = weld(raw.vertices, raw.faces)
    extent = np.ptp(vertices, axis=0)

    def size(metres: float) -> tuple[float, float, float]:
        x, y, z = (float(e) for e in extent * metres * 1e3)
        return x, y, z

    edges, counts = edge_counts(faces)
    watertight = bool((counts == 2).all())
    pieces = int(bodies(faces).max()) + 1
    euler = len(vertices) - len(edges) + len(faces)
    return MeshFacts(
        name=path.name,
        vertices=len(vertices),
        faces=len(faces),
        watertight=watertight,
        bodies=pieces,
        boundary_loops=loop_count(edges[counts == 1]),
        nonmanifold_edges=int((counts > 2).sum()),
        duplicate_faces=duplicate_count(faces),
        dropped_faces=len(raw.faces) - len(faces),
        genus=(2 - euler) // 2 if watertight and pieces == 1 else None,
        size_mm=None if metres is None else size(metres),
        size_by_unit_mm={} if metres is not None else {u: size(m) for u, m in METRES.items()},
    )


def describe(scene: Scene) -> list[tuple[str, str]]:
    """(label, text) pairs that sum up a scene for `touchwarp info`."""
    objective, tracking = scene.objective, scene.interaction.tracking
    assert isinstance(tracking, Tracking)
    rows = [
        ("dimension", str(scene.dimension)),
        (
            "mismatch weight λ",
            f"{objective.mismatch_weight:g} (λ/L² = {objective.screening:g} 1/m²)",
        ),
        ("tolerance", f"{objective.tolerance_mm:g} mm"),
        ("outer boundary", _outer_text(scene.outer, scene.dimension)),
    ]
    for prop in scene.props:
        goal = prop.goal.kind if isinstance(prop.goal, GoalSpec) else "arrays"
        virtual = getattr(prop.goal, "virtual", None)
        if isinstance(virtual, Surface):
            goal += f" to {_surface_text(virtual)}"
        source = prop.origin.get("mesh") or prop.origin.get("shape", {}).get("kind")
        source = source or ("polygon" if "polygon" in prop.origin else "arrays")
        rows.append(
            (
                f"prop {prop.name}",
                f"{_surface_text(prop.surface)}, from {source}, goal {goal}",
            )
        )
    rows += [(f"fixed {fixed.name}", _fixed_text(fixed)) for fixed in scene.fixed]
    rows.append(("interaction", f"{scene.interaction.mode}, tracking {tracking.name}"))
    return rows


def _surface_text(surface: Surface) -> str:
    kind = "triangles" if surface.dimension == 3 else "segments"
    return f"{_size_text(np.ptp(surface.bounds, axis=0) * 1e3)}, {len(surface.faces):,} {kind}"


def _size_text(size_mm: object) -> str:
    return " × ".join(f"{s:.4g}" for s in np.asarray(size_mm)) + " mm"


def _outer_text(outer: Outer, dimension: int) -> str:
    if outer.box is not None:
        return f"box of {_size_text(np.ptp(np.asarray(outer.box), axis=0) * 1e3)}"
    if outer.surface is not None:
        return f"surface of {_surface_text(outer.surface)}"
    shape = "cube" if dimension == 3 else "square"
    return f"{shape}, {outer.box_scale:g} × the longest side of props and virtual objects"


def _fixed_text(fixed: Fixed) -> str:
    what = "plane"
    if fixed.surface is not None:
        what = f"surface of {_surface_text(fixed.surface)}"
    return f"{what}, {fixed.contact}, blended over {fixed.blend_mm:g} mm"
