"""The two energies that the warp balances (eq. 3, 4), and the weight λ between them (eq. 5)."""

from __future__ import annotations

import numpy as np

from touchwarp.check.case import Case, Finding
from touchwarp.check.report import measured


def check_energy(case: Case) -> Finding:
    """λ, L1 = ∫Ω |u|² and L2 = ∫Ω |∇u|², the latter summed over the components."""
    probes = case.probes
    d = case.dimension
    squares = np.einsum("ni,ni->n", probes.u, probes.u)
    slopes = probes.slopes - np.eye(d)
    bends = np.einsum("nij,nij->n", slopes, slopes)
    volume = float(probes.volume.sum())
    mismatch = float(probes.volume @ squares)
    distortion = float(probes.volume @ bends)
    # the standard error of a stratified sum is below that of a plain one
    noise = float(np.sqrt(np.sum((probes.volume * bends) ** 2))) / max(distortion, 1e-300)
    weight = case.screening * case.scene.objective.length_scale**2
    solid = d == 3
    return Finding(
        [
            measured(
                "energy.lambda",
                "Mismatch weight λ",
                weight,
                group="told",
                whole="a choice for the whole scene",
                detail=f"λ/L² = {case.screening:.4g} m⁻² with "
                f"L = {1e3 * case.scene.objective.length_scale:g} mm. 0 is the smoothest warp; "
                "larger values keep the mismatch close to the props.",
                source="eq. 5",
            ),
            measured(
                "energy.L1",
                "Mismatch energy L1",
                1e15 * mismatch if solid else 1e12 * mismatch,
                "mm⁵" if solid else "mm⁴",
                group="told",
                whole="an integral over Ω",
                detail=f"∫Ω |f − x|²: rms {1e3 * np.sqrt(mismatch / volume):.3g} mm over Ω, "
                f"{1e3 * volume:.3g} l."
                if solid
                else "∫Ω |f − x|².",
                source="eq. 3, α = 2",
            ),
            measured(
                "energy.L2",
                "Distortion energy L2",
                1e9 * distortion if solid else 1e6 * distortion,
                "mm³" if solid else "mm²",
                group="told",
                whole="an integral over Ω",
                detail=f"Σ ∫Ω |∇(f − x)|², to about {100 * noise:.1g} %.",
                source="eq. 4, β = 2",
            ),
        ],
        {},
    )
