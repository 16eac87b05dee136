"""A goal that no transform can say.

A goal is a pair of point lists: where the prop is touched, and where that must appear. Here a ball
is felt as an egg, thinner towards its top. The points must be those of the prop's surface; how
their images are found (by formula as here, by matching two scans, by hand) is your affair.

Results:
    goal: the goal on the ball's points.
    warp: its warp.
    touched: (3,) m, a point on the upper half of the ball.
    wanted: (3,) m, where the formula wants it displayed.
    shown: (3,) m, where the warp displays it.
"""

import numpy as np

import touchwarp as tw
from touchwarp.scene.shapes import sphere

RADIUS = 0.04


def egg(points: np.ndarray) -> np.ndarray:
    """The ball's points, (n, 3) m, on the egg: up to a quarter thinner at the top."""
    thinner = 1 - 0.25 * points[:, 2:] / RADIUS
    return np.hstack([points[:, :2] * thinner, points[:, 2:]])


ball = sphere(RADIUS, facet_mm=0.1)
goal = tw.Goal(ball.vertices, egg(ball.vertices), ball.faces)
scene = tw.Scene(
    props=[tw.Prop("ball", ball, goal)],
    objective=tw.Objective(tolerance_mm=0.5),
)
warp = tw.solve(scene)

touched = ball.vertices[np.argmax(ball.vertices @ [0.6, 0.0, 0.8])]
wanted = egg(touched[None])[0]
shown = warp(touched)

if __name__ == "__main__":
    print(f"{touched.round(4)} m is shown at {shown.round(4)} m; wanted: {wanted.round(4)} m.")
    print(tw.check(scene, warp).status)
