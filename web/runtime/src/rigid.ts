import type { Matrix } from "./warp.js";

/**
 * Refuse a matrix that is no rotation with a translation.
 * @param T column-major, (d + 1)² numbers.
 * @throws RangeError it has another size, is not finite, or scales, shears or mirrors.
 */
export function checkRigid(T: Matrix, dimension: 2 | 3): void {
  const d = dimension;
  const m = d + 1;
  if (T.length !== m * m) {
    throw new RangeError(
      `T_room_scene has ${T.length} numbers; ${m * m} are needed: a ${m} × ${m} matrix, column by column.`,
    );
  }
  for (let n = 0; n < m * m; n++) {
    if (!Number.isFinite(T[n]!)) {
      throw new RangeError("T_room_scene has NaN or infinite entries; finite numbers are needed.");
    }
  }
  for (let e = 0; e < m; e++) {
    if (Math.abs(T[m * e + d]! - (e === d ? 1 : 0)) > 1e-9) {
      throw new RangeError(
        "T_room_scene has another last row than 0 … 0 1: matrices are column-major here; pass the transpose if yours are stored row by row.",
      );
    }
  }
  // float32 matrices, as WebXR gives them, are rigid to some 1e-7
  let departure = 0;
  for (let i = 0; i < d; i++) {
    for (let j = 0; j < d; j++) {
      let product = i === j ? -1 : 0;
      for (let e = 0; e < d; e++) {
        product += T[m * i + e]! * T[m * j + e]!;
      }
      departure = Math.max(departure, Math.abs(product));
    }
  }
  if (departure > 1e-6 || determinant(T, d) < 0) {
    throw new RangeError(
      `T_room_scene is not rigid: its ${d} × ${d} part departs from a rotation by ${departure.toPrecision(2)} or mirrors; a rotation and a translation are needed. To scale or shear, change the goal instead.`,
    );
  }
}

function determinant(T: Matrix, d: 2 | 3): number {
  if (d === 2) {
    return T[0]! * T[4]! - T[1]! * T[3]!;
  }
  return (
    T[0]! * (T[5]! * T[10]! - T[6]! * T[9]!) -
    T[4]! * (T[1]! * T[10]! - T[2]! * T[9]!) +
    T[8]! * (T[1]! * T[6]! - T[2]! * T[5]!)
  );
}

/** The transpose: row-major numbers as a file has them, to column-major. */
export function columnMajor(rows: ArrayLike<number>, m: number): Float64Array {
  const out = new Float64Array(m * m);
  for (let i = 0; i < m; i++) {
    for (let j = 0; j < m; j++) {
      out[m * j + i] = rows[m * i + j]!;
    }
  }
  return out;
}
