"""What a warp file says about itself, apart from the numbers of its table."""

from __future__ import annotations

from dataclasses import dataclass, field, replace
from typing import Any, Literal

import numpy as np
from numpy.typing import NDArray

from touchwarp.scene.surface import Surface


@dataclass(frozen=True, eq=False)
class Outline:
    """One prop and its virtual object, thinned out for pictures; vertex i of one shows at i.

    Attributes:
        prop: m, scene frame.
        virtual: m, scene frame, with the same faces.
    """

    prop: Surface
    virtual: Surface


@dataclass(frozen=True)
class BasisProp:
    """How the boundary data of one prop's basis fields are scaled.

    Attributes:
        centre: (3,) m, table frame.
        half_diagonal: m, half the diagonal of the prop's bounding box.
    """

    centre: tuple[float, float, float]
    half_diagonal: float


@dataclass(frozen=True, eq=False)
class WarpMeta:
    """Everything that makes a warp file stand alone, besides its table.

    Attributes:
        kind: "warp", or "bases" for basis fields still to be combined.
        scene_text: the scene file's TOML, or an equivalent one of a scene built in code.
        mesh_digests: sha256 of each prop's vertices and faces, by prop.
        outlines: prop and virtual object for pictures, by prop.
        outer_box: (2, 3) m, scene frame: the box of ∂Ω1, or the box around it.
        outer_surface: ∂Ω1 thinned out, where it is a mesh.
        screening: λ as it enters Δu = λu, in m⁻².
        tolerance_mm, edge_radius_mm: as asked for in the scene.
        estimated_error_max_mm, estimated_error_rms_mm: the solver's own estimate; for bases over
            their stated range; None where there is none.
        prop_names: in the order of the scene (and of the basis lanes).
        goals: (4, 4) scene to scene by prop, where the goal is known to be affine; they take the
            place of those in `scene_text`, which a combination of bases departs from.
        basis: the scaling of the basis data, by prop; empty for a warp.
        range_shift: m, the stated range of bases: the displacement of a prop's centre.
        range_stretch: the stated range of bases: ‖A − I‖₂ of a goal's 3 × 3 part A.
        T_room_scene: (4, 4) where the scene has been carried since it was solved.
        storage_error_mm: the greatest |u| lost by storing the values as float16; 0 for float32.
        storage_jump: m, the greatest jump of u across a brick's face, caused by storing.
        notes: whatever the maker of the warp wants to tell; JSON values.
    """

    kind: Literal["warp", "bases"] = "warp"
    scene_text: str = ""
    mesh_digests: dict[str, str] = field(default_factory=dict)
    outlines: dict[str, Outline] = field(default_factory=dict)
    outer_box: NDArray[np.float64] | None = None
    outer_surface: Surface | None = None
    screening: float = 0.0
    tolerance_mm: float = 0.1
    edge_radius_mm: float = 2.0
    estimated_error_max_mm: float | None = None
    estimated_error_rms_mm: float | None = None
    prop_names: tuple[str, ...] = ()
    goals: dict[str, NDArray[np.float64]] = field(default_factory=dict)
    basis: dict[str, BasisProp] = field(default_factory=dict)
    range_shift: float = 0.1
    range_stretch: float = 1.0
    T_room_scene: NDArray[np.float64] = field(default_factory=lambda: np.eye(4))
    storage_error_mm: float = 0.0
    storage_jump: float = 0.0
    notes: dict[str, Any] = field(default_factory=dict)

    def as_bases(
        self,
        basis: dict[str, BasisProp],
        range_shift: float,
        range_stretch: float,
        tolerance_mm: float,
        estimated_error_max_mm: float | None,
        estimated_error_rms_mm: float | None,
    ) -> WarpMeta:
        """The meta of basis fields of the same scene.

        Args:
            basis: the scaling of the basis data, by prop.
            range_shift, range_stretch: the stated range.
            tolerance_mm, estimated_error_max_mm, estimated_error_rms_mm: over that range.
        """
        return replace(
            self,
            kind="bases",
            goals={},
            basis=dict(basis),
            range_shift=range_shift,
            range_stretch=range_stretch,
            tolerance_mm=tolerance_mm,
            estimated_error_max_mm=estimated_error_max_mm,
            estimated_error_rms_mm=estimated_error_rms_mm,
        )
