import type { Vector3 } from "three";
import type { Calibration } from "./assess.js";
import { isReachable } from "./places.js";
import { turnAxes } from "./pose.js";
import type { Task } from "./register.js";
import { rowDerivative } from "./rows.js";
import { SurfaceFoot } from "./surface.js";

/** A place worth touching, prop frame, and how much is at stake there. */
export interface Suggestion {
  readonly point: Vector3;
  readonly normal: Vector3;
  /** How far the surface may be off there, along its normal: one standard deviation, m. */
  readonly doubt: number;
}

/**
 * Where the next touch tells most: where the prop's surface is least sure.
 *
 * That is the predictive standard deviation of a touch's gap: from the covariance seen from the hand
 * (what a further touch can lower), and from how far the surfaces of rival poses are away.
 */
export function nextTouch(task: Task, calibration: Calibration, count = 200): Suggestion {
  const { pose, covariance, rivals } = calibration;
  const axes = turnAxes(task.freedom, task.up);
  const pivot = pose.toRoom(task.surface.centre);
  const slope = new Float64Array(3 + axes.length);
  const foot = new SurfaceFoot();
  const contact = task.contacts[0]!;
  const { radius } = contact;
  let best: Suggestion | null = null;
  for (const { point, normal } of task.surface.sample(count)) {
    const axis = normal.clone().applyQuaternion(pose.turn);
    const place = pose.toRoom(point);
    const height = place.clone().sub(pose.toRoom(task.surface.lowest)).dot(task.up);
    const upward = axis.dot(task.up);
    if (!isReachable(task.surface, { point, normal }, upward, height, radius)) continue;
    const tip = place.addScaledVector(axis, radius);
    rowDerivative({ contact, tip, axis, residual: 0, aim: 0 }, pivot, axes, slope);
    let variance = 0;
    for (let i = 0; i < slope.length; i++) {
      for (let j = 0; j < slope.length; j++) {
        variance += slope[i]! * slope[j]! * covariance.toHand.get(i, j);
      }
    }
    for (const rival of rivals) {
      const gap = task.surface.nearest(rival.toProp(tip), foot).distance - radius;
      variance += (gap * gap) / rivals.length;
    }
    const doubt = Math.sqrt(variance);
    if (!best || doubt > best.doubt) best = { point, normal, doubt };
  }
  return best ?? { point: task.surface.highest.clone(), normal: task.up.clone(), doubt: 0 };
}
