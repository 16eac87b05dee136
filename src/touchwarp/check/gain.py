"""Gain: how much faster or slower than the real hand the displayed one moves, by direction."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from touchwarp.check.case import Case, Finding
from touchwarp.check.report import measured, place

Float = NDArray[np.float64]

_DETAIL = (
    "Singular values of ∂f. Studies give thresholds for whole reaches, which say nothing about a "
    "point; see the reaches."
)


def check_gain(case: Case) -> Finding:
    """Singular values of ∂f in Ω: the extremes, and how much of Ω is far from 1."""
    probes = case.probes
    gain = probes.gain
    high, low = gain[:, 0], gain[:, -1]
    volume = probes.volume / probes.volume.sum()
    top, bottom = int(np.nan_to_num(high, nan=np.inf).argmax()), int(np.nan_to_num(low).argmin())
    p99, p1 = _quantile(high, volume, 0.99), _quantile(low, volume, 0.01)
    return Finding(
        [
            measured(
                "gain.greatest",
                "Greatest gain in Ω",
                float(high[top]),
                "×",
                group="judged",
                where=place(probes.points, top),
                detail=f"99 % of Ω is below {p99:.3g}. {_DETAIL}",
            ),
            measured(
                "gain.least",
                "Least gain in Ω",
                float(low[bottom]),
                "×",
                group="judged",
                where=place(probes.points, bottom),
                detail=f"99 % of Ω is above {p1:.3g}. {_DETAIL}",
            ),
        ],
        {"high": high, "low": low, "volume": volume},
    )


def _quantile(values: Float, weights: Float, share: float) -> float:
    order = np.argsort(values)
    below = np.cumsum(weights[order])
    return float(values[order][min(int(np.searchsorted(below, share)), len(values) - 1)])
