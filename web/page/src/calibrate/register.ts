import { Vector3 } from "three";
import { type Contact, effectiveCount, type TrackingModel, thinContacts } from "./contact.js";
import { NormalEquations } from "./normalEquations.js";
import { type Freedom, type Pose, turnAxes } from "./pose.js";
import { collectRows, type Placement, type Row, rowDerivative, visitRows } from "./rows.js";
import { startPoses } from "./starts.js";
import type { ContactSurface } from "./surface.js";

/** What a registration is asked to do. */
export interface Task {
  readonly surface: ContactSurface;
  readonly contacts: readonly Contact[];
  readonly freedom: Freedom;
  /** Unit, room frame. */
  readonly up: Vector3;
  readonly tracking: TrackingModel;
}

/** A local minimum. */
export interface Fit extends Placement {
  /** Robust scale of the residuals, m. */
  readonly scale: number;
  /** m²; comparable between fits of the same contacts. */
  readonly cost: number;
}

const SEARCH_CONTACTS = 60;
/** More than this only repeats what correlated noise has said already. */
export const FINE_CONTACTS = 180;
/** Scales of the graduated search, m: far contacts pull at first, near ones only at last. */
const SEARCH_SCALES = [0.03, 0.015, 0.008];
/** One scale for the costs of all poses that are compared, m. */
const COST_SCALE = 0.006;

/**
 * The best poses of the prop, best first, by robust point-to-surface registration.
 *
 * Iteratively reweighted Gauss–Newton on the distances of the fingertips' skin from the surface, from
 * many starts, with a loss whose scale is lowered step by step (graduated non-convexity), since
 * neither the turn nor which wall was touched is known.
 */
export function register(task: Task): Fit[] {
  const few = { ...task, contacts: thinContacts(task.contacts, SEARCH_CONTACTS) };
  const found = startPoses(few).map((start) => {
    let placement: Placement = { pose: start, tipOffset: new Vector3() };
    for (const scale of SEARCH_SCALES) {
      placement = descend(few, placement, scale, 3, { coarse: true, offset: false });
    }
    return { ...placement, cost: placementCost(few, placement, COST_SCALE, true) };
  });
  const all = { ...task, contacts: thinContacts(task.contacts, FINE_CONTACTS) };
  const rough = distinct(found, task.surface, 20).map((start) =>
    refine(few, start, { coarse: true }),
  );
  const near = distinct(rough, task.surface, 6).filter(
    (fit, _, [best]) => fit.cost < 2 * best!.cost,
  );
  return distinct(
    near.map((start) => refine(all, start)),
    task.surface,
    near.length,
  );
}

/** How a descent is restricted. */
interface Restriction {
  /** Keep the turn. */
  readonly hold?: boolean;
  /** Distances from the grid. */
  readonly coarse?: boolean;
  /** Seek the fingertips' offset too (default). */
  readonly offset?: boolean;
}

/** Gauss–Newton to the end, at a scale taken from the residuals. */
export function refine(task: Task, start: Placement, restriction: Restriction = {}): Fit {
  let placement = start;
  for (let round = 0; round < 3; round++) {
    const scale = residualScale(task, placement, restriction.coarse);
    placement = descend(task, placement, scale, 4, restriction);
  }
  const scale = residualScale(task, placement, restriction.coarse);
  const cost = placementCost(task, placement, scale, restriction.coarse);
  return { pose: placement.pose, tipOffset: placement.tipOffset, scale, cost };
}

/** The rows of a placement. */
export function rowsAt(task: Task, placement: Placement): Row[] {
  return collectRows(task.surface, task.contacts, placement, task.tracking.pointing);
}

/** Σ of the Geman–McClure loss e² / (1 + e²/9s²) and the prior's share for the offset, m². */
export function placementCost(
  task: Task,
  placement: Placement,
  scale: number,
  coarse = false,
): number {
  const bound = 9 * COST_SCALE * COST_SCALE;
  let cost = placement.tipOffset.lengthSq() * offsetInformation(task) * scale * scale;
  visitRows(task.surface, task.contacts, placement, task.tracking.pointing, coarse, (row) => {
    const square = row.residual ** 2 / (1 + (row.aim / COST_SCALE) ** 2);
    cost += square / (1 + square / bound);
  });
  return cost;
}

/** Standard deviation of the inliers' residuals: the median absolute one, made consistent, m. */
export function residualScale(task: Task, placement: Placement, coarse = false): number {
  const sizes: number[] = [];
  visitRows(task.surface, task.contacts, placement, task.tracking.pointing, coarse, (row) => {
    if (row.aim === 0) sizes.push(Math.abs(row.residual));
  });
  sizes.sort((one, other) => one - other);
  return Math.max(1.4826 * (sizes[sizes.length >> 1] ?? 0), task.tracking.noiseFloor);
}

/** Weight of a row, m⁻²: Tukey's biweight over what this row's residual should be. */
export function rowWeight(row: Row, scale: number): number {
  const variance = scale * scale + row.aim * row.aim;
  const ratio = (row.residual * row.residual) / (21.95 * variance);
  return ratio >= 1 ? 0 : (1 - ratio) ** 2 / variance;
}

/** What the prior says of the fingertips' offset, m⁻², on the scale of rows that repeat each other. */
export function offsetInformation(task: Task): number {
  const repeats = task.contacts.length / Math.max(effectiveCount(task.contacts, task.tracking), 1);
  return repeats / task.tracking.handBias ** 2;
}

/** Up to `steps` damped Gauss–Newton steps with weights of one scale. */
function descend(
  task: Task,
  start: Placement,
  scale: number,
  steps: number,
  { hold = false, coarse = false, offset = true }: Restriction,
): Placement {
  const axes = hold ? [] : turnAxes(task.freedom, task.up);
  const turnsEnd = 3 + axes.length;
  const equations = new NormalEquations(turnsEnd + (offset ? 3 : 0));
  const prior = offset ? offsetInformation(task) : 0;
  const pivot = new Vector3();
  const rotation = new Vector3();
  let { pose, tipOffset } = start;
  for (let step = 0; step < steps; step++) {
    pose.toRoom(task.surface.centre, pivot);
    equations.clear();
    const placement = { pose, tipOffset };
    visitRows(task.surface, task.contacts, placement, task.tracking.pointing, coarse, (row) => {
      const weight = rowWeight(row, scale);
      if (weight === 0) return;
      rowDerivative(row, pivot, axes, equations.slope);
      equations.add(weight, row.residual);
    });
    // A step of 3 cm, or of the same at the prop's surface, counts as one more equation.
    for (let i = 0; i < turnsEnd; i++) {
      equations.damp(i, (i < 3 ? 1 : task.surface.reach ** 2) / 0.03 ** 2, 0);
    }
    for (let i = turnsEnd; i < equations.size; i++) {
      equations.damp(i, prior, tipOffset.getComponent(i - turnsEnd));
    }
    const move = equations.solve();
    rotation.set(0, 0, 0);
    for (let k = 0; k < axes.length; k++) rotation.addScaledVector(axes[k]!, move[3 + k]!);
    rotation.clampLength(0, 0.3);
    const translation = new Vector3(move[0], move[1], move[2]).clampLength(0, 0.03);
    pose = pose.moved(rotation, pivot, translation);
    if (offset) tipOffset = new Vector3(...move.slice(turnsEnd)).add(tipOffset);
    if (translation.length() + rotation.length() * task.surface.reach < 1e-6) break;
  }
  return { pose, tipOffset };
}

/** The cheapest `count` of the fits, one for each place. */
function distinct<F extends { pose: Pose; cost: number }>(
  fits: readonly F[],
  surface: ContactSurface,
  count: number,
): F[] {
  const kept: F[] = [];
  for (const fit of [...fits].sort((one, other) => one.cost - other.cost)) {
    const centre = fit.pose.toRoom(surface.centre);
    const isNew = kept.every(
      ({ pose }) =>
        pose.toRoom(surface.centre).distanceTo(centre) > 0.003 ||
        pose.turn.angleTo(fit.pose.turn) > 0.08,
    );
    if (isNew) kept.push(fit);
    if (kept.length === count) break;
  }
  return kept;
}
