"""Eq. 9: the segment, in the hyperbolic functions of the paper."""

import numpy as np


def displacement(x, start, stop, displacement_start, displacement_stop, screening):
    """u at x: u'' = λ u between `start` and `stop`, given at both; λ = `screening`, m⁻²."""
    length = stop - start
    if screening == 0:
        return displacement_start + (displacement_stop - displacement_start) * (x - start) / length
    s = np.sqrt(screening)
    return (
        displacement_start * np.sinh(s * (stop - x)) + displacement_stop * np.sinh(s * (x - start))
    ) / np.sinh(s * length)
