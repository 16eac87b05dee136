"""A prop that is picked up takes its warp along.

The tracker tells where the prop is now, as a rigid transform from where it was when the scene was
solved. `at` gives the warp there, sharing the table, with no solve.

Results:
    still, carried: the warp before and after.
    pose: (4, 4), where the prop has been carried: T_room_scene.
    touched: (3,) m, a point on the prop, in the scene.
    touched_now: (3,) m, the same point of the prop, carried.
"""

import numpy as np

import touchwarp as tw
from touchwarp.scene import pose_matrix
from touchwarp.scene.shapes import cylinder

scene = tw.Scene(
    props=[tw.Prop("tin", cylinder(0.04, 0.1), tw.TransformGoal(scale=(1.2, 1.2, 0.8)))],
    objective=tw.Objective(tolerance_mm=0.5),
)
still = tw.solve(scene)

pose = pose_matrix([0.3, -0.1, 0.25], [0, 20, 75])
carried = still.at(pose)

touched = np.array([0.04, 0.0, 0.05])
touched_now = pose[:3, :3] @ touched + pose[:3, 3]

if __name__ == "__main__":
    print(f"On the table, {touched} m is shown at {still(touched).round(4)} m;")
    print(f"carried, {touched_now.round(4)} m is shown at {carried(touched_now).round(4)} m.")
