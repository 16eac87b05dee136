import { Vector3 } from "three";
import { effectiveCount, thinContacts } from "./contact.js";
import { type Pose, turnAxes } from "./pose.js";
import { FINE_CONTACTS, type Fit, placementCost, refine, register, type Task } from "./register.js";
import { swollen } from "./swelling.js";
import { leastKnownTurn, type PoseCovariance, poseCovariance } from "./uncertainty.js";

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
  /** Half widths that hold 95 % each, seen from the hand: m for the room's x, y, z; rad. */
  readonly translation95: Vector3;
  readonly turn95: number;
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
  widenTurn(covariance, turnAxis, task, widest / 1.96);
  const half = (i: number) => 1.96 * Math.sqrt(covariance.toHand.get(i, i));
  const translation95 = new Vector3(half(0), half(1), half(2));
  let turn95 = 0;
  for (let i = 3; i < covariance.toHand.rows; i++) turn95 = Math.max(turn95, half(i));
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
    turn95: Math.min(turn95, Math.PI),
    turnAxis,
    rivals: [...turned.map(({ fit }) => fit.pose), ...others.map(({ pose }) => pose)],
    scale: best.scale,
    doubts,
  };
}

/** Give the turn about `axis` at least this standard deviation: the profile knows better. */
function widenTurn(
  { toHand, inRoom }: PoseCovariance,
  axis: Vector3,
  task: Task,
  deviation: number,
): void {
  const along = turnAxes(task.freedom, task.up).map((each) => each.dot(axis));
  let variance = 0;
  for (const [i, a] of along.entries()) {
    for (const [j, b] of along.entries()) variance += a * b * toHand.get(3 + i, 3 + j);
  }
  const missing = deviation ** 2 - variance;
  if (missing <= 0) return;
  for (const matrix of [toHand, inRoom]) {
    for (const [i, a] of along.entries()) {
      for (const [j, b] of along.entries()) {
        matrix.set(3 + i, 3 + j, matrix.get(3 + i, 3 + j) + missing * a * b);
      }
    }
  }
}

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
function turnRivals(task: Task, fits: Fit[], axis: Vector3): { angle: number; fit: Fit }[] {
  const best = fits[0]!;
  const few = { ...task, contacts: thinContacts(task.contacts, 100) };
  const pivot = best.pose.toRoom(task.surface.centre);
  const bars = [false, true].map((coarse) => {
    const ground = refine(few, best, { hold: true, coarse });
    const cost = placementCost(few, ground, best.scale, coarse);
    return costBar(few, { ...ground, scale: best.scale, cost }, TURN_CHI2);
  });
  const rivals: { angle: number; fit: Fit }[] = [];
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
