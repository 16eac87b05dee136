/** Rows of coordinates, in m: x, y, z in space, x, y in a plane scene. */
export type Points = Float32Array | Float64Array;

/** A column-major matrix: 16 numbers in space, 9 in a plane scene. */
export type Matrix = ArrayLike<number>;

/** Triangles (segments in a plane scene) of a prop and of its virtual object, thinned out for
 * pictures; m, scene frame. Row i of one is shown at row i of the other. */
export interface Outline {
  readonly name: string;
  readonly prop: Float32Array;
  readonly virtual: Float32Array;
  readonly faces: Int32Array;
}

/** How the boundary data of one prop's basis fields are scaled. */
export interface BasisProp {
  /** m, table frame. */
  readonly centre: readonly number[];
  /** m, half the diagonal of the prop's bounding box. */
  readonly halfDiagonal: number;
}

/** What a warp file says of itself; see docs/warp-file.md. */
export interface WarpMeta {
  readonly kind: "warp" | "bases";
  readonly dimension: 2 | 3;
  /** The scene file's TOML. */
  readonly scene: string;
  readonly propNames: readonly string[];
  readonly outlines: readonly Outline[];
  /** Least and greatest corner of ∂Ω1 (or of the box around it), m, scene frame. */
  readonly outerBox: { readonly low: readonly number[]; readonly high: readonly number[] } | null;
  readonly outerSurface: { readonly vertices: Float32Array; readonly faces: Int32Array } | null;
  readonly toleranceMm: number;
  readonly edgeRadiusMm: number;
  /** The solver's estimate of its error; null where there is none. */
  readonly estimatedErrorMaxMm: number | null;
  readonly estimatedErrorRmsMm: number | null;
  /** The greatest |u| lost by storing float16; 0 for float32. */
  readonly storageErrorMm: number;
  /** By how much u is off at most with the levels up to each one; empty where the file does not
   * tell. In bases, over their stated range. */
  readonly levelErrorsMm: readonly number[];
  /** λ as it enters Δu = λu, in m⁻². */
  readonly screening: number;
  /** Affine goals by prop, column-major, scene to scene, where known. */
  readonly goals: ReadonlyMap<string, Float64Array>;
  /** The scaling of the basis fields by prop; empty for a warp. */
  readonly basis: ReadonlyMap<string, BasisProp>;
  /** The stated range of bases: displacement of a prop's centre in m, and ‖A − I‖₂. */
  readonly rangeShift: number;
  readonly rangeStretch: number;
  /** Where the scene had been carried when the file was written, column-major. */
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
  /**
   * A bound on what u is off by for being stored as float16, and while levels are on their way for
   * their absence; NaN where the file does not tell.
   */
  readonly addedErrorMm: number;
  /** The greatest |u| of the levels loaded, m. The first call after a change reads the table. */
  readonly maxDisplacement: number;
  /**
   * f(x) of each row into `out` (which may be `points`). A row with a NaN gives NaN; so does a
   * place whose values have not arrived yet.
   */
  displayed(points: Points, out: Points): void;
  /** u(x) = f(x) − x of each row; 0 outside ∂Ω1. NaN as for `displayed`. */
  displacement(points: Points, out: Points): void;
  /**
   * ∂f/∂x of each row, d × d numbers column-major: out[d·d·n + d·j + i] = ∂f_i/∂x_j. One-sided on
   * faces of cells: that of the cell on the greater side, in table axes.
   */
  jacobian(points: Points, out: Points): void;
  /**
   * Real positions that are displayed at each row, under folds the nearest; NaN where none is.
   * A search, some µs to ms a point, which allocates: not for every frame.
   * @returns how many were found.
   */
  inverse(points: Points, out: Points): number;
  /**
   * Carry the warp: from now on x ↦ T f(T⁻¹ x), f as the file was loaded (T does not add to the
   * last call's).
   * @throws RangeError where T is not rigid; the warp then stays where it was.
   */
  place(T_room_scene: Matrix): void;
  /** The same table carried elsewhere, T as for `place`, as a warp of its own; numbers are shared. */
  at(T_room_scene: Matrix): Warp;
}
