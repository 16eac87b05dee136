"""The finite-element peers' fields reach table and points without loss."""

import importlib
import sys
from pathlib import Path

import numpy as np
import pytest
from scipy.spatial import Delaunay

FOLDER = Path(__file__).resolve().parents[2] / "benchmarks" / "fem"


@pytest.fixture(scope="module")
def tetrahedra():
    # Under its own name: numba's cache of compiled code refers to the module by it.
    sys.path.insert(0, str(FOLDER))
    yield importlib.import_module("tetrahedra")
    sys.path.remove(str(FOLDER))


def quadratic(x):
    a, b, c = x[..., 0], x[..., 1], x[..., 2]
    return np.stack([a * b - c**2, 1.0 + a - 2.0 * b * c, b**2 + 3.0 * c], axis=-1)


@pytest.fixture
def corners():
    points = np.random.default_rng(1).uniform(0.0, 1.0, (60, 3))
    points = np.concatenate([points, np.array(list(np.ndindex(2, 2, 2)), dtype=float)])
    return points[Delaunay(points).simplices]


def nodal(corners, edges):
    return quadratic(np.concatenate([corners, corners[:, edges].mean(axis=2)], axis=1))


def test_a_quadratic_field_is_rasterised_exactly(tetrahedra, corners):
    axes = [np.linspace(0.1, 0.9, n) for n in (7, 9, 11)]
    table = tetrahedra.rasterise(corners, nodal(corners, tetrahedra.EDGES), axes)
    x = np.stack(np.meshgrid(*axes, indexing="ij"), axis=-1)
    np.testing.assert_allclose(table, quadratic(x), atol=1e-9)


def test_a_quadratic_field_is_evaluated_exactly(tetrahedra, corners):
    x = np.random.default_rng(2).uniform(0.05, 0.95, (500, 3))
    u = tetrahedra.evaluate(corners, nodal(corners, tetrahedra.EDGES), x)
    np.testing.assert_allclose(u, quadratic(x), atol=1e-9)


def test_exactness_claim_rejects_linear_elements(tetrahedra, corners):
    values = nodal(corners, tetrahedra.EDGES)
    values[:, 4:] = values[:, :4][:, tetrahedra.EDGES].mean(axis=2)
    x = np.random.default_rng(2).uniform(0.05, 0.95, (500, 3))
    assert np.abs(tetrahedra.evaluate(corners, values, x) - quadratic(x)).max() > 1e-3


def test_points_outside_the_mesh_are_refused(tetrahedra, corners):
    values = nodal(corners, tetrahedra.EDGES)
    with pytest.raises(ValueError, match="1 points are not in the finite-element mesh"):
        tetrahedra.evaluate(corners, values, np.array([[0.5, 0.5, 0.5], [9.0, 9.0, 9.0]]))
