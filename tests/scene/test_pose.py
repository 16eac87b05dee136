"""Angles and matrices of a pose say the same."""

from __future__ import annotations

import numpy as np
import pytest

from touchwarp.scene.pose import angles_deg, rotation_matrix


@pytest.mark.parametrize(
    "angles", [(0, 0, 0), (10, -20, 150), (-170, 80, -30), (0, 90, 0), (25, 90, 40), (10, -90, 70)]
)
def test_angles_give_the_rotation_again(angles: tuple[float, float, float]) -> None:
    # also where two of the axes fall together, and without a warning
    R = rotation_matrix(angles)
    np.testing.assert_allclose(rotation_matrix(angles_deg(R)), R, atol=1e-7)


def test_the_order_of_the_axes_matters() -> None:
    other = (
        rotation_matrix((0, 0, 50)).T @ rotation_matrix((30, 40, 0)) @ rotation_matrix((0, 0, 9))
    )
    assert not np.allclose(rotation_matrix(angles_deg(other)[::-1]), other, atol=1e-3)
