import { Vector3 } from "three";
import { effectiveCount, thinContacts } from "./contact.js";
import { type Pose, turnAxes } from "./pose.js";
import { FINE_CONTACTS, type Fit, placementCost, refine, register, type Task } from "./register.js";
import { swollen } from "./swelling.js";
import {
  degreesOfFreedom,
  leastKnownTurn,
  type PoseCovariance,
  poseCovariance,
  studentQuantile95,
} from "./uncertainty.js";

/** How well a pose must be known before a hand is displaced: half widths that hold 95 %. */
export interface Limits {
  readonly translation: number;
  readonly turn: number;
}

/** 12 mm, and the turn that moves the far side of a hand-sized prop by as much. */
export const LIMITS: Limits = { translation: 0.012, turn: (10 * Math.PI) / 180 };

/** What touches have told of where a prop stands. */
export interface Calibration {
  readonly pose: Pose;
  /** How far tracked fingertips are off in their own frame: tracked = true + turn · offset. */
  readonly tipOffset: Vector3;
  readonly covariance: PoseCovariance;
  /** Half widths that hold 95 % each, seen from the hand: m for the room's x, y, z; the greatest of
   * the turns, rad. */
  readonly translation95: Vector3;
  readonly turn95: number;
  /** The same about each of the room's axes: x, y, z; about the vertical alone for an upright prop. */
  readonly turns95: readonly number[];
  /** The axis of the turn that is known least. */
  readonly turnAxis: Vector3;
  /** Other poses that explain the touches as well; the turns about `turnAxis` among them. */
  readonly rivals: readonly Pose[];
  /** Robust standard deviation of the gaps, m. */
  readonly scale: number;
  /** Why the pose cannot be used yet; empty when it can. */
  readonly doubts: readonly Doubt[];
}

export type Doubt = "too few touches" | "place" | "turn" | "ambiguous";

/** Turns that cost less than this over the best belong to its 95 % range (χ², one freedom). */
const TURN_CHI2 = 3.84;
/** Other minima that cost less than this over the best are rivals. */
const RIVAL_CHI2 = 9;
/** The grid is too coarse to tell turns smaller than this. */
const FINE_TURNS_DEG = 14;
const TURNS_DEG = [2, 4, 6, 8, 10, 14, 20, 30, 45, 60, 75, 90, 105, 120, 135, 150, 165, 180];

/** Where the prop stands, how well that is known, and whether it is known well enough; null for
 * fewer than three contacts. */
export function calibrate(task: Task, limits: Limits = LIMITS): Calibration | null {
  if (task.contacts.length < 3) return null;
  const rough = { ...task, contacts: thinContacts(task.contacts, FINE_CONTACTS) };
  const found = register(rough);
  const thinned = { ...rough, contacts: swollen(rough, found[0]!) };
  const fits = found.map((fit) => refine(thinned, fit)).sort((a, b) => a.cost - b.cost);
  const best = fits[0]!;
  const covariance = poseCovariance(thinned, best);
  const turnAxis = leastKnownTurn(thinned, covariance);
  const turned = turnRivals(thinned, fits, turnAxis);
  const bar = costBar(thinned, best, RIVAL_CHI2);
  const others = fits.slice(1).filter((fit) => fit.cost <= bar);
  const widest = Math.max(0, ...turned.map(({ angle }) => Math.abs(angle)));
  const quantile = studentQuantile95(degreesOfFreedom(thinned));
  widenTurn(covariance, turnAxis, shiftPerTurn(thinned, turned), task, widest / quantile);
  const half = (i: number) => quantile * Math.sqrt(covariance.toHand.get(i, i));
  const translation95 = new Vector3(half(0), half(1), half(2));
  const turns95: number[] = [];
  for (let i = 3; i < covariance.toHand.rows; i++) turns95.push(Math.min(half(i), Math.PI));
  const turn95 = Math.max(...turns95);
  const doubts: Doubt[] = [];
  if (effectiveCount(thinned.contacts, task.tracking) < 2 * covariance.toHand.rows) {
    doubts.push("too few touches");
  }
  if (Math.max(...translation95.toArray()) > limits.translation) doubts.push("place");
  if (turn95 > limits.turn + 1e-6) doubts.push("turn");
  if (others.some(({ pose }) => isElsewhere(task, pose, best.pose, limits))) {
    doubts.push("ambiguous");
  }
  return {
    pose: best.pose,
    tipOffset: best.tipOffset,
    covariance,
    translation95,
    turn95,
    turns95,
    turnAxis,
    rivals: [...turned.map(({ fit }) => fit.pose), ...others.map(({ pose }) => pose)],
    scale: best.scale,
    doubts,
  };
}

/**
 * Give the turn about `axis` at least this standard deviation: the profile knows better. The place,
 * refitted at each turn, goes with it by `shift` m/rad, and is known as little.
 */
function widenTurn(
  { toHand, inRoom }: PoseCovariance,
  axis: Vector3,
  shift: Vector3,
  task: Task,
  deviation: number,
): void {
  const turn = turnAxes(task.freedom, task.up).map((each) => each.dot(axis));
  let variance = 0;
  for (const [i, a] of turn.entries()) {
    for (const [j, b] of turn.entries()) variance += a * b * toHand.get(3 + i, 3 + j);
  }
  const missing = deviation ** 2 - variance;
  if (missing <= 0) return;
  const along = [...shift.toArray(), ...turn];
  for (const matrix of [toHand, inRoom]) {
    for (const [i, a] of along.entries()) {
      for (const [j, b] of along.entries()) matrix.set(i, j, matrix.get(i, j) + missing * (a * b));
    }
  }
}

/** By how much the prop's middle goes with a turn that the contacts allow, m/rad: least squares over
 * small ones; nothing where there are fewer than two. */
function shiftPerTurn({ surface }: Task, turned: readonly Turned[]): Vector3 {
  const small = turned.filter(({ angle }) => Math.abs(angle) < (FINE_TURNS_DEG + 1) * DEGREE);
  const mean = small.reduce((sum, { angle }) => sum + angle, 0) / small.length;
  const slope = new Vector3();
  let squares = 0;
  for (const { angle, fit } of small) {
    slope.addScaledVector(fit.pose.toRoom(surface.centre), angle - mean);
    squares += (angle - mean) ** 2;
  }
  return squares > 0 ? slope.divideScalar(squares) : slope.set(0, 0, 0);
}

/** A fit at a turn about an axis, in rad from the best one. */
interface Turned {
  readonly angle: number;
  readonly fit: Fit;
}

const DEGREE = Math.PI / 180;

function isElsewhere({ surface }: Task, one: Pose, other: Pose, limits: Limits): boolean {
  const apart = one.toRoom(surface.centre).distanceTo(other.toRoom(surface.centre));
  return apart > limits.translation || one.turn.angleTo(other.turn) > limits.turn;
}

/** The cost up to which a pose explains the contacts as well as the best one, by χ². */
function costBar(task: Task, best: Fit, chi2: number): number {
  const { length } = task.contacts;
  const perContact = Math.max(best.scale ** 2, best.cost / length);
  return best.cost + (chi2 * perContact * length) / effectiveCount(task.contacts, task.tracking);
}

/**
 * Turns about an axis that the contacts allow, the rest refitted at each (a profile likelihood).
 *
 * A covariance cannot say this: the facets of a round mesh hold its turn by their corners, so its
 * slope there is not 0 although every turn fits.
 */
function turnRivals(task: Task, fits: Fit[], axis: Vector3): Turned[] {
  const best = fits[0]!;
  const few = { ...task, contacts: thinContacts(task.contacts, 100) };
  const pivot = best.pose.toRoom(task.surface.centre);
  const bars = [false, true].map((coarse) => {
    const ground = refine(few, best, { hold: true, coarse });
    const cost = placementCost(few, ground, best.scale, coarse);
    return costBar(few, { ...ground, scale: best.scale, cost }, TURN_CHI2);
  });
  const rivals: Turned[] = [];
  for (const degrees of TURNS_DEG.flatMap((size) => (size < 180 ? [size, -size] : [size]))) {
    const coarse = Math.abs(degrees) > FINE_TURNS_DEG;
    const angle = (degrees * Math.PI) / 180;
    const pose = best.pose.moved(axis.clone().multiplyScalar(angle), pivot, new Vector3());
    const fit = refine(few, { ...best, pose }, { hold: true, coarse });
    if (placementCost(few, fit, best.scale, coarse) <= bars[Number(coarse)]!) {
      rivals.push({ angle, fit });
    }
  }
  return rivals;
}
