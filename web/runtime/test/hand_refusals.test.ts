/** What hands refuse, in words. */

import { describe, expect, test } from "vitest";
import { CarriedWarp, HandRetargeter } from "../src/index.js";
import { FRAME, tracked } from "./hands.js";
import { warpOf } from "./vectors.js";

describe("what cannot be used is refused:", () => {
  const refusals: readonly [string, () => unknown, RegExp][] = [
    [
      "a mode",
      () => new HandRetargeter({ mode: "stretch" as "rigid" }),
      /mode is 'stretch'; one of fingertips, rigid, points is needed/,
    ],
    ["a leader", () => new HandRetargeter({ leader: "toe" as "thumb" }), /leader is 'toe'/],
    [
      "skin without a surface",
      () => new HandRetargeter({ contact: "skin" }),
      /give `surface`, or take 'pad'/,
    ],
    [
      "a radius",
      () => new HandRetargeter({ tipRadius: 8 }),
      /tip radius is 8 m; 0 to 0\.05 is needed/,
    ],
    [
      "weights",
      () => new HandRetargeter({ weights: [1, 1, 1, 1, 0] }),
      /five numbers > 0 are needed/,
    ],
    [
      "offsets",
      () => new HandRetargeter({ padOffsets: [0, 0, 0] }),
      /have 3 numbers; 5 × 3 are needed/,
    ],
    [
      "an onset",
      () => new HandRetargeter({ onset: -1 }),
      /takes -1 s; a finite time ≥ 0 is needed/,
    ],
    [
      "poses of other joints",
      () =>
        new HandRetargeter().update(
          null,
          new Float32Array(21 * 16),
          null,
          0,
          new Float32Array(21 * 16),
        ),
      /16 for each of 25 or 26 joints are needed/,
    ],
    [
      "a plane warp",
      () =>
        new HandRetargeter().update(warpOf("plane"), tracked(0), null, 0, new Float32Array(FRAME)),
      /warp is plane; one in space is needed/,
    ],
    ["a plane warp to carry", () => new CarriedWarp(warpOf("plane")), /one in space is needed/],
    [
      "an allowance",
      () => new CarriedWarp(warpOf("levels"), { allowedShift: -1 }),
      /numbers ≥ 0 are needed/,
    ],
    [
      "a pose that scales",
      () => warpOf("levels").place([2, 0, 0, 0, 0, 2, 0, 0, 0, 0, 2, 0, 0, 0, 0, 1]),
      /not rigid: .* change the goal instead/,
    ],
    [
      "a pose stored by rows",
      () => warpOf("levels").place([1, 0, 0, 0.1, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1]),
      /matrices are column-major here; pass the transpose/,
    ],
    [
      "a pose of NaN",
      () => warpOf("levels").place(new Float32Array(16).fill(Number.NaN)),
      /NaN or infinite entries/,
    ],
    [
      "a pose of 9 numbers",
      () => warpOf("levels").place([1, 0, 0, 0, 1, 0, 0, 0, 1]),
      /has 9 numbers; 16 are needed/,
    ],
    [
      "broken rows",
      () => warpOf("levels").displayed(new Float64Array(7), new Float64Array(7)),
      /7 numbers; rows of 3 are needed/,
    ],
    [
      "too little room",
      () => warpOf("levels").jacobian(new Float64Array(3), new Float64Array(3)),
      /has 3 numbers; 9 are needed/,
    ],
  ];
  test.each(refusals)("%s", (_, attempt, message) => {
    expect(attempt).toThrow(RangeError);
    expect(attempt).toThrow(message);
  });
});
