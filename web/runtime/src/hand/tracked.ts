import { multiplyTransposed } from "./rotation.js";
import { BASES, JOINT_COUNT, LIMITS, PARENTS, TIPS } from "./skeleton.js";
import type { HandSolver } from "./solver.js";

/** The tracked hand of one frame, taken apart for the solver. */
export class TrackedHand {
  /** (25, 9) row by row, and (25, 3) m. */
  readonly rotations = new Float64Array(9 * JOINT_COUNT);
  readonly positions = new Float64Array(3 * JOINT_COUNT);
  /** (25) whether the joint is tracked; (5) whether all of a finger is. */
  readonly known = new Uint8Array(JOINT_COUNT);
  readonly present = new Uint8Array(5);
  readonly radii = new Float64Array(5);
  /** Whether wrist and knuckles are tracked. */
  palmKnown = false;
  private readonly above = new Float64Array(9);
  private readonly below = new Float64Array(9);
  private readonly R = new Float64Array(9);

  /** Poses are matrices, column-major, from `first` (in joints) on. */
  read(
    poses: ArrayLike<number>,
    radii: ArrayLike<number> | null,
    first: number,
    tipRadius: number,
  ): void {
    const { rotations, positions, known, present } = this;
    for (let j = 0; j < JOINT_COUNT; j++) {
      const at = 16 * (first + j);
      let sum = 0;
      for (let e = 0; e < 3; e++) {
        for (let d = 0; d < 3; d++) {
          const entry = poses[at + 4 * e + d]!;
          rotations[9 * j + 3 * d + e] = entry;
          sum += entry;
        }
        positions[3 * j + e] = poses[at + 12 + e]!;
        sum += poses[at + 12 + e]!;
      }
      known[j] = Number.isFinite(sum) ? 1 : 0;
    }
    this.palmKnown = known[0] === 1;
    for (let i = 0; i < 5; i++) {
      const base = BASES[i]!;
      let all = known[base]! & known[PARENTS[i]!]!;
      if (i > 0 && known[base] === 0) {
        this.palmKnown = false;
      }
      for (let n = 1; n < 4; n++) {
        all &= known[base + n]!;
      }
      present[i] = all;
      const radius = radii === null ? Number.NaN : radii[first + TIPS[i]!]!;
      this.radii[i] = radius > 0 ? radius : tipRadius;
    }
  }

  /** Chains, axes and bounds of all fingers, into the solver. */
  prepare(solver: HandSolver): void {
    const { rotations: C, positions, R, above, below } = this;
    const { chain, axes, bounds } = solver;
    for (let i = 0; i < 5; i++) {
      const base = BASES[i]!;
      for (let n = 0; n < 12; n++) {
        chain[12 * i + n] = positions[3 * base + n]!;
      }
      for (let n = 0; n < 3; n++) {
        // of the base relative to its parent, of the second joint relative to the base, …
        const parent = 9 * (n === 0 ? PARENTS[i]! : base + n - 1);
        const child = 9 * (base + n);
        for (let d = 0; d < 3; d++) {
          for (let e = 0; e < 3; e++) {
            above[3 * d + e] = C[parent + 3 * e + d]!;
            below[3 * d + e] = C[child + 3 * e + d]!;
          }
        }
        multiplyTransposed(above, below, R);
        // R = Rx(flexion) Ry(abduction) Rz(twist), so R e_z has no twist in it
        const flexion = Math.atan2(-R[5]!, R[8]!);
        const at = 12 * i + (n === 0 ? 0 : 3 * (n + 1));
        for (let d = 0; d < 3; d++) {
          axes[at + d] = C[parent + 3 * d]!;
        }
        setBounds(bounds, i, n === 0 ? 0 : n + 1, flexion);
        if (n === 0) {
          const c = Math.cos(flexion);
          const s = Math.sin(flexion);
          for (let d = 0; d < 3; d++) {
            axes[at + 3 + d] = c * C[parent + 3 * d + 1]! + s * C[parent + 3 * d + 2]!;
          }
          setBounds(bounds, i, 1, Math.asin(Math.min(Math.max(R[2]!, -1), 1)));
        }
      }
    }
  }
}

function setBounds(bounds: Float64Array, finger: number, n: number, tracked: number): void {
  const at = 8 * finger + 2 * n;
  bounds[at] = Math.min(0, LIMITS[at]! - tracked);
  bounds[at + 1] = Math.max(0, LIMITS[at + 1]! - tracked);
}
