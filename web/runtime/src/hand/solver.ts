/**
 * The rigid-boned hand whose fingertips come nearest to where they should be.
 *
 * Unknown are the palm's shift t and turn θ and four angles q of each finger, all counted from the
 * tracked hand, so that nothing moves where nothing is asked for. They minimise
 *
 *     Σ_i w_i |tip_i − target_i|² + |S q|² + s_t² |t − t₀|² + s_r² |θ − θ₀|²,
 *
 * with angles beyond their limits held back by a stiff spring and cut off in the end. Steps are
 * Gauss–Newton's: finger i gives way by its compliance C_i = I / w_i + F_i G⁻¹ F_iᵀ (3 × 3; F_i the
 * motion of its tip by its angles, G their stiffness), which leaves six equations for the palm.
 * Once settled, what the stiffness has held back is added to the targets (iterated Tikhonov) and the
 * steps go on, so that tips which can be reached are, and ones which cannot make no joint swing.
 *
 * There is no memory of the last frame. The Python library is the reference: docs/hands.md.
 */

import { solveSymmetric } from "../inverse.js";
import {
  multiply,
  multiplyTransposed,
  rotate,
  rotationVector,
  turnAbout,
  turnBy,
} from "./rotation.js";

/** Gauss–Newton steps at most; where tips should move little, 3 to 5 do. */
const STEPS = 24;
/**
 * rad, and shares of 0.1 m: a step as small as that is the last one before and after the halt at
 * which what has been held back is added to the targets.
 */
const SETTLED = 1e-4;
/** (m/rad)²: what bending and spreading a joint cost, per squared miss of a fingertip. */
const FLEX = 6e-3 ** 2;
const ABDUCT = 1e-2 ** 2;
/** What shifting the palm from its own warped place costs, and (m/rad)² turning it. */
const SHIFT = 0.05 ** 2;
const TURN = 2e-2 ** 2;
/** (m/rad)²: the spring beyond a limit. */
const LIMIT = 0.2 ** 2;

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
  private readonly moved = new Float64Array(12);
  private readonly one = new Float64Array(9);
  private readonly other = new Float64Array(9);
  private readonly between = new Float64Array(9);

  private readonly F = new Float64Array(60);
  private readonly G = new Float64Array(20);
  private readonly rest = new Float64Array(20);
  private readonly residual = new Float64Array(15);
  private readonly held = new Float64Array(15);
  private readonly arm = new Float64Array(15);
  private readonly W = new Float64Array(45);
  private readonly C = new Float64Array(9);
  private readonly P = Float64Array.of(1, 0, 0, 0, 0, 0, 0, 1, 0, 0, 0, 0, 0, 0, 1, 0, 0, 0);
  private readonly A = new Float64Array(36);
  private readonly b = new Float64Array(6);
  private readonly theta = new Float64Array(3);
  /** The greatest part of the last step. */
  private largest = 0;

  /** The displayed hand, from the tracked one. */
  solve(): void {
    const { q, palmShift, palmTurn, held } = this;
    q.fill(0);
    held.fill(0);
    palmShift.set(this.shift);
    palmTurn.set(this.turn);
    this.largest = Number.POSITIVE_INFINITY;
    let halts = 0;
    for (let step = 0; step < STEPS; step++) {
      const settled = this.largest < SETTLED;
      if (settled && halts > 0) {
        break;
      }
      const halt = halts === 0 && (settled || step === STEPS / 2);
      halts += halt ? 1 : 0;
      this.beginPalm();
      for (let i = 0; i < 5; i++) {
        if (this.weight[i]! > 0) {
          this.linearise(i, halt);
          this.addToPalm(i);
        }
      }
      solveSymmetric(this.A, this.b, 6);
      this.largest = 0;
      for (let i = 0; i < 5; i++) {
        if (this.weight[i]! > 0) {
          this.bend(i);
        }
      }
      const { b, one, other } = this;
      for (let d = 0; d < 3; d++) {
        palmShift[d] = palmShift[d]! + b[d]!;
        this.largest = Math.max(this.largest, 10 * Math.abs(b[d]!), Math.abs(b[3 + d]!));
      }
      turnBy(b[3]!, b[4]!, b[5]!, one);
      multiply(one, palmTurn, other);
      palmTurn.set(other);
    }
    for (let i = 0; i < 5; i++) {
      this.finish(i);
    }
  }

  /** A finger as displayed: `joints` and `turns`. */
  place(finger: number): void {
    const { chain, q, joints, turns, axes, moved, palmTurn, one, other, between } = this;
    const at = 12 * finger;
    for (let d = 0; d < 3; d++) {
      let sum = this.centre[d]! + this.palmShift[d]!;
      for (let e = 0; e < 3; e++) {
        sum += palmTurn[3 * d + e]! * (chain[at + e]! - this.centre[e]!);
      }
      joints[d] = sum;
    }
    turnAbout(axes, at, q[4 * finger]!, one);
    multiply(palmTurn, one, between); // what the axis of abduction turns with
    turnAbout(axes, at + 3, q[4 * finger + 1]!, other);
    multiply(between, other, turns[0]);
    turnAbout(axes, at + 6, q[4 * finger + 2]!, one);
    multiply(turns[0], one, turns[1]);
    turnAbout(axes, at + 9, q[4 * finger + 3]!, one);
    multiply(turns[1], one, turns[2]);
    for (let n = 0; n < 3; n++) {
      const T = turns[n]!;
      const from = at + 3 * n;
      const x = chain[from + 3]! - chain[from]!;
      const y = chain[from + 4]! - chain[from + 1]!;
      const z = chain[from + 5]! - chain[from + 2]!;
      for (let d = 0; d < 3; d++) {
        joints[3 * n + 3 + d] =
          joints[3 * n + d]! + T[3 * d]! * x + T[3 * d + 1]! * y + T[3 * d + 2]! * z;
      }
    }
    rotate(palmTurn, axes, at, moved, 0);
    rotate(between, axes, at + 3, moved, 3);
    rotate(turns[0], axes, at + 6, moved, 6);
    rotate(turns[1], axes, at + 9, moved, 9);
  }

  /** The palm's own terms of its six equations. */
  private beginPalm(): void {
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
  }

  /** A finger's slopes F, stiffness G, rest, residual and the inverse W of its compliance. */
  private linearise(i: number, hold: boolean): void {
    const { q, joints, moved, F, G, rest, residual, held, arm, C } = this;
    this.place(i);
    for (let d = 0; d < 3; d++) {
      const miss = this.target[3 * i + d]! - joints[9 + d]!;
      if (hold) {
        held[3 * i + d] = miss;
      }
      residual[3 * i + d] = miss + held[3 * i + d]!;
      arm[3 * i + d] = joints[9 + d]! - this.centre[d]! - this.palmShift[d]!;
    }
    // how far the tip's path bends away from its tangent, which Gauss–Newton does not know
    const miss =
      this.weight[i]! * norm(residual[3 * i]!, residual[3 * i + 1]!, residual[3 * i + 2]!);
    const damping = miss * norm(arm[3 * i]!, arm[3 * i + 1]!, arm[3 * i + 2]!);
    for (let d = 3; d < 6; d++) {
      this.A[7 * d] = this.A[7 * d]! + damping;
    }
    for (let n = 0; n < 4; n++) {
      const angle = q[4 * i + n]!;
      let stiffness = n === 1 ? ABDUCT : FLEX;
      let pull = stiffness * angle;
      const beyond = angle - this.bounded(i, n);
      if (beyond !== 0) {
        stiffness += LIMIT;
        pull += LIMIT * beyond;
      }
      const j = 3 * Math.max(n - 1, 0);
      const x = joints[9]! - joints[j]!;
      const y = joints[10]! - joints[j + 1]!;
      const z = joints[11]! - joints[j + 2]!;
      stiffness += miss * norm(x, y, z);
      G[4 * i + n] = stiffness;
      rest[4 * i + n] = pull / stiffness;
      const a0 = moved[3 * n]!;
      const a1 = moved[3 * n + 1]!;
      const a2 = moved[3 * n + 2]!;
      F[12 * i + n] = a1 * z - a2 * y;
      F[12 * i + 4 + n] = a2 * x - a0 * z;
      F[12 * i + 8 + n] = a0 * y - a1 * x;
    }
    for (let d = 0; d < 3; d++) {
      for (let n = 0; n < 4; n++) {
        residual[3 * i + d] = residual[3 * i + d]! + F[12 * i + 4 * d + n]! * rest[4 * i + n]!;
      }
      for (let e = 0; e <= d; e++) {
        let sum = d === e ? 1 / this.weight[i]! : 0;
        for (let n = 0; n < 4; n++) {
          sum += (F[12 * i + 4 * d + n]! * F[12 * i + 4 * e + n]!) / G[4 * i + n]!;
        }
        C[3 * d + e] = sum;
        C[3 * e + d] = sum;
      }
    }
    invertSymmetric(C, this.W, 9 * i);
  }

  private addToPalm(i: number): void {
    const { arm, P, W, A, b, residual } = this;
    const x = arm[3 * i]!;
    const y = arm[3 * i + 1]!;
    const z = arm[3 * i + 2]!;
    P[4] = z;
    P[5] = -y;
    P[9] = -z;
    P[11] = x;
    P[15] = y;
    P[16] = -x;
    const w = 9 * i;
    for (let m = 0; m < 6; m++) {
      const p0 = P[m]!;
      const p1 = P[6 + m]!;
      const p2 = P[12 + m]!;
      const v0 = p0 * W[w]! + p1 * W[w + 3]! + p2 * W[w + 6]!;
      const v1 = p0 * W[w + 1]! + p1 * W[w + 4]! + p2 * W[w + 7]!;
      const v2 = p0 * W[w + 2]! + p1 * W[w + 5]! + p2 * W[w + 8]!;
      for (let n = 0; n <= m; n++) {
        A[6 * m + n] = A[6 * m + n]! + v0 * P[n]! + v1 * P[6 + n]! + v2 * P[12 + n]!;
      }
      b[m] = b[m]! + v0 * residual[3 * i]! + v1 * residual[3 * i + 1]! + v2 * residual[3 * i + 2]!;
    }
  }

  /** What the palm's step leaves to a finger. */
  private bend(i: number): void {
    const { arm, b, residual, W, F, G, q, rest } = this;
    const x = arm[3 * i]!;
    const y = arm[3 * i + 1]!;
    const z = arm[3 * i + 2]!;
    const r0 = residual[3 * i]! - (b[0]! + z * b[4]! - y * b[5]!);
    const r1 = residual[3 * i + 1]! - (b[1]! - z * b[3]! + x * b[5]!);
    const r2 = residual[3 * i + 2]! - (b[2]! + y * b[3]! - x * b[4]!);
    const w = 9 * i;
    const f0 = W[w]! * r0 + W[w + 1]! * r1 + W[w + 2]! * r2;
    const f1 = W[w + 3]! * r0 + W[w + 4]! * r1 + W[w + 5]! * r2;
    const f2 = W[w + 6]! * r0 + W[w + 7]! * r1 + W[w + 8]! * r2;
    for (let n = 0; n < 4; n++) {
      const force = F[12 * i + n]! * f0 + F[12 * i + 4 + n]! * f1 + F[12 * i + 8 + n]! * f2;
      const bend = force / G[4 * i + n]! - rest[4 * i + n]!;
      q[4 * i + n] = q[4 * i + n]! + bend;
      this.largest = Math.max(this.largest, Math.abs(bend));
    }
  }

  private finish(i: number): void {
    const { q, joints, target } = this;
    if (!(this.weight[i]! > 0)) {
      q.fill(0, 4 * i, 4 * i + 4);
      this.misses[i] = Number.NaN;
      return;
    }
    for (let n = 0; n < 4; n++) {
      q[4 * i + n] = this.bounded(i, n);
    }
    this.place(i);
    this.misses[i] = Math.hypot(
      target[3 * i]! - joints[9]!,
      target[3 * i + 1]! - joints[10]!,
      target[3 * i + 2]! - joints[11]!,
    );
  }

  private bounded(i: number, n: number): number {
    const at = 8 * i + 2 * n;
    return Math.min(Math.max(this.q[4 * i + n]!, this.bounds[at]!), this.bounds[at + 1]!);
  }
}

function norm(x: number, y: number, z: number): number {
  return Math.sqrt(x * x + y * y + z * z);
}

/** out[at…] = M⁻¹ of a positive definite 3 × 3 matrix. */
function invertSymmetric(M: Float64Array, out: Float64Array, at: number): void {
  const a = M[0]!;
  const b = M[1]!;
  const c = M[2]!;
  const d = M[4]!;
  const e = M[5]!;
  const f = M[8]!;
  const A = d * f - e * e;
  const B = c * e - b * f;
  const C = b * e - c * d;
  const scale = 1 / (a * A + b * B + c * C);
  out[at] = A * scale;
  out[at + 1] = B * scale;
  out[at + 2] = C * scale;
  out[at + 3] = B * scale;
  out[at + 4] = (a * f - c * c) * scale;
  out[at + 5] = (b * c - a * e) * scale;
  out[at + 6] = C * scale;
  out[at + 7] = (b * c - a * e) * scale;
  out[at + 8] = (a * d - b * b) * scale;
}
