import numpy as np
import pytest

from tests.exact.order import observed_order

SPACINGS = np.array([4.0, 2.0, 1.0, 0.5])


@pytest.mark.parametrize("order", [0.0, 1.0, 2.0])
def test_the_order_of_invented_errors_is_found(order):
    assert observed_order(SPACINGS, 3.0 * SPACINGS**order) == pytest.approx(order, abs=1e-12)


def test_an_error_floor_lowers_the_order():
    assert observed_order(SPACINGS, SPACINGS**2 + 5.0) < 1.0


@pytest.mark.parametrize("errors", [[1.0, 2.0], [1.0, 2.0, 3.0]])
def test_too_few_or_unmatched_errors_are_refused(errors):
    with pytest.raises(ValueError, match="need 3 or more each"):
        observed_order([4.0, 2.0], errors)
