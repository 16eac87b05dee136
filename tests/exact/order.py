"""The order of convergence seen in a row of errors."""

import numpy as np


def observed_order(spacings, errors):
    """Slope of log(error) over log(spacing), by least squares."""
    spacings, errors = np.asarray(spacings, float), np.asarray(errors, float)
    if spacings.shape != errors.shape or len(errors) < 3:
        raise ValueError(f"{len(errors)} errors for {len(spacings)} spacings; need 3 or more each.")
    return float(np.polyfit(np.log(spacings), np.log(errors), 1)[0])
