"""Beside a goal that rises to a sharp peak the table keeps its tolerance, by ever finer cells."""

import numpy as np

import touchwarp as tw
from touchwarp.solve import marking

HALF_SIDE, TOLERANCE_MM, EDGE_RADIUS_MM = 0.02, 0.1, 2.0
RINGS = HALF_SIDE * 0.6 ** np.arange(19)  # squares on the box's upper face, to 2 µm
RISE = 1e-2 * (1.0 - (RINGS / HALF_SIDE) ** 0.2)
PEAK = RISE[-1] + (RISE[-1] - RISE[-2]) / (RINGS[-2] - RINGS[-1]) * RINGS[-1]
OUTER = tw.Outer(box=[[-0.083, -0.087, -0.0811], [0.0897, 0.0853, 0.0889]])


def warp_of_peak():
    """A box whose upper face is shown displaced in x: not at its edges, by 9 mm in its middle."""
    square = np.array([[-1.0, -1.0], [1.0, -1.0], [1.0, 1.0], [-1.0, 1.0]])
    rings = [np.column_stack([r * square, np.full(4, HALF_SIDE)]) for r in RINGS]
    bottom = np.column_stack([HALF_SIDE * square, np.full(4, -HALF_SIDE)])
    vertices = np.concatenate([bottom, *rings, [[0.0, 0.0, HALF_SIDE]]])
    faces = [[0, 2, 1], [0, 3, 2]]
    for first in range(0, 4 * len(RINGS), 4):
        for j in range(4):
            a, b = first + j, first + (j + 1) % 4
            faces += [[a, b, b + 4], [a, b + 4, a + 4]]
    faces += [[len(vertices) - 5 + j, len(vertices) - 5 + (j + 1) % 4, -1] for j in range(4)]
    faces = np.array(faces) % len(vertices)
    shown = vertices.copy()
    shown[:, 0] += np.concatenate([np.zeros(4), np.repeat(RISE, 4), [PEAK]])
    goal = tw.VerticesGoal(tw.Surface(shown, faces))
    prop = tw.Prop("box", tw.Surface(vertices, faces), goal)
    objective = tw.Objective(tolerance_mm=TOLERANCE_MM, edge_radius_mm=EDGE_RADIUS_MM)
    return tw.solve(tw.Scene([prop], OUTER, objective))


def greatest_error_mm(warp):
    """At points 5 to 200 µm above the peak, by the mean of g over all directions down from there.

    That is u over a plane; the box's face ends where g is 0, a hundred times as far away.
    """
    rng = np.random.default_rng(0)
    heights = 10 ** rng.uniform(-5.3, -3.7, 500)
    across = rng.normal(size=(500, 2)) * 10 ** rng.uniform(-6, -4, (500, 1))
    k = np.arange(40_000) + 0.5
    down, turn = k / len(k), np.pi * (1 + np.sqrt(5)) * k
    slope = (np.sqrt(1 - down**2) * [np.cos(turn), np.sin(turn)]).T / down[:, None]
    radii, rise = np.append(0.0, RINGS[::-1]), np.append(PEAK, RISE[::-1])
    true = [
        np.interp(np.abs(x + h * slope).max(axis=1), radii, rise, right=0.0).mean()
        for x, h in zip(across, heights, strict=True)
    ]
    points = np.column_stack([across, HALF_SIDE + heights])
    return 1e3 * np.abs(warp.displacement(points)[:, 0] - true).max()


def test_the_table_keeps_its_tolerance_beside_a_peak():
    warp = warp_of_peak()
    assert warp.solution.estimated_error_max_mm <= TOLERANCE_MM
    assert greatest_error_mm(warp) <= TOLERANCE_MM


def test_it_does_not_where_cells_stay_larger_and_the_estimate_says_so(monkeypatch):
    monkeypatch.setattr(marking, "FURTHER", 0)
    warp = warp_of_peak()
    assert warp.solution.estimated_error_max_mm > TOLERANCE_MM
    assert greatest_error_mm(warp) > 2 * TOLERANCE_MM
