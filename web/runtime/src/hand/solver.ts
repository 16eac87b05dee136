/**
 * The rigid-boned hand whose fingertips come nearest to where they should be.
 *
 * Unknown are the palm's shift t and turn θ and four angles q of each finger, all counted from the
 * tracked hand, so that nothing moves where nothing is asked for. They minimise
 *
 *     Σ_i w_i |tip_i − target_i|² + |S q|² + s_t² |t − t₀|² + s_r² |θ − θ₀|²,
 *
 * with angles beyond their limits held back by a stiff spring and cut off in the end. Steps are
 * Newton's, with each finger's angles eliminated (`FingerStep`), which leaves six equations for the
 * palm. Once settled, what the stiffness has held back is added to the targets (iterated Tikhonov)
 * and the steps go on, so that tips which can be reached are, and ones which cannot make no joint
 * swing.
 *
 * There is no memory of the last frame. The Python library is the reference: docs/hands.md.
 */

import { factor, halfSolve, otherHalf } from "./definite.js";
import { bounded, FingerStep } from "./finger_step.js";
import { multiply, multiplyTransposed, rotationVector, turnBy, turnOn } from "./rotation.js";

/** Steps at most; 6 to 10 do. */
const STEPS = 24;
/**
 * So many may be Newton's. What has not settled by then has joints at their limits, between which
 * such steps go to and fro; damped ones bring its fingertips home first.
 */
const NEWTON_STEPS = 10;
/**
 * rad, and shares of 0.1 m: a step as small as that is the last one before and after the halt at
 * which what has been held back is added to the targets. Newton's next would be its square.
 */
const SETTLED = 2e-3;
/** The same for steps that were damped, which only shrink by a share. */
const SETTLED_DAMPED = 1e-4;
/** rad, and shares of 0.1 m: longer steps are shortened, since paths bend. */
const STRIDE = 0.3;
/** What shifting the palm from its own warped place costs, and (m/rad)² turning it. */
const SHIFT = 0.05 ** 2;
const TURN = 2e-2 ** 2;
const SPRINGS = Float64Array.of(SHIFT, SHIFT, SHIFT, TURN, TURN, TURN);

/** One hand's problem and its solution, in arrays that are used again. */
export class HandSolver {
  /** (5, 4, 3) m, tracked: each finger's base, two joints, and the point to be placed. */
  readonly chain = new Float64Array(60);
  /** (5, 4, 3) unit vectors, tracked: flexion and abduction at the base, flexion of the others. */
  readonly axes = new Float64Array(60);
  /** (5, 4, 2) rad, least and greatest change of each angle. */
  readonly bounds = new Float64Array(40);
  /** (5, 3) m, where the points should be. */
  readonly target = new Float64Array(15);
  /** (5), 0 for a finger that is not tracked. */
  readonly weight = new Float64Array(5);
  /** m, tracked: what the palm turns about. */
  readonly centre = new Float64Array(3);
  /** Where the palm would go by itself. */
  readonly shift = new Float64Array(3);
  readonly turn = new Float64Array(9);

  /** (5, 4) rad, by how much each joint differs from the tracked one. */
  readonly q = new Float64Array(20);
  readonly palmShift = new Float64Array(3);
  readonly palmTurn = new Float64Array(9);
  /** (5) m, how far each point is from its target; NaN for a finger that is not tracked. */
  readonly misses = new Float64Array(5);

  /** Joints and bones' turns of the finger that was placed last. */
  readonly joints = new Float64Array(12);
  readonly turns = [new Float64Array(9), new Float64Array(9), new Float64Array(9)] as const;
  /** (5, 4, 3) axes as displayed now. */
  private readonly moved = new Float64Array(60);
  private readonly one = new Float64Array(9);
  private readonly other = new Float64Array(9);
  private readonly between = new Float64Array(9);

  private readonly fingers = Array.from({ length: 5 }, () => new FingerStep());
  private readonly held = new Float64Array(15);
  private readonly A = new Float64Array(36);
  private readonly b = new Float64Array(6);
  private readonly theta = new Float64Array(3);

  /** The displayed hand, from the tracked one. */
  solve(): void {
    const { q, palmShift, palmTurn, held } = this;
    q.fill(0);
    held.fill(0);
    palmShift.set(this.shift);
    palmTurn.set(this.turn);
    for (const finger of this.fingers) {
      finger.force.fill(0);
    }
    let settled = false;
    let halts = 0;
    for (let step = 0; step < STEPS; step++) {
      if (settled && halts > 0) {
        break;
      }
      const halt = halts === 0 && (settled || step === STEPS / 2);
      halts += halt ? 1 : 0;
      this.linearise(halt);
      const curved = step < NEWTON_STEPS && this.eliminate(true);
      if (!curved) {
        this.eliminate(false);
      }
      settled = this.move() < (curved ? SETTLED : SETTLED_DAMPED);
    }
    for (let i = 0; i < 5; i++) {
      this.finish(i);
    }
  }

  /** A finger as displayed: `joints`, `turns` and its `moved` axes. */
  place(finger: number): void {
    const { centre, chain, q, joints, turns, axes, moved, palmShift, palmTurn, between } = this;
    const at = 12 * finger;
    const n = 4 * finger;
    const [base, middle, last] = turns;
    turnOn(palmTurn, axes, q, n, between, moved); // what the axis of abduction turns with
    turnOn(between, axes, q, n + 1, base, moved);
    turnOn(base, axes, q, n + 2, middle, moved);
    turnOn(middle, axes, q, n + 3, last, moved);
    const x = chain[at]! - centre[0]!;
    const y = chain[at + 1]! - centre[1]!;
    const z = chain[at + 2]! - centre[2]!;
    for (let d = 0; d < 3; d++) {
      const turned = palmTurn[3 * d]! * x + palmTurn[3 * d + 1]! * y + palmTurn[3 * d + 2]! * z;
      joints[d] = centre[d]! + palmShift[d]! + turned;
    }
    addBone(base, chain, at, joints, 0);
    addBone(middle, chain, at + 3, joints, 3);
    addBone(last, chain, at + 6, joints, 6);
  }

  /** Each finger where it is now; at the halt what it misses is added to its target. */
  private linearise(halt: boolean): void {
    const { joints, held, target } = this;
    for (let i = 0; i < 5; i++) {
      if (!(this.weight[i]! > 0)) {
        continue;
      }
      this.place(i);
      const { miss, arm } = this.fingers[i]!;
      for (let d = 0; d < 3; d++) {
        const left = target[3 * i + d]! - joints[9 + d]!;
        if (halt) {
          held[3 * i + d] = left;
        }
        miss[d] = left + held[3 * i + d]!;
        arm[d] = joints[9 + d]! - this.centre[d]! - this.palmShift[d]!;
      }
      this.fingers[i]!.linearise(joints, this.moved, this.q, this.bounds, i);
    }
  }

  /** The palm's step, into b; false where it is none, for the paths of fingers bend too much. */
  private eliminate(curved: boolean): boolean {
    const { A, b, theta } = this;
    A.fill(0);
    multiplyTransposed(this.palmTurn, this.turn, this.one);
    rotationVector(this.one, theta);
    for (let d = 0; d < 3; d++) {
      A[7 * d] = SHIFT;
      A[7 * (d + 3)] = TURN;
      b[d] = SHIFT * (this.shift[d]! - this.palmShift[d]!);
      b[3 + d] = -TURN * theta[d]!;
    }
    for (let i = 0; i < 5; i++) {
      const weight = this.weight[i]!;
      if (weight > 0 && !this.fingers[i]!.eliminate(weight, this.moved, i, curved, A, b)) {
        return false;
      }
    }
    if (!factor(A, 6, SPRINGS)) {
      return false;
    }
    halfSolve(A, 6, b);
    otherHalf(A, 6, b);
    return true;
  }

  /** Take the step; returns its greatest part before it was shortened. */
  private move(): number {
    const { b, q, palmShift, palmTurn, one, other } = this;
    let largest = 0;
    for (let d = 0; d < 3; d++) {
      largest = Math.max(largest, 10 * Math.abs(b[d]!), Math.abs(b[3 + d]!));
    }
    for (let i = 0; i < 5; i++) {
      if (this.weight[i]! > 0) {
        const finger = this.fingers[i]!;
        finger.follow(this.weight[i]!, b);
        for (let n = 0; n < 4; n++) {
          largest = Math.max(largest, Math.abs(finger.bend[n]!));
        }
      }
    }
    const share = largest > STRIDE ? STRIDE / largest : 1;
    for (let i = 0; i < 5; i++) {
      for (let n = 0; n < 4 && this.weight[i]! > 0; n++) {
        q[4 * i + n] = q[4 * i + n]! + share * this.fingers[i]!.bend[n]!;
      }
    }
    for (let d = 0; d < 3; d++) {
      palmShift[d] = palmShift[d]! + share * b[d]!;
    }
    turnBy(share * b[3]!, share * b[4]!, share * b[5]!, one);
    multiply(one, palmTurn, other);
    palmTurn.set(other);
    return largest;
  }

  private finish(i: number): void {
    const { q, joints, target } = this;
    if (!(this.weight[i]! > 0)) {
      q.fill(0, 4 * i, 4 * i + 4);
      this.misses[i] = Number.NaN;
      return;
    }
    for (let n = 0; n < 4; n++) {
      q[4 * i + n] = bounded(q, this.bounds, 4 * i + n);
    }
    this.place(i);
    this.misses[i] = Math.hypot(
      target[3 * i]! - joints[9]!,
      target[3 * i + 1]! - joints[10]!,
      target[3 * i + 2]! - joints[11]!,
    );
  }
}

/** The joint after that at joints[to…], one turned bone on; the tracked bone starts at chain[from…]. */
function addBone(
  T: Float64Array,
  chain: Float64Array,
  from: number,
  joints: Float64Array,
  to: number,
): void {
  const x = chain[from + 3]! - chain[from]!;
  const y = chain[from + 4]! - chain[from + 1]!;
  const z = chain[from + 5]! - chain[from + 2]!;
  joints[to + 3] = joints[to]! + T[0]! * x + T[1]! * y + T[2]! * z;
  joints[to + 4] = joints[to + 1]! + T[3]! * x + T[4]! * y + T[5]! * z;
  joints[to + 5] = joints[to + 2]! + T[6]! * x + T[7]! * y + T[8]! * z;
}
