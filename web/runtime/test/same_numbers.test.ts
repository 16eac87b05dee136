/** The runtime gives the Python library's numbers. */

import { describe, expect, test } from "vitest";
import type { Warp } from "../src/index.js";
import { PREFIX, readHeader, readHeaderLength } from "../src/tensors.js";
import {
  difference,
  fileBytes,
  transposed,
  vector,
  WARPS,
  type WarpName,
  warpOf,
} from "./vectors.js";

/** m, as promised. Measured: below 1e-15 in u, 1e-10 in the inverse of summed bases. */
const TOLERANCE = 1e-6;

interface Differences {
  readonly displacement: number;
  readonly displayed: number;
  readonly jacobian: number;
  readonly inverse: number;
}

function compare(name: WarpName, warp: Warp): Differences {
  const points = vector(`${name}.points`);
  const d = warp.dimension;
  const u = new Float64Array(points.length);
  const f = new Float64Array(points.length);
  const back = new Float64Array(points.length);
  const slopes = new Float64Array(points.length * d);
  warp.displacement(points, u);
  warp.displayed(points, f);
  warp.jacobian(points, slopes);
  warp.inverse(points, back);
  const expected = vector(`${name}.displacement`);
  return {
    displacement: difference(u, expected),
    displayed: difference(
      f,
      expected.map((value, n) => points[n]! + value),
    ),
    jacobian: difference(slopes, transposed(vector(`${name}.jacobian`), d)),
    inverse: difference(back, vector(`${name}.inverse`)),
  };
}

describe.each(WARPS)("%s", (name) => {
  test("equals Python", () => {
    const found = compare(name, warpOf(name));
    expect(found.displacement).toBeLessThan(TOLERANCE);
    expect(found.displayed).toBeLessThan(TOLERANCE);
    expect(found.jacobian).toBeLessThan(1e-6);
    expect(found.inverse).toBeLessThan(TOLERANCE);
  });

  test("writes over its own input", () => {
    const warp = warpOf(name);
    const points = vector(`${name}.points`);
    const out = new Float64Array(points.length);
    warp.displayed(points, out);
    const same = points.slice();
    warp.displayed(same, same);
    expect(difference(same, out)).toBe(0);
  });
});

/** A file with its values' first two axes swapped, or shifted by a node along z. */
function spoilt(
  name: "levels" | "half" | "bases",
  how: "axes" | "half a cell",
): Uint8Array<ArrayBuffer> {
  const bytes = fileBytes(`${name}.warp`);
  const start = PREFIX + readHeaderLength(bytes);
  const header = readHeader(bytes.subarray(PREFIX, start));
  if (how === "half a cell") {
    const entry = header.entries.get("T_scene_table")!;
    const T = new DataView(bytes.buffer, start + entry.begin);
    const spacing = new DataView(bytes.buffer, start + header.entries.get("spacing")!.begin);
    // along the table's x, whose direction is the first column
    for (let i = 0; i < 3; i++) {
      const along = T.getFloat64(32 * i, true) * 0.5 * spacing.getFloat64(0, true);
      T.setFloat64(32 * i + 24, T.getFloat64(32 * i + 24, true) + along, true);
    }
    return bytes;
  }
  const { begin, shape, dtype } = header.entries.get("values")!;
  const size = (dtype === "F16" ? 2 : 4) * shape[4]!;
  const node = (row: number, i: number, j: number, k: number): number =>
    start + begin + (((row * 9 + i) * 9 + j) * 9 + k) * size;
  const original = bytes.slice();
  for (let row = 0; row < shape[0]!; row++) {
    for (let n = 0; n < 729; n++) {
      const [i, j, k] = [Math.floor(n / 81), Math.floor(n / 9) % 9, n % 9];
      bytes.set(
        original.subarray(node(row, i, j, k), node(row, i, j, k) + size),
        node(row, j, i, k),
      );
    }
  }
  return bytes;
}

describe.each(["levels", "half", "bases"] as const)("the claim on %s rejects", (name) => {
  test.each(["axes", "half a cell"] as const)("%s", (how) => {
    const found = compare(name, warpOf(name, spoilt(name, how)));
    expect(found.displacement).toBeGreaterThan(100 * TOLERANCE);
  });
});

test("the inverse leads back wherever it is found", () => {
  for (const name of WARPS) {
    const warp = warpOf(name);
    const points = vector(`${name}.points`);
    const real = new Float64Array(points.length);
    const found = warp.inverse(points, real);
    const shown = new Float64Array(points.length);
    warp.displayed(real, shown);
    const there = points.map((value, n) => (Number.isNaN(real[n]!) ? Number.NaN : value));
    expect(difference(shown, there), name).toBeLessThan(1e-9);
    const rows = points.length / warp.dimension;
    expect(found, name).toBeGreaterThan(0.8 * rows);
  }
});
