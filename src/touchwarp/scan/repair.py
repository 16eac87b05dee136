"""A clean closed surface out of a scan, with its topology kept or a refusal."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator
from dataclasses import dataclass

import numpy as np

from touchwarp.errors import SceneError
from touchwarp.scan.cleaning import (
    capped,
    largest_body,
    oriented,
    unpinched,
    without_duplicates,
    without_fragments,
)
from touchwarp.scan.deviation import SAMPLES, Deviation, deviation, diagonal, distances, sample
from touchwarp.scan.remesh import edge_length_for, remesh
from touchwarp.scan.soundness import Soundness, inspect, volume
from touchwarp.scan.thickness import wall_thickness
from touchwarp.scan.tunnels import close_tunnels
from touchwarp.scan.wrap import MOST_CORNERS, corner_count, wrap
from touchwarp.scene.surface import Surface

Progress = Callable[[str, float], None]

BOUND = 0.005
"""Of the diagonal: how far 99 % of the input's area may lie from the result."""

MOST_NEW = 0.25
"""At most this share of the result's area may span holes."""

LEAST_VOLUME = 1e-7
"""Of the diagonal's cube: what encloses less is flat. A bank card encloses 4e-4."""

CLOSINGS = (0.0075, 0.011, 0.015)
"""Of the diagonal: the offsets whose wraps must agree on a genus that the input does not tell."""

CLEANED = "duplicates dropped, faces turned outward"

MOST_TUNNELS = 8
"""Of a closed mesh with more handles too many a wrap is made instead, and of a wrap a finer one."""

VOXEL = 0.006
"""Of the diagonal: the largest voxel; half the wall's thickness where that is less."""

MOST_WORK = 6_000_000
"""Voxel corners, of all wraps together, after which finer ones are not tried unless asked for."""


@dataclass(frozen=True, eq=False)
class Repair:
    """A sound surface, and what it took.

    Attributes:
        surface: one closed manifold, its normals outward; m, the input's frame.
        steps: what was done, in words, in order; empty where the input was sound already.
        before: the input's faults.
        genus_before: the input's genus where its mesh tells it (closed manifold), else None.
        genus: the result's.
        genus_reason: why that genus is taken for the right one.
        from_input: distances from the input's surface to the result; large where something of the
            input was dropped.
        to_input: distances from the result to the input; large where a hole was spanned.
        new_share: the part of the result's area that spans holes: farther than the bound from the
            input.
        bound_mm: the bound on `from_input.p99_mm`.
    """

    surface: Surface
    steps: tuple[str, ...]
    before: Soundness
    genus_before: int | None
    genus: int
    genus_reason: str
    from_input: Deviation
    to_input: Deviation
    new_share: float
    bound_mm: float


def repair(
    surface: Surface,
    *,
    genus: int | None = None,
    bound_mm: float | None = None,
    voxel_mm: float | None = None,
    faces: int | None = 20_000,
    progress: Progress | None = None,
) -> Repair:
    """Make one closed, oriented manifold of a triangle surface by the least that suffices.

    In order: drop duplicates and turn faces alike; split pinched places and drop fragments; cap
    holes; close narrow tunnels of the closed mesh; wrap the whole by its winding number, at finer
    and finer voxels until a bound of work; wrap and close tunnels that are narrower than a few
    voxels. The first result counts that has the expected genus and lies within the bound.

    Args:
        surface: any triangle surface, m.
        genus: the number of handles that the result must have. By default that of the input, where
            it is a closed manifold; else the one on which three wraps of different offsets agree;
            else that of the input's mesh with its holes capped.
        bound_mm: the 99th percentile of the distance from the input to the result must stay below;
            0.5 % of the diagonal by default.
        voxel_mm: the first wrap's voxel; by default from the wall's thickness.
        faces: a wrap is remeshed to about so many; None to leave its marching cubes as they are.
        progress: called as progress(step, part done).

    Raises:
        SceneError: nothing that was tried has the expected genus within the bound; the message
            tells each try. Or a number is out of range.
    """
    _check(surface, genus, bound_mm, voxel_mm)
    report = progress or (lambda step, part: None)
    report("looking for faults", 0.0)
    before = inspect(surface)
    bound = BOUND * diagonal(surface) if bound_mm is None else bound_mm * 1e-3
    genus_before = before.genus if before.closed else None
    clean = oriented(without_duplicates(surface))
    manifold = without_fragments(unpinched(clean))
    wanted, reason = genus, "asked for"
    if wanted is None:
        wanted, reason = _expected_genus(clean, manifold, genus_before, report)
    failed: list[str] = []
    for steps, candidate in _candidates(surface, clean, manifold, wanted, voxel_mm, faces, report):
        report(f"measuring: {steps[-1]}" if steps else "measuring", 0.9)
        fault, measured = _hold(candidate, surface, wanted, bound)
        if measured is None:
            failed.append(f"{steps[-1] if steps else 'as it is'}: {fault}")
            continue
        from_input, to_input, new_share = measured
        return Repair(
            surface=candidate,
            steps=steps,
            before=before,
            genus_before=genus_before,
            genus=wanted,
            genus_reason=reason,
            from_input=from_input,
            to_input=to_input,
            new_share=new_share,
            bound_mm=bound * 1e3,
        )
    raise SceneError(_refusal(before, wanted, reason, bound, failed))


def _candidates(
    surface: Surface,
    clean: Surface,
    manifold: Surface,
    genus: int,
    voxel_mm: float | None,
    faces: int | None,
    report: Progress,
) -> Iterator[tuple[tuple[str, ...], Surface]]:
    """What was done, and what came of it, from the least step to the greatest."""
    yield (), surface
    steps = [CLEANED]
    yield tuple(steps), clean
    if len(manifold.faces) < len(clean.faces) or len(manifold.vertices) != len(clean.vertices):
        fragments = len(clean.faces) - len(manifold.faces)
        steps.append(f"pinched places split, {fragments:,} faces of fragments dropped")
        yield tuple(steps), manifold
    holes = inspect(manifold).holes
    closed: Surface | None = manifold
    if holes:
        report("capping holes", 0.0)
        closed = capped(manifold)
        if closed is not None:
            steps.append(f"{holes:,} hole{'s' * (holes > 1)} capped")
            yield tuple(steps), closed
    if closed is not None and _more_handles(closed, genus):
        report("closing tunnels", 0.0)
        fewer, around = close_tunnels(closed, genus)
        if around:
            widths = ", ".join(f"{1e3 * length:.2g}" for length in around)
            step = f"{len(around)} tunnel{'s' * (len(around) > 1)} closed, {widths} mm around"
            yield (*steps, step), fewer
    yield from _wraps(clean, genus, voxel_mm, faces, report)


def _more_handles(closed: Surface, genus: int) -> bool:
    """Whether it is sound but for handles that are too many, and few enough to look at each."""
    found = inspect(closed)
    return found.sound and found.genus is not None and 0 < found.genus - genus <= MOST_TUNNELS


def _wraps(
    clean: Surface, genus: int, voxel_mm: float | None, faces: int | None, report: Progress
) -> Iterator[tuple[tuple[str, ...], Surface]]:
    """Wraps at finer and finer voxels; each also with its narrow tunnels closed.

    A tunnel closes when the surface is moved out by half its width, and stays closed on the way
    back; what is not a tunnel comes back as it was, apart from creases narrower than that.

    Of many handles those that too coarse a voxel made are gone with a finer one. Where more than
    half of them stay, they are in the scan, as where a wall has one side only, and no wrap helps.
    """
    voxels = [VOXEL * diagonal(clean) / 1.6**k for k in range(5)]
    voxels = [v for v in voxels if v < 0.9 * wall_thickness(clean)][:3]
    if voxel_mm is not None:
        voxels = [voxel_mm * 1e-3]
    work, left = 0.0, math.inf
    for voxel in voxels:
        corners = corner_count(clean, voxel)
        if (corners > MOST_CORNERS or work + corners > MOST_WORK) and voxel_mm is None:
            return
        step = f"wrapped at a voxel of {voxel * 1e3:.2g} mm"
        whole = largest_body(wrap(clean, voxel, progress=report))
        work += corners
        yield (CLEANED, step), _evened(whole, genus, faces, report)
        handles = inspect(whole).genus
        if handles is None or handles <= genus:
            continue
        if handles - genus > MOST_TUNNELS and voxel_mm is None:
            if handles - genus > 0.5 * left:
                return
            left = handles - genus
            continue
        for closing in (voxel, 2 * voxel):
            if work + 2 * corners > MOST_WORK and voxel_mm is None:
                return
            # an offset that closes one tunnel may bring other places together, which part on the
            # way back: only what comes back counts
            wider = largest_body(wrap(clean, voxel, closing, progress=report))
            back = largest_body(wrap(wider, voxel, -closing, progress=report))
            work += 2 * corners
            tunnels = f"tunnels up to {2e3 * closing:.2g} mm wide closed"
            yield (CLEANED, step, tunnels), _evened(back, genus, faces, report)


def _evened(surface: Surface, genus: int, faces: int | None, report: Progress) -> Surface:
    """A wrap in about that many even triangles, if it is worth the work."""
    found = inspect(surface)
    if faces is None or not found.sound or found.genus != genus:
        return surface
    return remesh(surface, edge_length_for(surface, faces), iterations=5, progress=report)


def _hold(
    candidate: Surface, surface: Surface, genus: int, bound: float
) -> tuple[str, tuple[Deviation, Deviation, float] | None]:
    """What speaks against the candidate, or else its measures."""
    found = inspect(candidate)
    if not found.sound:
        return found.faults(), None
    if found.genus != genus:
        return f"genus {found.genus}", None
    if abs(volume(candidate)) < LEAST_VOLUME * diagonal(candidate) ** 3:
        return "it would be flat, with no inside", None
    from_input = deviation(surface, candidate)
    if from_input.p99_mm > bound * 1e3:
        return f"1 % of the input lies more than {from_input.p99_mm:.3g} mm off", None
    points, _ = sample(candidate, SAMPLES, np.random.default_rng(1))
    new_share = float((distances(points, surface) > bound).mean())
    if new_share > MOST_NEW:
        return f"{new_share:.0%} of its area spans holes", None
    return "", (from_input, deviation(candidate, surface), new_share)


def _expected_genus(
    clean: Surface, manifold: Surface, genus_before: int | None, report: Progress
) -> tuple[int, str]:
    """The genus that a repair must keep, and where it is known from."""
    if genus_before is not None:
        return genus_before, "that of the input, which is a closed manifold"
    told = inspect(manifold)
    if told.closed and told.genus is not None:
        return told.genus, "that of the input with its pinched places split"
    size = diagonal(clean)
    found: list[int | None] = []
    for part in CLOSINGS:
        report("looking for handles", len(found) / len(CLOSINGS))
        whole = largest_body(wrap(clean, CLOSINGS[0] * size, part * size))
        found.append(inspect(whole).genus)
    if len(set(found)) == 1 and found[0] is not None:
        widths = ", ".join(f"{2e3 * part * size:.2g}" for part in CLOSINGS)
        return found[0], f"the same with all gaps up to {widths} mm closed"
    if told.genus is not None:
        return told.genus, "that of the input with its holes capped"
    raise SceneError(
        f"the number of handles is not clear: the mesh has {inspect(clean).faults()}, and with "
        f"gaps of different width closed its genus is {', '.join(map(str, found))}. Say how many "
        "handles it has: --genus 0 for a ball, a box, a bottle; 1 for a mug."
    )


def _refusal(before: Soundness, genus: int, reason: str, bound: float, failed: list[str]) -> str:
    return (
        f"no repair keeps the topology and stays near the scan. The mesh has {before.faults()}; "
        f"needed is one closed surface of genus {genus} ({reason}) within {bound * 1e3:.3g} mm of "
        f"99 % of it. Tried: {'; '.join(failed)}. Without --voxel-mm the wraps "
        f"end at {MOST_WORK / 1e6:.3g} million voxel corners. "
        "Ask for another genus (--genus) if that one is wrong, "
        "allow more (--bound-mm), give a smaller voxel (--voxel-mm) for thin walls, or scan "
        "what is missing: a wall seen from one side only cannot be closed. Goals that need no "
        "closed mesh, such as transform, take the scan as it is."
    )


def _check(
    surface: Surface, genus: int | None, bound_mm: float | None, voxel_mm: float | None
) -> None:
    if surface.dimension != 3:
        raise SceneError("a polygon came; a triangle surface is needed for a repair.")
    if genus is not None and genus < 0:
        raise SceneError(f"the genus is {genus}; a number of handles ≥ 0 is needed.")
    for name, value in (("bound", bound_mm), ("voxel", voxel_mm)):
        if value is not None and not 0 < value < float("inf"):
            raise SceneError(f"the {name} is {value} mm; a finite length > 0 is needed.")
