"""Two tracked hands, frame by frame.

A headset delivers 26 joints a hand, some of which are lost now and then. One call displaces both
hands; a lost joint (nan) stays lost and raises nothing. `inverse` answers the opposite question:
where must the real joint be, so that it is displayed here?

Results:
    hands: (2, 26, 3) m, tracked.
    shown: (2, 26, 3) m, to be displayed.
    back: the inverse of `shown`: points (2, 26, 3) m and found (2, 26).
    microseconds: the time of one call, both hands.
"""

from time import perf_counter

import numpy as np

import touchwarp as tw
from touchwarp.scene.shapes import box

scene = tw.Scene(
    props=[tw.Prop("box", box([0.1, 0.1, 0.1]), tw.TransformGoal(scale=(1.15, 1.0, 0.9)))],
    objective=tw.Objective(tolerance_mm=0.5),
)
warp = tw.solve(scene)

random = np.random.default_rng(0)
palms = np.array([[[-0.12, 0.0, 0.02]], [[0.12, 0.0, 0.02]]])
hands = palms + random.uniform(-0.03, 0.03, (2, 26, 3))
hands[1, 7] = np.nan  # the tracker has lost this joint

shown = warp(hands)
start = perf_counter()
for _ in range(90):
    shown = warp(hands)
microseconds = (perf_counter() - start) / 90 * 1e6

back = warp.inverse(shown)

if __name__ == "__main__":
    print(f"Displaced by up to {np.nanmax(np.abs(shown - hands)) * 1e3:.1f} mm.")
    print(f"{microseconds:.0f} µs for both hands; at 90 Hz a frame has 11,000 µs.")
    print(f"{back.found.sum()} of {back.found.size} joints found again by the inverse.")
