import { Matrix4, Quaternion, Vector3 } from "three";
import {
  type Contact,
  type NamedPoint,
  namedTouch,
  type Stroke,
} from "../../src/calibrate/contact.js";
import { Pose, uprightTurn } from "../../src/calibrate/pose.js";
import { type ContactSurface, SurfaceFoot } from "../../src/calibrate/surface.js";

/** A small seeded generator (mulberry32). */
export function seeded(seed: number): () => number {
  let state = seed >>> 0;
  return () => {
    state = (state + 0x6d2b79f5) >>> 0;
    let mixed = Math.imul(state ^ (state >>> 15), 1 | state);
    mixed = (mixed + Math.imul(mixed ^ (mixed >>> 7), 61 | mixed)) ^ mixed;
    return ((mixed ^ (mixed >>> 14)) >>> 0) / 4294967296;
  };
}

export interface TrackingFaults {
  /** m, per axis and sample, independent. */
  readonly white?: number;
  /** m, per axis, with `correlationTime`. */
  readonly correlated?: number;
  readonly correlationTime?: number;
  /** m, length of an offset in the room and of one in the fingertip's frame. */
  readonly roomBias?: number;
  readonly handBias?: number;
  /** Bias stays the same over several calls with one seed. */
  readonly biasSeed?: number;
  readonly delay?: number;
  /** Share of the time that is lost, and of samples that are elsewhere. */
  readonly dropOuts?: number;
  readonly outliers?: number;
}

export interface Rubbing extends TrackingFaults {
  readonly strokes?: number;
  readonly strokeSeconds?: number;
  readonly radius?: number;
  /** Take `towards` as places near the surface rather than directions. */
  readonly near?: boolean;
  /** Time of the first sample. */
  readonly begin?: number;
  /** Directions (prop frame, from its centre) between which a finger rubs. */
  readonly towards?: (random: () => number) => Vector3;
}

/** A random upright pose on a table in a room whose vertical is y. */
export function uprightPose(random: () => number): Pose {
  const turn = new Quaternion().setFromAxisAngle(UP, 2 * Math.PI * random());
  turn.multiply(uprightTurn(UP));
  return new Pose(turn, new Vector3(random() - 0.5, 0.7 + 0.2 * random(), -0.3 - 0.3 * random()));
}

export const UP = new Vector3(0, 1, 0);

/** Strokes of a tracked fingertip over the prop at `pose`, at 72 Hz, as a headset would report. */
export function rub(
  surface: ContactSurface,
  pose: Pose,
  random: () => number,
  how: Rubbing = {},
): Stroke[] {
  const { strokes = 10, strokeSeconds = 3, radius = 0.008, delay = 0, towards = allAround } = how;
  const biases = seeded(how.biasSeed ?? 0);
  const roomBias = randomDirection(biases).multiplyScalar(how.roomBias ?? 0);
  const handBias = randomDirection(biases).multiplyScalar(how.handBias ?? 0);
  const noise = new CorrelatedNoise(random, how.correlated ?? 0, how.correlationTime ?? 0.3);
  const result: Stroke[] = [];
  let time = how.begin ?? 0;
  for (let stroke = 0; stroke < strokes; stroke++) {
    const from = towards(random);
    const to = towards(random);
    const begin = time;
    const samples: Contact[] = [];
    let lostUntil = -1;
    for (; time < begin + strokeSeconds; time += 1 / 72) {
      const progress = (time - delay - begin) / strokeSeconds;
      const { tip, turn } = touchingTip(surface, pose, from, to, progress, radius, how.near);
      if (progress < 0) tip.addScaledVector(UP, -0.3 * progress * strokeSeconds); // still coming down
      noise.next(1 / 72, tip);
      gaussian(random, how.white ?? 0, tip);
      tip.add(roomBias).add(handBias.clone().applyQuaternion(turn));
      if (random() < (how.outliers ?? 0)) {
        tip.addScaledVector(randomDirection(random), 0.02 + 0.08 * random());
      }
      if (random() < (how.dropOuts ?? 0) / 18) lostUntil = time + 0.25;
      if (time < lostUntil) tip.set(NaN, NaN, NaN);
      samples.push({ tip, turn, radius, time });
    }
    result.push(samples);
    time += 0.6;
  }
  return result;
}

/** A finger that dwells for a second at a named place, `aside` m (one sigma) beside it. */
export function dwell(
  surface: ContactSurface,
  pose: Pose,
  random: () => number,
  named: NamedPoint,
  aside: number,
  how: Rubbing = {},
): Contact {
  const aim = gaussian(random, aside, named.point.clone()).addScaledVector(named.normal, 0.02);
  const towards = () =>
    surface
      .nearest(aim, new SurfaceFoot())
      .point.clone()
      .addScaledVector(named.normal, 0.01)
      .sub(surface.centre);
  const [stroke] = rub(surface, pose, random, {
    ...how,
    strokes: 1,
    strokeSeconds: 1,
    towards,
    near: true,
  });
  return namedTouch(stroke!, named)!;
}

/** A fingertip pad on the surface, as seen from somewhere between two directions. */
function touchingTip(
  surface: ContactSurface,
  pose: Pose,
  from: Vector3,
  to: Vector3,
  progress: number,
  radius: number,
  near = false,
): { tip: Vector3; turn: Quaternion } {
  const share = Math.min(Math.max(progress, 0), 1);
  const outside = from.clone().lerp(to, share);
  if (!near) outside.setLength(3 * surface.reach);
  outside.add(surface.centre);
  const foot = surface.nearest(outside, new SurfaceFoot());
  const tip = pose.toRoom(foot.point.clone().addScaledVector(foot.gradient, radius));
  const back = foot.gradient.clone().applyQuaternion(pose.turn);
  // The finger comes from the person's side, −z of the room, as far as the surface lets it.
  const along = new Vector3(0, 0.3, 1).projectOnPlane(back).normalize();
  const side = new Vector3().crossVectors(back, along);
  const turn = new Quaternion().setFromRotationMatrix(new Matrix4().makeBasis(side, back, along));
  return { tip, turn };
}

/** Anywhere but from below. */
export function allAround(random: () => number): Vector3 {
  const direction = randomDirection(random);
  direction.z = Math.abs(direction.z) * 0.9 - 0.1;
  return direction;
}

export function randomDirection(random: () => number): Vector3 {
  const height = 2 * random() - 1;
  const turn = 2 * Math.PI * random();
  const width = Math.sqrt(1 - height * height);
  return new Vector3(width * Math.cos(turn), width * Math.sin(turn), height);
}

export function gaussian(random: () => number, sigma: number, out: Vector3): Vector3 {
  for (let axis = 0; axis < 3; axis++) {
    const normal = Math.sqrt(-2 * Math.log(1 - random())) * Math.cos(2 * Math.PI * random());
    out.setComponent(axis, out.getComponent(axis) + sigma * normal);
  }
  return out;
}

/** An Ornstein–Uhlenbeck offset. */
class CorrelatedNoise {
  private readonly offset = new Vector3();
  constructor(
    private readonly random: () => number,
    private readonly sigma: number,
    private readonly correlationTime: number,
  ) {
    gaussian(random, sigma, this.offset);
  }
  next(step: number, tip: Vector3): void {
    const kept = Math.exp(-step / this.correlationTime);
    this.offset.multiplyScalar(kept);
    gaussian(this.random, this.sigma * Math.sqrt(1 - kept * kept), this.offset);
    tip.add(this.offset);
  }
}
