/** The files that the Python library is tested with, too; tests/vectors/generate.py makes them. */

import { readFileSync } from "node:fs";
import { AffineBases, parseWarp, type Warp } from "../src/index.js";
import { columnMajor } from "../src/rigid.js";
import { PREFIX, readHeader, readHeaderLength, readTensor } from "../src/tensors.js";

const FOLDER = new URL("../../../tests/vectors/", import.meta.url);

export function fileBytes(name: string): Uint8Array<ArrayBuffer> {
  return new Uint8Array(readFileSync(new URL(name, FOLDER)));
}

export interface Vector {
  readonly shape: readonly number[];
  readonly data: Float64Array;
}

/** The arrays of a file of vectors, by name. */
export function readVectors(name: string): Map<string, Vector> {
  const bytes = fileBytes(name);
  const length = readHeaderLength(bytes);
  const { entries } = readHeader(bytes.subarray(PREFIX, PREFIX + length));
  const data = bytes.subarray(PREFIX + length);
  return new Map(
    [...entries].map(([key, entry]) => [
      key,
      { shape: entry.shape, data: Float64Array.from(readTensor(data, entry)) },
    ]),
  );
}

export const VECTORS = readVectors("vectors.safetensors");

export const WARPS = ["levels", "carried", "half", "bases", "sliding_bases", "plane"] as const;
export type WarpName = (typeof WARPS)[number];

/** An array of `vectors.safetensors`. */
export function vector(name: string): Float64Array {
  const found = VECTORS.get(name);
  if (!found) {
    throw new Error(`There is no vector ${name}.`);
  }
  return found.data;
}

/** A 4 × 4 matrix of the vectors, column-major. */
export function matrix(name: string): Float64Array {
  return columnMajor(vector(name), 4);
}

/** A warp of the vectors, from its file's bytes, which a test may have spoilt. */
export function warpOf(
  name: WarpName,
  bytes = fileBytes(`${name === "carried" ? "levels" : name}.warp`),
): Warp {
  const loaded = parseWarp(bytes, name);
  if (loaded instanceof AffineBases) {
    const goals = loaded.propNames.map((prop) => [prop, matrix(`${name}.goal.${prop}`)]);
    return loaded.warp(Object.fromEntries(goals));
  }
  if (name === "carried") {
    loaded.place(matrix("carried.pose"));
  }
  return loaded;
}

/** Row-major d × d blocks as Python writes them, column-major as here. */
export function transposed(rows: Float64Array, d: number): Float64Array {
  const out = new Float64Array(rows.length);
  for (let n = 0; n < rows.length; n += d * d) {
    out.set(columnMajor(rows.subarray(n, n + d * d), d), n);
  }
  return out;
}

/** The greatest difference; infinite where one is NaN and the other is not. */
export function difference(a: ArrayLike<number>, b: ArrayLike<number>): number {
  if (a.length !== b.length) {
    return Number.POSITIVE_INFINITY;
  }
  let most = 0;
  for (let n = 0; n < a.length; n++) {
    if (Number.isNaN(a[n]!) !== Number.isNaN(b[n]!)) {
      return Number.POSITIVE_INFINITY;
    }
    most = Math.max(most, Number.isNaN(a[n]!) ? 0 : Math.abs(a[n]! - b[n]!));
  }
  return most;
}
