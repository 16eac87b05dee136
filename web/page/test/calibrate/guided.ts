import { CholeskyDecomposition, Matrix } from "ml-matrix";
import { Vector3 } from "three";
import { type Calibration, calibrate } from "../../src/calibrate/assess.js";
import {
  HEADSET_HANDS,
  type Stroke,
  type TrackingModel,
  trimStrokes,
} from "../../src/calibrate/contact.js";
import { nextTouch } from "../../src/calibrate/nextTouch.js";
import type { Pose } from "../../src/calibrate/pose.js";
import type { Task } from "../../src/calibrate/register.js";
import type { ContactSurface } from "../../src/calibrate/surface.js";
import { dwell, gaussian, rub, type TrackingFaults, UP } from "./rubbing.js";

export interface Guided {
  readonly task: Task;
  readonly calibration: Calibration;
  readonly rounds?: number;
}

/** A person who rubs the prop all over, then follows the suggestions until nothing is in doubt. */
export function calibrateGuided(
  surface: ContactSurface,
  pose: Pose,
  random: () => number,
  faults: TrackingFaults,
  tracking: TrackingModel = HEADSET_HANDS,
  mostRounds = 4,
  believed: ContactSurface = surface,
): Guided {
  const strokes: Stroke[] = rub(surface, pose, random, { ...faults, strokes: 7 });
  strokes.push(...rub(surface, pose, random, { ...faults, ...HANDLE, strokes: 4, begin: 30 }));
  for (const [k, named] of NAMED.entries()) {
    const dwelt = { ...faults, begin: 44 + 1.5 * k };
    strokes.push([dwell(surface, pose, random, named, 0.004, dwelt)]);
  }
  for (let rounds = 0; ; rounds++) {
    const contacts = trimStrokes(strokes);
    const task: Task = { surface: believed, contacts, freedom: 4, up: UP, tracking };
    const calibration = calibrate(task)!;
    if (calibration.doubts.length === 0 || rounds === mostRounds) {
      return { task, calibration, rounds };
    }
    const next = nextTouch(task, calibration);
    const begin = 50 + 6 * rounds;
    const above = next.point.clone().sub(surface.centre).addScaledVector(next.normal, 0.015);
    const towards = (chance: () => number) => gaussian(chance, 0.008, above.clone());
    strokes.push([dwell(surface, pose, random, next, 0.004, { ...faults, begin })]);
    const around = {
      ...faults,
      strokes: 1,
      strokeSeconds: 2,
      towards,
      near: true,
      begin: begin + 2,
    };
    strokes.push(...rub(surface, pose, random, around));
  }
}

/** Places that a person is asked to touch: far out on the handle, and on its two sides. */
const NAMED = [
  { point: new Vector3(0.074, 0, 0.048), normal: new Vector3(1, 0, 0) },
  { point: new Vector3(0.064, 0.006, 0.048), normal: new Vector3(0, 1, 0) },
  { point: new Vector3(0.064, -0.006, 0.048), normal: new Vector3(0, -1, 0) },
];

/** Strokes along the mug's handle, from all its sides. */
const HANDLE = {
  near: true,
  towards: (random: () => number) =>
    new Vector3(0.056 + 0.03 * random(), 0.04 * random() - 0.02, 0.05 * random() - 0.025),
};

/** Errors of a calibration: of the prop's middle (m) and of its turn about the vertical (rad). */
export function poseError({ task, calibration }: Guided, truth: Pose) {
  const { centre } = task.surface;
  const shift = truth.toRoom(centre).sub(calibration.pose.toRoom(centre));
  const turn = truth.turn.clone().multiply(calibration.pose.turn.clone().invert());
  const half = new Vector3(turn.x, turn.y, turn.z).dot(UP);
  const angle = 2 * Math.atan2(half, turn.w);
  return { shift, turn: Math.atan2(Math.sin(angle), Math.cos(angle)) };
}

/** Mahalanobis distance, squared, of the true pose: χ² of four freedoms if all is as stated. */
export function surprise(guided: Guided, truth: Pose): number {
  const { shift, turn } = poseError(guided, truth);
  const error = Matrix.columnVector([...shift.toArray(), turn]);
  const solved = new CholeskyDecomposition(guided.calibration.covariance.inRoom).solve(error);
  return error.transpose().mmul(solved).get(0, 0);
}
