/** Instant goals. */

import { describe, expect, test } from "vitest";
import { spectralNorm } from "../src/bases.js";
import { AffineBases, type AffineWarp, GoalError, parseWarp } from "../src/index.js";
import { difference, fileBytes, matrix, vector } from "./vectors.js";

const IDENTITY = [1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1];

function bases(): AffineBases {
  const loaded = parseWarp(fileBytes("bases.warp"));
  if (!(loaded instanceof AffineBases)) {
    throw new Error("bases.warp holds no bases.");
  }
  return loaded;
}

function u(warp: AffineWarp): Float64Array {
  const out = new Float64Array(vector("bases.points").length);
  warp.displacement(vector("bases.points"), out);
  return out;
}

test("a goal can be changed again and again", () => {
  const warp = bases().warp();
  const still = u(warp);
  expect(still.every((value) => value === 0 || Number.isNaN(value))).toBe(true);
  warp.setGoal("ball", IDENTITY.with(12, 0.05));
  expect(difference(u(warp), still)).toBeGreaterThan(0.01);
  warp.setGoal("ball", matrix("bases.goal.ball"));
  expect(difference(u(warp), vector("bases.displacement"))).toBeLessThan(1e-9);
  const elsewhere = warp.at(IDENTITY);
  warp.setGoal("ball", IDENTITY);
  expect(difference(u(warp), still)).toBe(0);
  expect(difference(u(elsewhere), vector("bases.displacement"))).toBeLessThan(1e-9);
});

test("the error bound grows in proportion beyond the stated range", () => {
  const warp = bases().warp();
  expect(warp.withinRange).toBe(true);
  expect(warp.errorBoundMm).toBe(0.05);
  warp.setGoal("ball", IDENTITY.with(12, 0.2)); // range_shift is 0.1 m
  expect(warp.withinRange).toBe(false);
  expect(warp.errorBoundMm).toBeCloseTo(0.1, 9);
});

test("the inverse and the reach follow the goal", () => {
  const warp = bases().warp({ ball: IDENTITY.with(12, 0.02) });
  const x = vector("bases.points").slice(0, 3);
  const before = warp.maxDisplacement;
  warp.inverse(x, x);
  warp.setGoal("ball", IDENTITY.with(12, 0.04));
  expect(warp.maxDisplacement).toBeCloseTo(2 * before, 6);
});

test("the spectral norm is the greatest stretch", () => {
  expect(spectralNorm([0, 0, 0, 0, 0, 0, 0, 0, 0])).toBe(0);
  expect(spectralNorm([2, 0, 0, 0, 2, 0, 0, 0, 2])).toBeCloseTo(2, 12);
  expect(spectralNorm([0, -3, 0, 1, 0, 0, 0, 0, 0.5])).toBeCloseTo(3, 12);
  const B = [0.3, -0.2, 0.5, 0.1, 0.4, -0.7, 0.2, 0.6, 0.1];
  let most = 0;
  for (let n = 0; n < 20000; n++) {
    const [a, b, c] = [Math.sin(n), Math.cos(1.7 * n), Math.sin(2.9 * n + 1)];
    const length = Math.hypot(a, b, c);
    const rows = [0, 3, 6].map((i) => (B[i]! * a + B[i + 1]! * b + B[i + 2]! * c) / length);
    most = Math.max(most, Math.hypot(...rows));
  }
  expect(spectralNorm(B)).toBeGreaterThanOrEqual(most);
  expect(spectralNorm(B)).toBeLessThan(1.001 * most);
});

describe("a goal is refused that is", () => {
  test.each([
    ["of an unknown prop", "bowl", IDENTITY, /no prop 'bowl' in these bases; they have 'ball'/],
    ["not finite", "ball", IDENTITY.with(3, Number.NaN), /is no finite matrix of 16 numbers/],
    ["of another size", "ball", [1, 2, 3], /is no finite matrix of 16 numbers/],
    ["not affine", "ball", IDENTITY.with(3, 0.5), /last row 0\.5,0,0,1; an affine one/],
  ] as const)("%s", (_, prop, goal, message) => {
    const warp = bases().warp();
    expect(() => warp.setGoal(prop, goal)).toThrow(GoalError);
    expect(() => warp.setGoal(prop, goal)).toThrow(message);
  });
});
