"""The solver is second order against exact harmonic data, on whatever shape."""

import numpy as np
import pytest
import trimesh

from tests.claims.multigrids import solve_exact
from tests.exact.order import observed_order
from touchwarp.scene import Surface, shapes
from touchwarp.scene.vessels import mug

BOX = np.array([[-0.2, -0.2, -0.2], [0.2, 0.2, 0.2]])
EVERYWHERE = 40
SOURCE = np.array([0.01, 0.005, 0.0])
OFF_THE_GRID = np.array([0.003, 0.001, -0.002])


def field(points):
    d = points - SOURCE
    r = np.linalg.norm(d, axis=1, keepdims=True)
    return 2e-5 * d / r**3 + 1e-3 / r * np.array([1.0, -0.5, 0.25])


def wave(points):
    """Harmonic everywhere, so also in a mug's cavity; it turns within 3 cm."""
    k = 30.0
    x, y, z = points.T
    return 1e-3 * np.stack(
        [
            np.exp(k * x) * np.cos(k * y),
            np.exp(k * y) * np.sin(k * z),
            np.exp(-k * z) * np.cos(k * x),
        ],
        axis=1,
    )


def errors_on(surface, field=field, **options):
    """Spacings, and root mean square errors in Ω, of three uniform grids."""
    spacings, errors = [], []
    for n in (0, 1, 2):
        grid, error = solve_exact(surface, field, BOX, n, margin=EVERYWHERE, **options)
        spacings.append(grid.frame.spacing[0] / 2**n)
        errors.append(np.sqrt(np.nanmean(error[-1] ** 2)))
    return spacings, errors


def ball():
    """A sphere of radius 5 cm whose triangles are fine enough to carry the field's values."""
    sphere = trimesh.creation.icosphere(subdivisions=7, radius=0.05)
    return Surface(np.array(sphere.vertices) + OFF_THE_GRID, np.array(sphere.faces))


def block():
    """A box whose faces are fine enough to carry the field's values."""
    box = trimesh.creation.box((0.101, 0.097, 0.103))
    for _ in range(6):
        box = box.subdivide()
    return Surface(np.array(box.vertices), np.array(box.faces))


def coffee_mug():
    """The mug, about the middle of its height, its triangles as fine."""
    surface = mug()
    vertices, faces = trimesh.remesh.subdivide_to_size(
        surface.vertices, surface.faces, 0.003, max_iter=20
    )
    return Surface(vertices - np.array([0.003, 0.001, 0.0473]), faces)


@pytest.mark.parametrize(("make", "exact"), [(ball, field), (block, field), (coffee_mug, wave)])
def test_solution_is_second_order(make, exact):
    spacings, errors = errors_on(make(), exact)
    assert observed_order(spacings, errors) == pytest.approx(2.0, abs=0.15)


def test_order_claim_rejects_a_misplaced_wall():
    spacings, errors = errors_on(ball(), wall_shift=0.002)
    assert observed_order(spacings, errors) < 1.5


def test_an_interface_that_cuts_a_flat_face_adds_no_error():
    grid, alone = solve_exact(block(), field, BOX, 0)
    _, half = solve_exact(block(), field, BOX, 2, only=lambda p: p[:, 0] > 0.0)
    coarse = np.nanmax(alone[grid.root])
    for error in half[grid.root :]:
        assert np.nanmax(error) < 1.2 * coarse


def test_nodes_on_the_surface_let_no_path_through():
    # Its six poles lie on nodes.
    sphere = shapes.sphere(0.05, facet_mm=0.02)
    grid, error = solve_exact(sphere, field, BOX, 1)
    for stage, size in zip(grid.stages, error, strict=True):
        points = grid.frame.to_scene(stage.level.coordinates() / 2.0**stage.level.depth)
        inside = np.linalg.norm(points, axis=1) < 0.0499
        assert np.isnan(size[inside]).all()
