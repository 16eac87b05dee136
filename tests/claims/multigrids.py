"""Grids of given spacings around a surface, solved for exact harmonic data."""

import numpy as np

from touchwarp.solve.boundary import Boundary
from touchwarp.solve.frame import frame_of_box
from touchwarp.solve.multigrid import Multigrid
from touchwarp.solve.refine import unique_rows, widened
from touchwarp.solve.region import flood_level


def solve_exact(surface, field, box, levels, *, margin=2, only=None, wall_shift=0.0):
    """Solve Δu = 0 with the values of `field` on a surface and on the outer box.

    Args:
        surface: a Surface, m.
        field: (k, 3) m to (k, 3) m, harmonic outside the surface.
        box: (2, 3) m.
        levels: refined levels to add around the surface.
        margin: octants of refinement around every cut cell.
        only: (k, 3) m to (k,) bool, where refinement may be.
        wall_shift: m, by which the surface is misplaced (for twins).

    Returns:
        Multigrid, and for each stage the error (n,) m at nodes in Ω, NaN elsewhere.
    """
    frame = frame_of_box(np.asarray(box, float))
    moved = surface.vertices + wall_shift * np.array([1.0, 0.0, 0.0])
    faces = surface.faces.astype(np.int32)
    grid = Multigrid(
        frame, Boundary(frame.to_grid(moved), faces, np.zeros(len(faces), np.int16)), 0.0
    )
    for _ in range(levels):
        stage = grid.stages[-1]
        where = stage.level.coordinates(stage.cuts.node) // 4
        octants = widened(stage, unique_rows(where, stage.level.cells // 4), margin)
        if only is not None:
            centres = frame.to_scene((octants + 0.5) * 4.0 / 2.0**stage.level.depth)
            octants = octants[only(centres)]
        grid.refine(octants)
    data = np.zeros((len(moved), 4))
    data[:, :3] = field(surface.vertices)
    for i, stage in enumerate(grid.stages):
        grid.set_stage_goal(i, data)
        rim = slice(stage.level.n_inner, None)
        where = stage.level.coordinates(rim) / 2.0**stage.level.depth
        outer = ((where == 0) | (where == frame.root_cells)).any(axis=1)
        exact = field(frame.to_scene(where))
        if i == 0:
            stage.u[rim, :3] = exact
            grid.smooth(0, 60)
            continue
        grid.start_from_coarser(i)
        kept = stage.u[rim, :3]
        kept[outer] = exact[outer]
        stage.u[rim, :3] = kept
        for _ in range(2):
            grid.cycle(i)
    for _ in range(4):
        grid.cycle()
    errors, region = [], None
    for i, stage in enumerate(grid.stages):
        region = flood_level(stage, region, grid.stages[i - 1] if i else None, grid.boundary.owner)
        points = frame.to_scene(stage.level.coordinates() / 2.0**stage.level.depth)
        size = np.linalg.norm(stage.u[:, :3] - field(points), axis=1)
        errors.append(np.where(region == 1, size, np.nan))
    return grid, errors
