/** A frame allocates nothing: what the collector would stop a headset's frame for. */

import { setFlagsFromString } from "node:v8";
import { runInNewContext } from "node:vm";
import { describe, expect, test } from "vitest";
import { type HandOptions, HandRetargeter, type NearestSurface } from "../src/index.js";
import { BALL, FRAME, radii, tracked } from "./hands.js";
import { warpOf } from "./vectors.js";

setFlagsFromString("--expose-gc");
const collect: () => void = runInNewContext("gc");

const FRAMES = 300;
const ROUNDS = 10;

/** Bytes of the heap that a frame takes; the least of some rounds, once all is compiled. */
function grown(frame: (n: number) => void): number {
  for (let n = 0; n < 3000; n++) frame(n);
  let least = Number.POSITIVE_INFINITY;
  for (let round = 0; round < ROUNDS; round++) {
    collect();
    const before = process.memoryUsage().heapUsed;
    for (let n = 0; n < FRAMES; n++) frame(n);
    least = Math.min(least, (process.memoryUsage().heapUsed - before) / FRAMES);
  }
  return least;
}

/** A frame of two hands, of poses that change. */
function handsOf(options: HandOptions, name: "levels" | "bases" = "levels"): (n: number) => void {
  const warp = warpOf(name);
  const poses = [0, 1, 2, 3].map((n) => tracked(n));
  const shown = new Float32Array(FRAME);
  const hands = [0, 1].map(() => new HandRetargeter({ onset: 0, ...options }));
  return (n) => {
    for (const hand of hands) hand.update(warp, poses[n % 4]!, radii, n / 72, shown);
  };
}

/** As `BALL`, with an array for each point, as one would write it without thinking of frames. */
const WASTEFUL: NearestSurface = {
  nearest(points, nearest, normals) {
    for (let n = 0; n < points.length; n += 3) {
      const one = Float64Array.from(points.subarray(n, n + 3));
      BALL.nearest(one, nearest.subarray(n, n + 3), normals.subarray(n, n + 3));
    }
  },
};

/** Bytes of a frame: an array for each joint of two hands takes more. The engine's own numbers fit. */
const MOST = 4096;

describe("a frame of two hands allocates no arrays", () => {
  const ways: readonly HandOptions[] = [
    {},
    { orientation: "turned" },
    { orientation: "turned", contact: "skin", surface: BALL },
    { mode: "rigid" },
    { mode: "points" },
  ];
  test.each(ways.map((options) => [JSON.stringify(options), options] as const))(
    "%s",
    (_, options) => {
      expect(grown(handsOf(options))).toBeLessThan(MOST);
    },
  );

  test("which a surface that makes some for each fingertip would show", () => {
    const wasteful = { orientation: "turned", contact: "skin", surface: WASTEFUL } as const;
    expect(grown(handsOf(wasteful))).toBeGreaterThan(MOST);
  });
});

describe("the lookup of two hands of 25 joints allocates not one number", () => {
  const points = Float64Array.from({ length: 150 }, (_, n) => 0.03 + 0.002 * Math.sin(7 * n));
  const out = new Float64Array(450);

  test.each(["levels", "bases"] as const)("of %s", (name) => {
    const warp = warpOf(name);
    expect(grown(() => warp.displayed(points, out))).toBeLessThan(16);
    expect(grown(() => warp.jacobian(points, out))).toBeLessThan(16);
  });

  test("which an array for each point would show", () => {
    const warp = warpOf("levels");
    const apart = Array.from({ length: 50 }, () => new Float64Array(3));
    const frame = () => {
      apart.forEach((_, n) => {
        apart[n] = points.slice(3 * n, 3 * n + 3);
        warp.displayed(apart[n]!, out);
      });
    };
    expect(grown(frame)).toBeGreaterThan(16);
  });
});
