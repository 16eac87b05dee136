import { Vector3 } from "three";
import type { Calibration } from "./assess.js";
import type { Pose } from "./pose.js";
import { type ContactSurface, SurfaceFoot } from "./surface.js";

/** A prop's goal: where each vertex of its surface shall appear, prop frame. */
export interface SurfaceGoal {
  readonly surface: ContactSurface;
  /** (n, 3) m, row by row as the surface's positions. */
  readonly virtual: Float32Array;
}

/** g at a point of the surface: linear on each triangle. */
export function goalAt(
  { surface, virtual }: SurfaceGoal,
  foot: SurfaceFoot,
  out: Vector3,
): Vector3 {
  surface.weights(foot.face, foot.point, weights);
  out.set(0, 0, 0);
  for (let k = 0; k < 3; k++) {
    corner.fromArray(virtual, 3 * surface.faces[3 * foot.face + k]!);
    out.addScaledVector(corner, weights.getComponent(k));
  }
  return out;
}

/**
 * How far displayed contacts would differ if a rival pose were the true one, m: the greatest over the
 * surface of |T g(T⁻¹ p) − T′ g(T′⁻¹ p)| for p on the prop at T.
 *
 * Where this is small, the person cannot tell the poses apart: a round mug shown as a round cup may
 * be turned as it likes.
 */
export function displayedDifference(goal: SurfaceGoal, best: Pose, rival: Pose): number {
  const foot = new SurfaceFoot();
  const [one, other, place] = [new Vector3(), new Vector3(), new Vector3()];
  let greatest = 0;
  for (const { point } of goal.surface.sample(150)) {
    goalAt(goal, goal.surface.nearest(point, foot), one);
    best.toRoom(one, one);
    best.toRoom(point, place);
    goalAt(goal, goal.surface.nearest(rival.toProp(place), foot), other);
    greatest = Math.max(greatest, one.distanceTo(rival.toRoom(other, other)));
  }
  return greatest;
}

/** Whether all that is in doubt is a turn that changes nothing of what is displayed. */
export function doubtIsHarmless(
  goal: SurfaceGoal,
  { pose, rivals, doubts }: Calibration,
  allowed = 0.003,
): boolean {
  if (doubts.some((doubt) => doubt !== "turn" && doubt !== "ambiguous")) return false;
  return rivals.every((rival) => displayedDifference(goal, pose, rival) <= allowed);
}

const weights = new Vector3();
const corner = new Vector3();
