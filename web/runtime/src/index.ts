/**
 * touchwarp's runtime: reads warp files and displaces hands.
 *
 * Lengths are metres, angles radians, times seconds. A matrix is 16 numbers in column-major order,
 * as in WebXR (`XRRigidTransform.matrix`) and three.js (`Matrix4.elements`); `T_to_from` takes points
 * of the frame `from` to the frame `to`. Points are rows of x, y, z in one array (x, y in a plane
 * scene). Calls that run at display rate write into the caller's arrays and allocate nothing.
 */

/** Rows of coordinates, in m. */
export type Points = Float32Array | Float64Array;

/** A column-major matrix: 16 numbers in space, 9 in a plane scene. */
export type Matrix = ArrayLike<number>;

/** Triangles of a prop and of its virtual object, thinned out for pictures; scene frame. */
export interface Outline {
  readonly name: string;
  readonly prop: Float32Array;
  readonly virtual: Float32Array;
  readonly faces: Int32Array;
}

/** What a warp file says of itself; see docs/warp-file.md. */
export interface WarpMeta {
  readonly kind: "warp" | "bases";
  readonly dimension: 2 | 3;
  /** The scene file's TOML. */
  readonly scene: string;
  readonly propNames: readonly string[];
  readonly outlines: readonly Outline[];
  /** Least and greatest corner of ∂Ω1 (or of the box around it), scene frame. */
  readonly outerBox: { readonly low: readonly number[]; readonly high: readonly number[] } | null;
  readonly outerSurface: { readonly vertices: Float32Array; readonly faces: Int32Array } | null;
  readonly toleranceMm: number;
  readonly edgeRadiusMm: number;
  readonly estimatedErrorMaxMm: number | null;
  readonly estimatedErrorRmsMm: number | null;
  /** The greatest |u| lost by storing float16; 0 for float32. */
  readonly storageErrorMm: number;
  /** Affine goals by prop, column-major, scene to scene, where known. */
  readonly goals: ReadonlyMap<string, Float64Array>;
  /** Where the file's scene stands in the room (column-major). */
  readonly T_room_scene: Float64Array;
  readonly notes: Readonly<Record<string, unknown>>;
}

/** A map of space f(x) = x + u(x), from tracked to displayed positions, room frame. */
export interface Warp {
  readonly meta: WarpMeta;
  /** Coordinates a row: 3, or 2 in a plane scene. */
  readonly dimension: 2 | 3;
  /** Levels of detail that lookups use now; grows while a file arrives. */
  readonly levelsLoaded: number;
  readonly levelCount: number;
  /** A bound on |u| in m, over the levels loaded. */
  readonly maxDisplacement: number;
  /** f(x) of each row into `out` (which may be `points`); a row with a NaN gives NaN. */
  displayed(points: Points, out: Points): void;
  /** u(x) = f(x) − x of each row; 0 outside ∂Ω1. */
  displacement(points: Points, out: Points): void;
  /** ∂f/∂x of each row, d × d numbers column-major: out[d·d·n + d·j + i] = ∂f_i/∂x_j. */
  jacobian(points: Points, out: Points): void;
  /** Real positions that are displayed at each row, under folds the nearest; NaN where none is.
   * Returns how many were found. Not for every frame: a search, some 10 µs to 1 ms a point. */
  inverse(points: Points, out: Points): number;
  /** Carry the warp: from now on x ↦ T f(T⁻¹ x), f as the file was loaded (T does not add to the
   * last call's). T is rigid. Allocates nothing. */
  place(T_room_scene: Matrix): void;
  /** The same table carried elsewhere, as an object of its own; numbers are shared. */
  at(T_room_scene: Matrix): Warp;
}

/** The warp of affine goals, summed from basis fields at each lookup. */
export interface AffineWarp extends Warp {
  /** Give a prop another affine goal, x ↦ A x + t from scene to scene: at once, no solve. */
  setGoal(prop: string, T_goal: Matrix): void;
  /** Whether the goals lie in the range in which the bases' estimate holds. */
  readonly withinRange: boolean;
  /** The estimated error in mm, grown in proportion outside that range; null without estimate. */
  readonly errorBoundMm: number | null;
}

/** What a file of `kind` "bases" holds. */
export interface AffineBases {
  readonly meta: WarpMeta;
  readonly propNames: readonly string[];
  readonly levelsLoaded: number;
  readonly levelCount: number;
  /** A warp whose goals can be changed at display rate; props not named stay where they are. */
  warp(goals?: Readonly<Record<string, Matrix>>): AffineWarp;
}

/** A warp file that is wrong, truncated, newer or foreign; the message says what to do. */
export declare class WarpFileError extends Error {}

/** A goal that bases cannot reach: not affine, not finite, or of an unknown prop. */
export declare class GoalError extends Error {}

/** A whole warp file in memory. */
export declare function parseWarp(
  bytes: ArrayBuffer | Uint8Array,
  name?: string,
): Warp | AffineBases;

/** A warp file on its way: usable as soon as `openWarp` gives it, refined as levels arrive. */
export interface ArrivingWarp<W extends Warp | AffineBases = Warp | AffineBases> {
  readonly warp: W;
  /** Fulfilled when all levels are there; rejected with a WarpFileError when the file breaks off. */
  readonly complete: Promise<void>;
}

/** Fetch a warp file, coarse levels first. Fulfilled when the coarsest level can be used. */
export declare function openWarp(
  source: string | URL | Response,
  options?: {
    signal?: AbortSignal;
    /** After each level: how many are there, and bytes received. */
    onLevel?: (levelsLoaded: number, levelCount: number) => void;
    onProgress?: (bytes: number, total: number | null) => void;
  },
): Promise<ArrivingWarp>;

/** Joints in the order of WebXR's `XRHand`, 25; OpenXR has a palm before them. */
export type JointName =
  | "wrist"
  | `thumb-${"metacarpal" | "phalanx-proximal" | "phalanx-distal" | "tip"}`
  | `${"index" | "middle" | "ring" | "pinky"}-finger-${
      | "metacarpal"
      | "phalanx-proximal"
      | "phalanx-intermediate"
      | "phalanx-distal"
      | "tip"}`;

export interface HandOptions {
  /** `fingertips`: all five tips at their warped places, the rest by inverse kinematics.
   * `rigid`: one finger leads, the hand follows as a whole. `points`: each joint by itself. */
  mode?: "fingertips" | "rigid" | "points";
  /** The leading finger of `rigid`: 0 thumb … 4 little finger. */
  leader?: number;
  /** `as_tracked` keeps joint orientations; `turned` adds the rotation part of ∂f. */
  orientation?: "as_tracked" | "turned";
  /** Warp the skin that touches rather than the centre of the joint. */
  contact?: boolean;
  /** Radius of a fingertip in m where the device gives none. */
  tipRadius?: number;
  /** Seconds from no displacement to all of it. */
  onset?: number;
}

/** One hand's displayed joints from its tracked ones, frame by frame. */
export declare class HandRetargeter {
  constructor(options?: HandOptions);
  options: HandOptions;
  /** The share of the displacement that is shown now, 0 to 1; contact may be claimed only at 1. */
  readonly weight: number;
  /** Distance of each displayed fingertip from where it should be, m; NaN where lost. */
  readonly tipErrors: Float64Array;
  /** Ease the displacement in or out; a lost hand and a change of warp ease in by themselves. */
  active: boolean;
  /**
   * One frame.
   * @param poses 25 × 16 numbers, as `XRFrame.fillPoses` gives them; NaN where not tracked.
   * @param radii 25 numbers, as `XRFrame.fillJointRadii` gives them; NaN where unknown.
   * @param time s, of the frame (its predicted display time).
   * @param displayed 25 × 16 numbers, written; NaN where not tracked. May be `poses`.
   */
  update(
    warp: Warp | null,
    poses: Float32Array,
    radii: Float32Array,
    time: number,
    displayed: Float32Array,
  ): void;
}

/** The warp of a prop that is carried, with the judgement whether it still holds. */
export declare class CarriedWarp {
  constructor(
    warp: Warp,
    options?: { fixedSurroundings?: boolean; allowedShift?: number; allowedTurn?: number },
  );
  readonly warp: Warp;
  /** False where surroundings are fixed in Ω and the prop has moved farther than allowed. */
  readonly valid: boolean;
  /** The prop's pose at `time`; samples may be older or newer than the frame. */
  addPose(T_room_scene: Matrix, time: number): void;
  /** Place the warp as at `time`, by interpolation between the poses around it. */
  placeAt(time: number): void;
}
