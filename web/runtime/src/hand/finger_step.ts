import { factorFour, halfSolveFour, otherHalf } from "./definite.js";

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
 */
export class FingerStep {
  /** (3) m, from the tip to where it should be, and from the palm's centre to the tip. */
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
  private readonly H = new Float64Array(16);
  /** (7, 4): the palm's six columns and the right side, by half of H⁻¹. */
  private readonly halves = new Float64Array(28);
  /** (3, 3): f · ∂²tip by the palm's turn; lower half. */
  private readonly K = new Float64Array(9);
  private readonly P = Float64Array.of(1, 0, 0, 0, 1, 0, 0, 0, 1, 0, 0, 0, 0, 0, 0, 0, 0, 0);

  /**
   * Where the finger is: springs and slopes.
   * @param joints (4, 3) m and axes (4, 3), as displayed now.
   * @param q its four angles, and `bounds` (4, 2) theirs, from `at` and 2 `at` on.
   */
  linearise(
    joints: Float64Array,
    axes: Float64Array,
    q: Float64Array,
    bounds: Float64Array,
    at: number,
  ): void {
    const { F, P, arm, reach, stiffness, pull } = this;
    for (let n = 0; n < 4; n++) {
      const angle = q[at + n]!;
      const beyond = angle - bounded(q, bounds, at + n);
      const spring = n === 1 ? ABDUCT : FLEX;
      stiffness[n] = beyond === 0 ? spring : spring + LIMIT;
      pull[n] = spring * angle + LIMIT * beyond;
      const j = 3 * Math.max(n - 1, 0);
      const x = joints[9]! - joints[j]!;
      const y = joints[10]! - joints[j + 1]!;
      const z = joints[11]! - joints[j + 2]!;
      reach[n] = Math.sqrt(x * x + y * y + z * z);
      F[3 * n] = axes[3 * n + 1]! * z - axes[3 * n + 2]! * y;
      F[3 * n + 1] = axes[3 * n + 2]! * x - axes[3 * n]! * z;
      F[3 * n + 2] = axes[3 * n]! * y - axes[3 * n + 1]! * x;
    }
    // the tip's motion by the palm's: rows 0 … 2 by its shift, 3 … 5 by its turn
    P[10] = -arm[2]!;
    P[11] = arm[1]!;
    P[12] = arm[2]!;
    P[14] = -arm[0]!;
    P[15] = -arm[1]!;
    P[16] = arm[0]!;
  }

  /**
   * Eliminate the angles, adding what is left to the palm's equations A δ = b; lower half of A.
   * @param axes (4, 3) as displayed now, from `at` on.
   * @param curved whether paths bend, or are damped instead.
   * @returns false where springs do not outweigh the bending; A and b are then not to be used.
   */
  eliminate(
    weight: number,
    axes: Float64Array,
    at: number,
    curved: boolean,
    A: Float64Array,
    b: Float64Array,
  ): boolean {
    const { F, H, P, halves, miss, pull, stiffness } = this;
    this.setCurvature(axes, at, curved);
    for (let n = 0; n < 4; n++) {
      const f0 = weight * F[3 * n]!;
      const f1 = weight * F[3 * n + 1]!;
      const f2 = weight * F[3 * n + 2]!;
      for (let m = 0; m <= n; m++) {
        const fF = f0 * F[3 * m]! + f1 * F[3 * m + 1]! + f2 * F[3 * m + 2]!;
        H[4 * n + m] = H[4 * n + m]! + fF;
      }
      H[5 * n] = H[5 * n]! + stiffness[n]!;
      // P begins with the unit matrix, and its other half is a cross product's
      halves[n] = f0;
      halves[4 + n] = f1;
      halves[8 + n] = f2;
      halves[12 + n] = halves[12 + n]! + (f1 * P[10]! + f2 * P[11]!);
      halves[16 + n] = halves[16 + n]! + (f0 * P[12]! + f2 * P[14]!);
      halves[20 + n] = halves[20 + n]! + (f0 * P[15]! + f1 * P[16]!);
      halves[24 + n] = f0 * miss[0]! + f1 * miss[1]! + f2 * miss[2]! - pull[n]!;
    }
    if (!factorFour(H, stiffness)) {
      return false;
    }
    for (let m = 0; m < 28; m += 4) {
      halfSolveFour(H, halves, m);
    }
    this.addTo(weight, A, b);
    return true;
  }

  /** What is left of the finger, into the palm's equations. */
  private addTo(weight: number, A: Float64Array, b: Float64Array): void {
    const { K, P, halves, miss } = this;
    for (let m = 0; m < 6; m++) {
      const h0 = halves[4 * m]!;
      const h1 = halves[4 * m + 1]!;
      const h2 = halves[4 * m + 2]!;
      const h3 = halves[4 * m + 3]!;
      const p0 = weight * P[3 * m]!;
      const p1 = weight * P[3 * m + 1]!;
      const p2 = weight * P[3 * m + 2]!;
      for (let n = 0; n <= m; n++) {
        const by = 4 * n;
        const gone =
          h0 * halves[by]! + h1 * halves[by + 1]! + h2 * halves[by + 2]! + h3 * halves[by + 3]!;
        // the palm's shift is the tip's own
        const own =
          n < 3 ? weight * P[3 * m + n]! : p0 * P[3 * n]! + p1 * P[3 * n + 1]! + p2 * P[3 * n + 2]!;
        const bent = n < 3 ? 0 : K[3 * m + n - 12]!;
        A[6 * m + n] = A[6 * m + n]! + (own - gone + bent);
      }
      const own = p0 * miss[0]! + p1 * miss[1]! + p2 * miss[2]!;
      const gone = h0 * halves[24]! + h1 * halves[25]! + h2 * halves[26]! + h3 * halves[27]!;
      b[m] = b[m]! + (own - gone);
    }
  }

  /** What the palm's step δ leaves to the angles, and the force that is left. */
  follow(weight: number, delta: Float64Array): void {
    const { F, H, P, bend, force, halves, miss } = this;
    for (let n = 0; n < 4; n++) {
      let sum = halves[24 + n]!;
      for (let m = 0; m < 6; m++) {
        sum -= halves[4 * m + n]! * delta[m]!;
      }
      bend[n] = sum;
    }
    otherHalf(H, 4, bend);
    for (let d = 0; d < 3; d++) {
      let left = miss[d]!;
      for (let m = 0; m < 6; m++) {
        left -= P[3 * m + d]! * delta[m]!;
      }
      for (let n = 0; n < 4; n++) {
        left -= F[3 * n + d]! * bend[n]!;
      }
      force[d] = weight * left;
    }
  }

  /** −f · ∂²tip: by two angles into H, by an angle and the palm's turn into `halves`, by the turn into K. */
  private setCurvature(axes: Float64Array, at: number, curved: boolean): void {
    const { F, H, K, arm, force, halves, reach } = this;
    const f0 = force[0]!;
    const f1 = force[1]!;
    const f2 = force[2]!;
    const x = arm[0]!;
    const y = arm[1]!;
    const z = arm[2]!;
    if (curved) {
      for (let n = 0; n < 4; n++) {
        const c0 = f1 * F[3 * n + 2]! - f2 * F[3 * n + 1]!;
        const c1 = f2 * F[3 * n]! - f0 * F[3 * n + 2]!;
        const c2 = f0 * F[3 * n + 1]! - f1 * F[3 * n]!;
        halves[12 + n] = c0;
        halves[16 + n] = c1;
        halves[20 + n] = c2;
        for (let m = 0; m <= n; m++) {
          const axis = at + 3 * m;
          H[4 * n + m] = axes[axis]! * c0 + axes[axis + 1]! * c1 + axes[axis + 2]! * c2;
        }
      }
      K[0] = f1 * y + f2 * z;
      K[3] = -0.5 * (f0 * y + f1 * x);
      K[4] = f0 * x + f2 * z;
      K[6] = -0.5 * (f0 * z + f2 * x);
      K[7] = -0.5 * (f1 * z + f2 * y);
      K[8] = f0 * x + f1 * y;
      return;
    }
    const size = Math.sqrt(f0 * f0 + f1 * f1 + f2 * f2);
    H.fill(0);
    halves.fill(0);
    K.fill(0);
    for (let n = 0; n < 4; n++) {
      H[5 * n] = size * reach[n]!;
    }
    K[0] = size * Math.sqrt(x * x + y * y + z * z);
    K[4] = K[0];
    K[8] = K[0];
  }
}

/** An angle, within its bounds. */
export function bounded(q: Float64Array, bounds: Float64Array, at: number): number {
  return Math.min(Math.max(q[at]!, bounds[2 * at]!), bounds[2 * at + 1]!);
}
