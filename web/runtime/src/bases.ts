/**
 * Instant goals: the warp of any affine goal as a sum of basis fields solved once.
 *
 * For the goal x ↦ A x + t of a prop, with B = Rᵀ (A − I) R and b = Rᵀ ((A − I) o + t) in the table
 * frame, u is the sum of the prop's four channels times B c + b and s B, see docs/warp-file.md.
 */

import type { Bricks } from "./bricks.js";
import { GoalError } from "./errors.js";
import { addedError } from "./meta.js";
import { TableWarp } from "./table.js";
import type { Matrix, WarpMeta } from "./warp.js";

/** Channels of one prop. */
const LANES = 4;

/** What a file of `kind` "bases" holds. */
export class AffineBases {
  readonly meta: WarpMeta;
  private readonly bricks: Bricks;

  /** @throws Error where channels or scalings are not as many as the props ask for. */
  constructor(bricks: Bricks, meta: WarpMeta) {
    const { propNames, basis } = meta;
    if (propNames.length !== basis.size || !propNames.every((name) => basis.has(name))) {
      throw new Error(
        `Bases of the props ${propNames} have scalings for ${[...basis.keys()]}; one for each prop is needed.`,
      );
    }
    const needed = LANES * propNames.length * (bricks.mirrorDepth > 0 ? 2 : 1);
    if (bricks.channels !== needed || needed === 0) {
      throw new Error(
        `Bases of ${propNames.length} props have ${bricks.channels} channels; ${needed} are needed.`,
      );
    }
    this.bricks = bricks;
    this.meta = meta;
  }

  get propNames(): readonly string[] {
    return this.meta.propNames;
  }

  get levelsLoaded(): number {
    return this.bricks.levelsLoaded;
  }

  get levelCount(): number {
    return this.bricks.levelCount;
  }

  /** As `Warp.addedErrorMm`, over the stated range of goals. */
  get addedErrorMm(): number {
    return addedError(this.meta, this.levelsLoaded, this.levelCount);
  }

  /**
   * A warp whose goals can be changed at display rate; a prop not named stays where it is.
   * @throws GoalError as `AffineWarp.setGoal`.
   */
  warp(goals: Readonly<Record<string, Matrix>> = {}): AffineWarp {
    const warp = new AffineWarp(this.bricks, this.meta);
    for (const [name, goal] of Object.entries(goals)) {
      warp.setGoal(name, goal);
    }
    return warp;
  }
}

/** The warp of affine goals, summed from basis fields at each lookup. */
export class AffineWarp extends TableWarp {
  private readonly excess: Float64Array;
  private readonly centreShift = new Float64Array(3);
  private readonly stretch = new Float64Array(9);
  private readonly bricks: Bricks;

  constructor(bricks: Bricks, meta: WarpMeta) {
    super(bricks, meta, new Float64Array(3 * bricks.channels));
    this.bricks = bricks;
    this.excess = new Float64Array(meta.propNames.length);
  }

  /**
   * Give a prop another goal, x ↦ A x + t from scene to scene (column-major): at once, no solve.
   * @throws GoalError the prop is unknown, or the matrix is not finite or not affine.
   */
  setGoal(prop: string, T_goal: Matrix): void {
    const p = this.meta.propNames.indexOf(prop);
    if (p < 0) {
      throw new GoalError(
        `There is no prop '${prop}' in these bases; they have ${this.meta.propNames.map((name) => `'${name}'`).join(", ")}.`,
      );
    }
    checkAffine(prop, T_goal);
    const { centre, halfDiagonal } = this.meta.basis.get(prop)!;
    const { centreShift: d, stretch: B } = this;
    toTableFrame(T_goal, this.bricks.T_scene_table, centre, d, B);
    const { mix } = this.lookup;
    const half = this.bricks.mirrorDepth > 0 ? LANES * this.meta.propNames.length : 0;
    for (let k = 0; k < 3; k++) {
      // over a sliding plane the normal component has basis fields of its own
      const lane = LANES * p + (k === 2 ? half : 0);
      mix[3 * lane + k] = d[k]!;
      for (let j = 0; j < 3; j++) {
        mix[3 * (lane + 1 + j) + k] = B[3 * k + j]! * halfDiagonal;
      }
    }
    this.excess[p] = Math.max(
      Math.hypot(d[0]!, d[1]!, d[2]!) / this.meta.rangeShift,
      spectralNorm(B) / this.meta.rangeStretch,
    );
    this.mixChanged();
  }

  /** Whether the goals lie in the range in which the bases' estimate holds. */
  get withinRange(): boolean {
    return this.most() <= 1;
  }

  /** The estimated error, grown in proportion outside that range; null without an estimate. */
  get errorBoundMm(): number | null {
    const estimate = this.meta.estimatedErrorMaxMm;
    return estimate === null ? null : estimate * Math.max(1, this.most());
  }

  override at(T_room_scene: Matrix): AffineWarp {
    const moved = new AffineWarp(this.bricks, this.meta);
    moved.lookup.mix.set(this.lookup.mix);
    moved.excess.set(this.excess);
    moved.place(T_room_scene);
    return moved;
  }

  private most(): number {
    return this.excess.reduce((a, b) => Math.max(a, b), 0);
  }
}

function checkAffine(prop: string, T: Matrix): void {
  let finite = T.length === 16;
  for (let n = 0; finite && n < 16; n++) {
    finite = Number.isFinite(T[n]!);
  }
  if (!finite) {
    throw new GoalError(
      `The goal of '${prop}' is no finite matrix of 16 numbers, column by column; one from scene to scene is needed.`,
    );
  }
  if (![3, 7, 11].every((n) => Math.abs(T[n]!) <= 1e-9) || Math.abs(T[15]! - 1) > 1e-9) {
    throw new GoalError(
      `The goal of '${prop}' has the last row ${[T[3], T[7], T[11], T[15]]}; an affine one, 0,0,0,1, is needed: other goals take a solve of their own.`,
    );
  }
}

/** B = Rᵀ (A − I) R, row by row, and the displacement B c + b of the place c; table frame. */
function toTableFrame(
  T_goal: Matrix,
  T_table: Float64Array,
  centre: readonly number[],
  shift: Float64Array,
  B: Float64Array,
): void {
  const less = (i: number, j: number): number => T_goal[4 * j + i]! - (i === j ? 1 : 0);
  for (let i = 0; i < 3; i++) {
    let sum = 0;
    for (let g = 0; g < 3; g++) {
      let moved = T_goal[12 + g]!;
      for (let h = 0; h < 3; h++) {
        moved += less(g, h) * T_table[12 + h]!;
      }
      sum += T_table[4 * i + g]! * moved;
    }
    for (let j = 0; j < 3; j++) {
      let entry = 0;
      for (let g = 0; g < 3; g++) {
        for (let h = 0; h < 3; h++) {
          entry += T_table[4 * i + g]! * less(g, h) * T_table[4 * j + h]!;
        }
      }
      B[3 * i + j] = entry;
      sum += entry * centre[j]!;
    }
    shift[i] = sum;
  }
}

/** The greatest singular value of a 3 × 3 matrix: the root of the greatest eigenvalue of BᵀB. */
export function spectralNorm(B: ArrayLike<number>): number {
  const M = (i: number, j: number): number =>
    B[i]! * B[j]! + B[3 + i]! * B[3 + j]! + B[6 + i]! * B[6 + j]!;
  const [a, b, c, d, e, f] = [M(0, 0), M(1, 1), M(2, 2), M(0, 1), M(0, 2), M(1, 2)];
  const mean = (a + b + c) / 3;
  const [A, G, C] = [a - mean, b - mean, c - mean];
  const spread = Math.sqrt((A * A + G * G + C * C + 2 * (d * d + e * e + f * f)) / 6);
  if (spread === 0) {
    return Math.sqrt(mean);
  }
  // Smith's closed form for symmetric matrices
  const half =
    (A * (G * C - f * f) - d * (d * C - f * e) + e * (d * f - G * e)) / (2 * spread ** 3);
  const angle = Math.acos(Math.min(1, Math.max(-1, half))) / 3;
  return Math.sqrt(mean + 2 * spread * Math.cos(angle));
}
