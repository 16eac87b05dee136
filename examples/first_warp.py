"""A first warp, from a scene built in code.

A ball of 5 cm radius is real; what is seen is a ball 2 cm to its right. The warp tells, for each
position of the real hand, where it must be displayed, so that it is seen to touch the virtual ball
exactly when it touches the real one.

Results:
    touched: (3,) m, a point on the real ball.
    shown: (3,) m, where the hand there is displayed: on the virtual ball.
    far: (3,) m, the displacement outside the outer boundary: none.
    loaded: the warp as read back from its file.
"""

import numpy as np

import touchwarp as tw
from touchwarp.scene.shapes import sphere

scene = tw.Scene(
    props=[tw.Prop("ball", sphere(0.05), tw.TransformGoal(translation=(0.02, 0, 0)))],
    objective=tw.Objective(tolerance_mm=0.5),
)
warp = tw.solve(scene)

touched = np.array([0.0, 0.0, 0.05])
shown = warp(touched)
far = warp.displacement([1.0, 0.0, 0.0])

warp.save("ball.warp")
loaded = tw.load_warp("ball.warp")

if __name__ == "__main__":
    print(f"A hand at {touched} m is displayed at {shown.round(4)} m.")
    print(f"Estimated error: {warp.meta.estimated_error_max_mm:.2g} mm at most.")
    print("Saved as ball.warp; next: touchwarp info ball.warp")
