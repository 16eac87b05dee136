import numpy as np
import pytest

from tests.exact import segment as exact
from touchwarp.errors import SolveError
from touchwarp.solve.segment import Segment, solve_segment


@pytest.mark.parametrize("screening", [0.0, 1e-9, 1.0, 100.0, 1e4])
def test_closed_form_agrees_with_the_paper_s_hyperbolic_functions(screening):
    x = np.linspace(0.05, 0.4, 101)
    segment = Segment(0.05, 0.4, 0.02, -0.01, screening)
    truth = exact.displacement(x, 0.05, 0.4, 0.02, -0.01, screening)
    np.testing.assert_allclose(segment.displacement(x), truth, rtol=0, atol=1e-15)


def test_closed_form_survives_a_weight_that_overflows_sinh():
    u = Segment(0.0, 1.0, 0.02, 0.0, screening=1e8).displacement([0.0, 1e-4, 0.5, 1.0])
    np.testing.assert_allclose(u, [0.02, 0.02 * np.exp(-1.0), 0.0, 0.0], atol=1e-12)


def test_closed_form_is_nan_outside_the_segment():
    u = Segment(0.0, 1.0, 0.02).displacement([-0.1, 0.5, 1.1, np.nan])
    assert np.isnan(u).tolist() == [True, False, True, True]


def test_one_node_is_enough_to_solve_on():
    nodes, u = solve_segment(Segment(0.0, 0.4, 0.02), spacing=0.3)
    np.testing.assert_allclose(nodes, [0.3])
    np.testing.assert_allclose(u, [0.005])


@pytest.mark.parametrize(
    ("values", "message"),
    [
        ((0.0, np.nan, 0.02), "finite numbers are needed"),
        ((0.4, 0.4, 0.02), "its start must lie below its stop"),
        ((0.0, 0.4, 0.02, 0.0, -1.0), "a finite number ≥ 0 is needed"),
    ],
)
def test_an_unusable_segment_says_what_is_needed(values, message):
    with pytest.raises(SolveError, match=message):
        Segment(*values)


@pytest.mark.parametrize(
    ("spacing", "message"), [(0.0, "a finite number > 0"), (2.0, "choose a smaller spacing")]
)
def test_an_unusable_spacing_says_what_is_needed(spacing, message):
    with pytest.raises(SolveError, match=message):
        solve_segment(Segment(0.1, 0.4, 0.02), spacing)
