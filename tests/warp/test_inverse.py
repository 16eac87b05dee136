"""Where the real hand must be: the nearest root, also where the warp folds."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
import pytest

from tests.exact.spheres import SphereWarp, radial
from tests.warp.tables import (
    FOLDING,
    META,
    SPHERE,
    fold_bricks,
    points_in,
    sliding_bricks,
    sphere_table,
    turned,
    turned_bricks,
)
from touchwarp.warp.inverse import find_inverse
from touchwarp.warp.meta import WarpMeta
from touchwarp.warp.table import TableWarp


def shells(count: int = 300, seed: int = 0) -> np.ndarray:
    """Displayed positions around the folded shell of `FOLDING`, r from 20 to 150 mm."""
    random = np.random.default_rng(seed)
    directions = random.normal(size=(count, 3))
    directions /= np.linalg.norm(directions, axis=1, keepdims=True)
    r = random.uniform(0.02, 0.15, count)
    # the fold shows r from 93 to 100 mm three times
    r[::2] = random.uniform(0.09, 0.101, len(r[::2]))
    return directions * r[:, None]


def nearest_radial_roots(warp: SphereWarp, shown: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """By brute force along the ray of each position: distance to the nearest root, and how many."""
    r = np.linspace(-0.2, 0.2, 400_001)
    between = np.clip(np.abs(r), warp.radius, warp.outer_radius)
    first = radial(between, warp.radius, warp.outer_radius, warp.screening)[2]
    f = r * (1.0 + first * warp.stretch[0, 0])
    distance, count = [], []
    for y in np.linalg.norm(shown, axis=1):
        crossing = np.flatnonzero(np.sign(f[1:] - y) != np.sign(f[:-1] - y))
        step = (y - f[crossing]) / (f[crossing + 1] - f[crossing])
        roots = r[crossing] + step * (r[1] - r[0])
        distance.append(np.abs(roots - y).min())
        count.append(len(roots))
    return np.array(distance), np.array(count)


@pytest.mark.parametrize("screening", [0.0, 400.0])
def test_under_folds_the_nearest_root_is_found(screening: float) -> None:
    warp, shown = replace(FOLDING, screening=screening), shells()
    nearest, count = nearest_radial_roots(warp, shown)
    assert (count >= 3).sum() > 20, "the case folds"
    inverse = warp.inverse(shown)
    assert inverse.found.all()
    np.testing.assert_allclose(warp(inverse.points), shown, atol=1e-9)
    np.testing.assert_allclose(np.linalg.norm(inverse.points - shown, axis=1), nearest, atol=1e-7)


def test_the_nearest_claim_rejects_one_newton_run_from_the_query() -> None:
    shown = shells()
    nearest, _ = nearest_radial_roots(FOLDING, shown)
    x = shown.copy()
    for _ in range(60):
        residual = (FOLDING(x) - shown)[..., None]
        x = x - 0.5 * np.linalg.solve(FOLDING.jacobian(x), residual)[..., 0]
    distance = np.linalg.norm(x - shown, axis=1)
    assert (~(np.abs(distance - nearest) < 1e-6)).any()


def test_a_table_finds_what_the_closed_form_finds() -> None:
    table, shown = TableWarp(fold_bricks(), META), shells()
    nearest, _ = nearest_radial_roots(FOLDING, shown)
    inverse = table.inverse(shown)
    assert inverse.found.all()
    np.testing.assert_allclose(table(inverse.points), shown, atol=1e-12)
    # the table is off by 0.2 mm at most, which near the edge of a fold moves roots by more
    away = np.abs(np.linalg.norm(inverse.points - shown, axis=1) - nearest)
    assert np.quantile(away, 0.95) < 2e-4


def test_the_search_of_a_table_is_exhaustive() -> None:
    """No root found from 400 starts is nearer than the one the search gives."""
    table, shown = TableWarp(fold_bricks(2), META), shells(150, seed=1)
    searched = np.linalg.norm(table.inverse(shown).points - shown, axis=1)
    tried = find_inverse(table, shown, starts=400)
    from_starts = np.linalg.norm(tried.points - shown, axis=1)
    assert tried.found.mean() > 0.95
    assert not (from_starts < searched - 1e-8).any()


def test_one_start_alone_misses_roots_that_the_search_finds() -> None:
    table, shown = TableWarp(fold_bricks(2), META), shells(400, seed=1)
    assert table.inverse(shown).found.all()
    assert not find_inverse(table, shown, starts=1).found.all()


def test_a_turned_table_with_oblong_cells_is_inverted() -> None:
    table = TableWarp(turned_bricks(), WarpMeta())
    shown = points_in(turned_bricks(), 400, seed=2)
    inverse = table.inverse(shown)
    assert inverse.found.all()
    np.testing.assert_allclose(table(inverse.points), shown, atol=1e-12)
    T = turned()
    again = table.at(T).inverse(shown @ T[:3, :3].T + T[:3, 3])
    np.testing.assert_allclose(again.points, inverse.points @ T[:3, :3].T + T[:3, 3], atol=1e-9)


def test_inverse_and_warp_undo_each_other_where_nothing_folds() -> None:
    warp = sphere_table()
    x = np.random.default_rng(4).uniform(-0.19, 0.19, (200, 3))
    x = x[np.linalg.det(warp.jacobian(x)) > 0.4]
    back = warp.inverse(warp(x))
    np.testing.assert_allclose(back.points, x, atol=1e-9)
    np.testing.assert_allclose(SPHERE.inverse(SPHERE(x)).points, x, atol=1e-7)


def test_positions_over_and_under_a_sliding_plane_are_inverted() -> None:
    table = TableWarp(sliding_bricks(), WarpMeta())
    # clear of the source, and of the border, where this field is not 0
    shown = points_in(sliding_bricks(), 400, seed=2, margin=-0.1)
    shown[::3, 2] *= -0.2
    shown = shown[np.linalg.norm(shown * [1, 1, 0], axis=1) > 0.08]
    inverse = table.inverse(shown)
    assert inverse.found.all()
    np.testing.assert_allclose(table(inverse.points), shown, atol=1e-8)
    # a hand on the table stays on it
    flat = shown[shown[:, 2] > 0.0] * [1.0, 1.0, 0.0]
    np.testing.assert_allclose(table.inverse(flat).points[:, 2], 0.0, atol=1e-9)


def test_nan_rows_and_shapes() -> None:
    warp = sphere_table()
    hands = np.random.default_rng(0).uniform(-0.1, 0.1, (2, 26, 3))
    hands[1, 3, 0] = np.nan
    for inverse in (warp.inverse(hands), find_inverse(SPHERE, hands)):
        assert inverse.points.shape == (2, 26, 3)
        assert inverse.found.shape == (2, 26)
        assert inverse.found.sum() == 51
        assert np.isnan(inverse.points[1, 3]).all()
    assert warp.inverse(np.empty((0, 3))).points.shape == (0, 3)
    one = warp.inverse([0.3, 0.0, 0.0])
    np.testing.assert_array_equal(one.points, [0.3, 0.0, 0.0])
    assert one.found.shape == ()


@pytest.mark.parametrize("inverse", [SPHERE.inverse, lambda x: sphere_table().inverse(x)])
def test_a_wrong_shape_raises(inverse) -> None:
    with pytest.raises(ValueError, match=r"Points have shape \(4, 2\); \(\.\.\., 3\) is needed"):
        inverse(np.zeros((4, 2)))


@dataclass(frozen=True)
class Torn(SphereWarp):
    """Pulled apart along x = 0: nothing is displayed within 2 cm of that plane."""

    def displacement(self, x):
        x = np.asarray(x, float)
        return np.where(x[..., :1] < 0.0, [-0.02, 0.0, 0.0], [0.02, 0.0, 0.0]) + 0.0 * x

    def jacobian(self, x):
        return np.broadcast_to(np.eye(3), (*np.shape(x), 3)).copy()


def test_where_nothing_is_displayed_no_root_is_found() -> None:
    inverse = find_inverse(Torn(), [[0.01, 0.0, 0.0], [0.03, 0.0, 0.0]], reach=0.03)
    assert inverse.found.tolist() == [False, True]
    assert np.isnan(inverse.points[0]).all()
    np.testing.assert_allclose(inverse.points[1], [0.01, 0.0, 0.0], atol=1e-9)


def test_the_reach_is_estimated_where_it_is_not_known() -> None:
    class Unknown:
        dimension = 3
        displacement = staticmethod(FOLDING.displacement)
        jacobian = staticmethod(FOLDING.jacobian)

    shown = shells(100)
    nearest, _ = nearest_radial_roots(FOLDING, shown)
    inverse = find_inverse(Unknown(), shown)  # type: ignore[arg-type]
    np.testing.assert_allclose(np.linalg.norm(inverse.points - shown, axis=1), nearest, atol=1e-7)


def test_plane_warps_are_inverted() -> None:
    class Swirl:
        dimension = 2
        max_displacement = 0.2

        def displacement(self, x):
            return 0.1 * np.stack([np.sin(3 * x[..., 1]), np.sin(2 * x[..., 0])], axis=-1)

        def jacobian(self, x):
            slope = np.zeros((*x.shape, 2))
            slope[..., 0, 1] = 0.3 * np.cos(3 * x[..., 1])
            slope[..., 1, 0] = 0.2 * np.cos(2 * x[..., 0])
            return np.eye(2) + slope

    y = np.random.default_rng(0).uniform(-1, 1, (50, 2))
    inverse = find_inverse(Swirl(), y)  # type: ignore[arg-type]
    assert inverse.found.all()
    np.testing.assert_allclose(inverse.points + Swirl().displacement(inverse.points), y, atol=1e-9)
