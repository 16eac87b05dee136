"""A virtual object that is dragged and turned, with no new solve.

The equation is linear in the goal, and an affine goal is twelve numbers. `solve_bases` solves once
for each of them; after that the warp of every position, orientation and size is a sum.

Results:
    bases: solved once.
    frames: by angle in degrees, the warp of the box turned so far and moved 2 cm.
    solved: a warp solved afresh for the last of them, to compare with.
    milliseconds: the mean time from a new transform to a usable warp.
"""

from time import perf_counter

import numpy as np

import touchwarp as tw
from touchwarp.scene.shapes import box


def goal_at(angle_deg: float) -> tw.TransformGoal:
    """The box turned about its middle and moved by 2 cm."""
    return tw.TransformGoal(
        pivot="centre", rotation_deg=(0, 0, angle_deg), translation=(0.02, 0, 0)
    )


prop = tw.Prop("box", box([0.1, 0.06, 0.08]), goal_at(30))
scene = tw.Scene(
    props=[prop],
    outer=tw.Outer(box=[[-0.25, -0.25, -0.25], [0.25, 0.25, 0.25]]),
    objective=tw.Objective(tolerance_mm=0.5),
)
bases = tw.solve_bases(scene)

frames = {}
start = perf_counter()
for angle_deg in (0, 10, 20, 30):
    transform = goal_at(angle_deg).affine(prop.surface.bounds)
    frames[angle_deg] = bases.warp({"box": transform})
milliseconds = (perf_counter() - start) / len(frames) * 1e3

solved = tw.solve(scene)

if __name__ == "__main__":
    points = np.random.default_rng(0).uniform(-0.2, 0.2, (1000, 3))
    beyond = np.abs(points) - prop.surface.bounds[1]  # inside the box there is nothing to touch
    points = points[np.linalg.norm(np.maximum(beyond, 0.0), axis=1) > 0.002]
    difference = np.abs(frames[30](points) - solved(points)).max()
    print(f"{milliseconds:.2f} ms from a new transform to its warp.")
    print(f"It differs from a solve of its own by at most {difference * 1e3:.3f} mm.")
    print('Keep one: bases.table({"box": transform}).save("box.warp")')
