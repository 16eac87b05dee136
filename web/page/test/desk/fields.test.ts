import type { Warp } from "touchwarp";
import { describe, expect, it } from "vitest";
import { evaluate, greatestStretch, scaleOf, shareOf } from "../../src/desk/fields.js";
import { number } from "../../src/desk/legend.js";
import { weightAt } from "../../src/desk/panel.js";

/** Column-major R·diag(s)·Q of two turns, whose singular values are s whatever the turns. */
function stretched(s: readonly [number, number, number]): Float64Array {
  const turn = (a: number, b: number): number[][] => [
    [Math.cos(a) * Math.cos(b), -Math.sin(a), Math.cos(a) * Math.sin(b)],
    [Math.sin(a) * Math.cos(b), Math.cos(a), Math.sin(a) * Math.sin(b)],
    [-Math.sin(b), 0, Math.cos(b)],
  ];
  const [R, Q] = [turn(0.7, -0.4), turn(-1.9, 1.1)];
  const out = new Float64Array(9);
  for (let i = 0; i < 3; i++)
    for (let j = 0; j < 3; j++)
      for (let k = 0; k < 3; k++) out[3 * j + i]! += R[i]![k]! * s[k]! * Q[k]![j]!;
  return out;
}

describe("greatestStretch", () => {
  it.each([[[3, 2, 1]], [[0.5, 0.5, 0.5]], [[1, 1, 4]], [[0, 0, 2]], [[1.2, 1.2, 0.6]]] as const)(
    "is the greatest singular value of %s",
    (s) => {
      expect(greatestStretch(stretched(s), 0)).toBeCloseTo(Math.max(...s), 7);
    },
  );

  it("is not the greatest entry, nor the norm (the twin)", () => {
    const m = stretched([3, 2, 1]);
    expect(Math.max(...m.map(Math.abs))).toBeLessThan(2.99);
    expect(Math.hypot(...m)).toBeGreaterThan(3.5);
  });
});

describe("evaluate", () => {
  // displayed at 2 x + (0, 0, 1)
  const warp = {
    displayed: (points: ArrayLike<number>, out: Float64Array) => {
      for (let i = 0; i < points.length; i++) out[i] = 2 * points[i]! + (i % 3 === 2 ? 1 : 0);
    },
    jacobian: (_: unknown, out: Float64Array) => {
      out.fill(0);
      for (let i = 0; i < out.length; i += 9) out[i] = out[i + 4] = out[i + 8] = 2;
    },
  } as unknown as Warp;
  const surface = {
    prop: Float32Array.of(0.5, 0, 0, 0, 0.25, 0),
    virtual: Float32Array.of(1, 0, 1, 0, 0.5, 1.5),
    faces: Uint32Array.of(),
  };
  const normals = new Float32Array(6);

  it("gives the mismatch in mm", () => {
    const values = evaluate("mismatch", surface, normals, undefined, warp);
    expect(values[0]).toBeCloseTo(1e3 * Math.hypot(0.5, 1), 2);
  });

  it("gives the contact error against the virtual surface, or the affine goal", () => {
    const [none, half] = evaluate("error", surface, normals, undefined, warp);
    expect([none, half]).toEqual([0, 500]);
    const goal = Float64Array.of(2, 0, 0, 0, 0, 2, 0, 0, 0, 0, 2, 0, 0, 0, 1, 1);
    expect([...evaluate("error", surface, normals, goal, warp)]).toEqual([0, 0]);
  });

  it("gives the gain", () => {
    expect([...evaluate("gain", surface, normals, undefined, warp)]).toEqual([2, 2]);
  });
});

describe("scales", () => {
  const mark = (value: number) => ({ scale: "mismatch", value, label: "", source: "" }) as const;
  const mismatch = (most: number, ...marks: number[]) =>
    scaleOf("mismatch", [Float32Array.of(0, most)], 0.1, marks.map(mark));

  it("of the gain have 1 in their middle, and equal ratios equally far apart", () => {
    const scale = scaleOf("gain", [Float32Array.of(0.4, 1.8)], 0.1, []);
    expect([0.5, 1, 2].map((gain) => shareOf({ low: 0.25, high: 4, ratio: true }, gain))).toEqual([
      0.25, 0.5, 0.75,
    ]);
    expect(shareOf(scale, 1)).toBeCloseTo(0.5, 6);
    expect(scale.high).toBeCloseTo(1.8, 6);
  });

  it("of the contact error show the tolerance", () => {
    expect(scaleOf("error", [Float32Array.of(0.01)], 0.1, []).high).toBeGreaterThan(0.1);
  });

  it("of the mismatch reach as far as what people notice, where that is near", () => {
    expect(mismatch(42.6).high).toBeCloseTo(42.6, 4);
    expect(mismatch(42.6, 52, 200).high).toBeGreaterThan(52);
    expect(mismatch(42.6, 52, 200).high).toBeLessThan(60);
    expect(mismatch(5, 52, 200).high).toBe(5);
  });
});

describe("the λ slider", () => {
  it("goes from 0 over 0.1 to 1000", () => {
    expect([0, 0.25, 0.5, 1].map(weightAt)).toEqual([0, 1, 10, 1000]);
  });
});

describe("number", () => {
  it.each([
    [0, "0"],
    [52, "52"],
    [200, "200"],
    [0.88, "0.88"],
    [0.0171, "0.0171"],
    [-12.04, "-12"],
    [120, "120"],
  ])("writes %d as %s", (value, text) => {
    expect(number(value)).toBe(text);
  });
});
