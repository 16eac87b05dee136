import { factorFour, halfSolveFour, otherHalfFour } from "./definite.js";

/** (m/rad)²: what bending and spreading a joint cost, per squared miss of a fingertip. */
const FLEX = 6e-3 ** 2;
const ABDUCT = 1e-2 ** 2;
/** (m/rad)²: the spring beyond a limit. */
const LIMIT = 0.2 ** 2;

/**
 * One finger in a Newton step of the whole hand: its four angles are eliminated, which leaves a share
 * in the palm's six equations.
 *
 * With the force f = w (target − tip) of the last step, the energy's second derivatives are those of
 * springs and squared miss, w FᵀF (F the motion of the tip by the angles), less f · ∂²tip: how the
 * tip's path bends. That force has settled long before the miss has, whose own is far too great at
 * first. Where springs do not outweigh it, |f| times the lengths of the arms does as damping.
 *
 * The palm's turn moves the tip by θ × a, a the arm, and what angle and turn bend together goes with
 * f × F: so both come in as g = w a + f, and what the angles leave to the palm by F H⁻¹ Fᵀ alone.
 */
export class FingerStep {
  /** (3) m, from the tip to where it should be, and a, from the palm's centre to the tip. */
  readonly miss = new Float64Array(3);
  readonly arm = new Float64Array(3);
  /** (3) f, as the last step left it. */
  readonly force = new Float64Array(3);
  /** (4) rad: this step of the angles. */
  readonly bend = new Float64Array(4);
  /** (4, 3) m/rad: F, angle by angle, and the lengths of its rows at most. */
  private readonly F = new Float64Array(12);
  private readonly reach = new Float64Array(4);
  private readonly stiffness = new Float64Array(4);
  private readonly pull = new Float64Array(4);
  /** (3) g. */
  private readonly moment = new Float64Array(3);
  private readonly H = new Float64Array(16);
  /** (4, 4): F's columns and the angles' right side, by half of H⁻¹. */
  private readonly halves = new Float64Array(16);

  /**
   * Where the finger is: springs and slopes.
   * @param joints (4, 3) m, as displayed now.
   * @param axes (5, 4, 3) as displayed now, q (5, 4) and bounds (5, 4, 2).
   * @param finger which of the five this is.
   */
  linearise(
    joints: Float64Array,
    axes: Float64Array,
    q: Float64Array,
    bounds: Float64Array,
    finger: number,
  ): void {
    const { F, reach, stiffness, pull } = this;
    for (let n = 0; n < 4; n++) {
      const angle = q[4 * finger + n]!;
      const beyond = angle - bounded(q, bounds, 4 * finger + n);
      const spring = n === 1 ? ABDUCT : FLEX;
      stiffness[n] = beyond === 0 ? spring : spring + LIMIT;
      pull[n] = spring * angle + LIMIT * beyond;
      const j = n === 0 ? 0 : 3 * n - 3;
      const x = joints[9]! - joints[j]!;
      const y = joints[10]! - joints[j + 1]!;
      const z = joints[11]! - joints[j + 2]!;
      reach[n] = Math.sqrt(x * x + y * y + z * z);
      const at = 12 * finger + 3 * n;
      const a0 = axes[at]!;
      const a1 = axes[at + 1]!;
      const a2 = axes[at + 2]!;
      F[3 * n] = a1 * z - a2 * y;
      F[3 * n + 1] = a2 * x - a0 * z;
      F[3 * n + 2] = a0 * y - a1 * x;
    }
  }

  /**
   * Eliminate the angles, adding what is left to the palm's equations A δ = b; lower half of A.
   * @param axes (5, 4, 3) as displayed now.
   * @param curved whether paths bend, or are damped instead.
   * @returns false where springs do not outweigh the bending; A and b are then not to be used.
   */
  eliminate(
    weight: number,
    axes: Float64Array,
    finger: number,
    curved: boolean,
    A: Float64Array,
    b: Float64Array,
  ): boolean {
    const { F, H, halves, miss, pull, stiffness } = this;
    const damping = this.setCurvature(weight, axes, 12 * finger, curved);
    for (let n = 0; n < 4; n++) {
      const f0 = F[3 * n]!;
      const f1 = F[3 * n + 1]!;
      const f2 = F[3 * n + 2]!;
      for (let m = 0; m <= n; m++) {
        const fF = f0 * F[3 * m]! + f1 * F[3 * m + 1]! + f2 * F[3 * m + 2]!;
        H[4 * n + m] = H[4 * n + m]! + weight * fF;
      }
      H[5 * n] = H[5 * n]! + stiffness[n]!;
      halves[n] = f0;
      halves[4 + n] = f1;
      halves[8 + n] = f2;
      halves[12 + n] = weight * (f0 * miss[0]! + f1 * miss[1]! + f2 * miss[2]!) - pull[n]!;
    }
    if (!factorFour(H, stiffness)) {
      return false;
    }
    for (let m = 0; m < 16; m += 4) {
      halfSolveFour(H, halves, m);
    }
    this.addTo(weight, damping, A, b);
    return true;
  }

  /**
   * What is left of the finger, into the palm's equations. With N = F H⁻¹ Fᵀ and r = F H⁻¹ p, p the
   * angles' right side, shift and turn are left with
   *
   *     w I − w² N,   w [a] − w [g] N,   w [a][a]ᵀ + K − [g] N [g]ᵀ;   w (miss − r),   w a × miss − g × r,
   *
   * [a] the matrix of a ×. w [a][a]ᵀ + K, K how the path by the turn bends, is the symmetric part of
   * g·a I − g aᵀ.
   */
  private addTo(w: number, damping: number, A: Float64Array, b: Float64Array): void {
    const { arm, halves: h, miss, moment } = this;
    const n00 = h[0]! * h[0]! + h[1]! * h[1]! + h[2]! * h[2]! + h[3]! * h[3]!;
    const n10 = h[4]! * h[0]! + h[5]! * h[1]! + h[6]! * h[2]! + h[7]! * h[3]!;
    const n11 = h[4]! * h[4]! + h[5]! * h[5]! + h[6]! * h[6]! + h[7]! * h[7]!;
    const n20 = h[8]! * h[0]! + h[9]! * h[1]! + h[10]! * h[2]! + h[11]! * h[3]!;
    const n21 = h[8]! * h[4]! + h[9]! * h[5]! + h[10]! * h[6]! + h[11]! * h[7]!;
    const n22 = h[8]! * h[8]! + h[9]! * h[9]! + h[10]! * h[10]! + h[11]! * h[11]!;
    const r0 = h[0]! * h[12]! + h[1]! * h[13]! + h[2]! * h[14]! + h[3]! * h[15]!;
    const r1 = h[4]! * h[12]! + h[5]! * h[13]! + h[6]! * h[14]! + h[7]! * h[15]!;
    const r2 = h[8]! * h[12]! + h[9]! * h[13]! + h[10]! * h[14]! + h[11]! * h[15]!;
    const ww = w * w;
    A[0] = A[0]! + (w - ww * n00);
    A[6] = A[6]! - ww * n10;
    A[7] = A[7]! + (w - ww * n11);
    A[12] = A[12]! - ww * n20;
    A[13] = A[13]! - ww * n21;
    A[14] = A[14]! + (w - ww * n22);
    const a0 = arm[0]!;
    const a1 = arm[1]!;
    const a2 = arm[2]!;
    const g0 = moment[0]!;
    const g1 = moment[1]!;
    const g2 = moment[2]!;
    // [g] N
    const x00 = g1 * n20 - g2 * n10;
    const x01 = g1 * n21 - g2 * n11;
    const x02 = g1 * n22 - g2 * n21;
    const x10 = g2 * n00 - g0 * n20;
    const x11 = g2 * n10 - g0 * n21;
    const x12 = g2 * n20 - g0 * n22;
    const x20 = g0 * n10 - g1 * n00;
    const x21 = g0 * n11 - g1 * n10;
    const x22 = g0 * n21 - g1 * n20;
    A[18] = A[18]! - w * x00;
    A[19] = A[19]! - w * (a2 + x01);
    A[20] = A[20]! + w * (a1 - x02);
    A[24] = A[24]! + w * (a2 - x10);
    A[25] = A[25]! - w * x11;
    A[26] = A[26]! - w * (a0 + x12);
    A[30] = A[30]! - w * (a1 + x20);
    A[31] = A[31]! + w * (a0 - x21);
    A[32] = A[32]! - w * x22;
    A[21] = A[21]! + (g1 * a1 + g2 * a2 + damping - (g1 * x02 - g2 * x01));
    A[27] = A[27]! - (0.5 * (g0 * a1 + g1 * a0) + (g1 * x12 - g2 * x11));
    A[28] = A[28]! + (g0 * a0 + g2 * a2 + damping - (g2 * x10 - g0 * x12));
    A[33] = A[33]! - (0.5 * (g0 * a2 + g2 * a0) + (g1 * x22 - g2 * x21));
    A[34] = A[34]! - (0.5 * (g1 * a2 + g2 * a1) + (g2 * x20 - g0 * x22));
    A[35] = A[35]! + (g0 * a0 + g1 * a1 + damping - (g0 * x21 - g1 * x20));
    const m0 = w * miss[0]!;
    const m1 = w * miss[1]!;
    const m2 = w * miss[2]!;
    b[0] = b[0]! + (m0 - w * r0);
    b[1] = b[1]! + (m1 - w * r1);
    b[2] = b[2]! + (m2 - w * r2);
    b[3] = b[3]! + (a1 * m2 - a2 * m1 - (g1 * r2 - g2 * r1));
    b[4] = b[4]! + (a2 * m0 - a0 * m2 - (g2 * r0 - g0 * r2));
    b[5] = b[5]! + (a0 * m1 - a1 * m0 - (g0 * r1 - g1 * r0));
  }

  /** What the palm's step δ leaves to the angles, and the force that is left. */
  follow(weight: number, delta: Float64Array): void {
    const { F, H, arm, bend, force, halves, miss, moment } = this;
    const s0 = delta[0]!;
    const s1 = delta[1]!;
    const s2 = delta[2]!;
    const t0 = delta[3]!;
    const t1 = delta[4]!;
    const t2 = delta[5]!;
    const y0 = weight * s0 + (t1 * moment[2]! - t2 * moment[1]!);
    const y1 = weight * s1 + (t2 * moment[0]! - t0 * moment[2]!);
    const y2 = weight * s2 + (t0 * moment[1]! - t1 * moment[0]!);
    for (let n = 0; n < 4; n++) {
      const palm = halves[n]! * y0 + halves[4 + n]! * y1 + halves[8 + n]! * y2;
      bend[n] = halves[12 + n]! - palm;
    }
    otherHalfFour(H, bend);
    let left0 = miss[0]! - s0 - (t1 * arm[2]! - t2 * arm[1]!);
    let left1 = miss[1]! - s1 - (t2 * arm[0]! - t0 * arm[2]!);
    let left2 = miss[2]! - s2 - (t0 * arm[1]! - t1 * arm[0]!);
    for (let n = 0; n < 4; n++) {
      const angle = bend[n]!;
      left0 -= F[3 * n]! * angle;
      left1 -= F[3 * n + 1]! * angle;
      left2 -= F[3 * n + 2]! * angle;
    }
    force[0] = weight * left0;
    force[1] = weight * left1;
    force[2] = weight * left2;
  }

  /**
   * g, and −f · ∂²tip by two angles into H; or what damps instead, which for the palm's turn is
   * returned.
   */
  private setCurvature(weight: number, axes: Float64Array, at: number, curved: boolean): number {
    const { F, H, arm, force, moment, reach } = this;
    const f0 = force[0]!;
    const f1 = force[1]!;
    const f2 = force[2]!;
    const g0 = weight * arm[0]!;
    const g1 = weight * arm[1]!;
    const g2 = weight * arm[2]!;
    if (curved) {
      moment[0] = g0 + f0;
      moment[1] = g1 + f1;
      moment[2] = g2 + f2;
      for (let n = 0; n < 4; n++) {
        const c0 = f1 * F[3 * n + 2]! - f2 * F[3 * n + 1]!;
        const c1 = f2 * F[3 * n]! - f0 * F[3 * n + 2]!;
        const c2 = f0 * F[3 * n + 1]! - f1 * F[3 * n]!;
        for (let m = 0; m <= n; m++) {
          const axis = at + 3 * m;
          H[4 * n + m] = axes[axis]! * c0 + axes[axis + 1]! * c1 + axes[axis + 2]! * c2;
        }
      }
      return 0;
    }
    moment[0] = g0;
    moment[1] = g1;
    moment[2] = g2;
    const size = Math.sqrt(f0 * f0 + f1 * f1 + f2 * f2);
    H.fill(0);
    for (let n = 0; n < 4; n++) {
      H[5 * n] = size * reach[n]!;
    }
    return size * Math.sqrt(arm[0]! * arm[0]! + arm[1]! * arm[1]! + arm[2]! * arm[2]!);
  }
}

/** An angle, within its bounds. */
export function bounded(q: Float64Array, bounds: Float64Array, at: number): number {
  return Math.min(Math.max(q[at]!, bounds[2 * at]!), bounds[2 * at + 1]!);
}
