/** Hands: the Python library's numbers, onset and release, carried props, refusals. */

import { describe, expect, test } from "vitest";
import {
  CarriedWarp,
  calibratePad,
  type HandOptions,
  HandRetargeter,
  type NearestSurface,
  type Points,
  type Warp,
} from "../src/index.js";
import { columnMajor } from "../src/rigid.js";
import { difference, matrix, vector, warpOf } from "./vectors.js";

/** m and entries of rotations; float32 in and out leave 1e-7. */
const TOLERANCE = 1e-6;
const JOINTS = 25;
const FRAME = 16 * JOINTS;
const RADIUS = 0.05;
const TIMES = [0, 0.05, 0.1, 0.3];

/** The ball that the warps are about. */
const BALL: NearestSurface = {
  nearest(points, nearest, normals) {
    for (let n = 0; n < points.length; n += 3) {
      const length = Math.hypot(points[n]!, points[n + 1]!, points[n + 2]!);
      for (let d = n; d < n + 3; d++) {
        normals[d] = points[d]! / length;
        nearest[d] = RADIUS * normals[d]!;
      }
    }
  },
};

const CASES: readonly [string, HandOptions][] = [
  ["fingertips", { onset: 0 }],
  ["turned_pads", { orientation: "turned", contact: "pad", onset: 0.2 }],
  ["skin", { contact: "skin", surface: BALL, weights: [1, 9, 1, 0.3, 4], onset: 0 }],
  ["rigid", { mode: "rigid", leader: "middle", orientation: "turned", onset: 0 }],
  ["points", { mode: "points", onset: 0 }],
];

/** f(x) = (1 − pull) x: everything shrinks about the ball's middle. */
const PULLING = { dimension: 3, meta: { outerBox: null } };
function pullIn(from: Points, to: Points, pull: number): void {
  for (let n = 0; n < from.length; n++) to[n] = (1 - pull) * from[n]!;
}

/** Frame n of the tracked hands, as WebXR gives them: float32, column-major. */
function tracked(n: number, palmFirst = false): Float32Array {
  const rows = vector("hand.poses").subarray(n * FRAME, (n + 1) * FRAME);
  const out = new Float32Array(FRAME + (palmFirst ? 16 : 0));
  for (let at = 0; at < FRAME; at += 16) {
    for (let i = 0; i < 4; i++) {
      for (let j = 0; j < 4; j++) {
        out[at + (palmFirst ? 16 : 0) + 4 * j + i] = rows[at + 4 * i + j]!;
      }
    }
  }
  if (palmFirst) {
    // a palm somewhere between wrist and middle knuckle
    out.set(out.subarray(16, 32));
    for (let d = 0; d < 3; d++) {
      out[12 + d] = 0.5 * (out[28 + d]! + out[16 * 12 + 12 + d]!);
    }
  }
  return out;
}

const radii = Float32Array.from(vector("hand.radii"));

/** The upper three rows of column-major matrices, row by row, as the vectors keep them. */
function upperRows(poses: Float32Array): Float64Array {
  const out = new Float64Array((poses.length / 16) * 12);
  for (let joint = 0; joint < poses.length / 16; joint++) {
    for (let i = 0; i < 3; i++) {
      for (let j = 0; j < 4; j++) {
        out[12 * joint + 4 * i + j] = poses[16 * joint + 4 * j + i]!;
      }
    }
  }
  return out;
}

/** Greatest differences from Python over the frames of a case: of poses, and of misses. */
function compare(
  name: string,
  options: HandOptions,
  warp: Warp | CarriedWarp,
): readonly [number, number] {
  const retargeter = new HandRetargeter(options);
  let [poses, misses] = [0, 0];
  TIMES.slice(0, vector(`hand.${name}.misses`).length / 5).forEach((time, n) => {
    const shown = new Float32Array(FRAME);
    retargeter.update(warp, tracked(n), radii, time, shown);
    const expected = vector(`hand.${name}.displayed`).subarray(
      n * 12 * JOINTS,
      (n + 1) * 12 * JOINTS,
    );
    poses = Math.max(poses, difference(upperRows(shown), expected));
    const left = vector(`hand.${name}.misses`).subarray(5 * n, 5 * n + 5);
    misses = Math.max(misses, difference(retargeter.tipErrors, left));
  });
  return [poses, misses];
}

/** Displayed by a warp that is carried, and by one that stretches hands to their limits. */
describe("hands equal Python's", () => {
  test("with a prop that is carried, its poses at times of their own", () => {
    const carried = new CarriedWarp(warpOf("levels"), { fixedSurroundings: false });
    vector("hand.carried.times").forEach((time, n) => {
      const rows = vector("hand.carried.poses").subarray(16 * n, 16 * n + 16);
      carried.addPose(columnMajor(rows, 4), time);
    });
    expect(Math.max(...compare("carried", { onset: 0 }, carried))).toBeLessThan(TOLERANCE);
    const still = new CarriedWarp(warpOf("levels"), { fixedSurroundings: false });
    still.addPose([1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1], 0.1);
    expect(Math.max(...compare("carried", { onset: 0 }, still))).toBeGreaterThan(1e-3);
  });

  test("where joints come to their limits", () => {
    const pull = vector("hand.limits.pull")[0]!;
    const inwards = { ...PULLING, displayed: (from: Points, to: Points) => pullIn(from, to, pull) };
    const [poses, misses] = compare("limits", { onset: 0 }, inwards as unknown as Warp);
    expect(Math.max(poses, misses)).toBeLessThan(TOLERANCE);
    // the limits are what keeps fingertips back: elsewhere they miss by hundredths of a millimetre
    expect(Math.max(...vector("hand.limits.misses"))).toBeGreaterThan(5e-4);
  });

  test.each(CASES)("%s", (name, options) => {
    const [poses, misses] = compare(name, options, warpOf("levels"));
    expect(poses).toBeLessThan(TOLERANCE);
    expect(misses).toBeLessThan(TOLERANCE);
  });

  test("and that claim rejects a warp that stands 1 mm off", () => {
    const off = warpOf("levels").at([1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0.001, 0, 0, 1]);
    expect(compare("fingertips", { onset: 0 }, off)[0]).toBeGreaterThan(100 * TOLERANCE);
  });

  test("and another mode", () => {
    expect(compare("fingertips", { mode: "rigid", onset: 0 }, warpOf("levels"))[0]).toBeGreaterThan(
      100 * TOLERANCE,
    );
  });
});

describe("a finger pad", () => {
  const touches = Float64Array.from({ length: vector("pad.touches").length }, (_, n) => {
    const [touch, i, j] = [n >> 4, n & 3, (n >> 2) & 3];
    return vector("pad.touches")[16 * touch + 4 * i + j]!;
  });
  const found = (poses: Float64Array): number[] => {
    const { offset, residual } = calibratePad(poses, BALL);
    return [...offset, residual];
  };

  test("is found as in Python", () => {
    const expected = vector("pad.offset_and_residual");
    expect(difference(found(touches), expected)).toBeLessThan(TOLERANCE);
    // in the order of rows it would be another
    expect(difference(found(vector("pad.touches")), expected)).toBeGreaterThan(1e-3);
  });

  test("needs touches that are known", () => {
    expect(() => calibratePad(new Float64Array(0), BALL)).toThrow(/16 for each are needed/);
    expect(() =>
      calibratePad(
        touches.map(() => Number.NaN),
        BALL,
      ),
    ).toThrow(/leave out lost ones/);
  });
});

test("OpenXR's palm goes with the palm, and changes nothing else", () => {
  for (const [, options] of CASES) {
    const [with26, with25] = [new HandRetargeter(options), new HandRetargeter(options)];
    const long = tracked(1, true);
    const shown = new Float32Array(FRAME + 16);
    const short = new Float32Array(FRAME);
    with26.update(warpOf("levels"), long, null, 0, shown);
    with25.update(warpOf("levels"), tracked(1), null, 0, short);
    expect(difference(shown.subarray(16), short)).toBe(0);
    if (options.mode !== "points") {
      const away = (poses: Float32Array, a: number, b: number): number =>
        Math.hypot(...[12, 13, 14].map((d) => poses[16 * a + d]! - poses[16 * b + d]!));
      expect(away(shown, 0, 1)).toBeCloseTo(away(long, 0, 1), 6);
    }
  }
});

describe("the displacement comes and goes at a bounded rate:", () => {
  const levels = warpOf("levels");
  const shown = new Float32Array(FRAME);
  const frame = (
    retargeter: HandRetargeter,
    warp: Warp | null,
    time: number,
    lost = false,
  ): number => {
    const poses = lost ? new Float32Array(FRAME).fill(Number.NaN) : tracked(1);
    retargeter.update(warp, poses, radii, time, shown);
    return retargeter.weight;
  };

  test("in, and contact may be claimed at its end only", () => {
    const retargeter = new HandRetargeter({ onset: 0.5 });
    expect(frame(retargeter, levels, 10)).toBe(0);
    expect(difference(shown, tracked(1))).toBeLessThan(1e-6);
    expect(frame(retargeter, levels, 10.05)).toBeCloseTo(0.1, 9);
    expect(retargeter.mayClaimContact).toBe(false);
    for (let time = 10.1; time < 10.7; time += 0.05) {
      frame(retargeter, levels, time);
    }
    expect(retargeter.mayClaimContact).toBe(true);
  });

  test("a pause counts as 0.1 s", () => {
    const retargeter = new HandRetargeter({ onset: 0.5 });
    frame(retargeter, levels, 0);
    expect(frame(retargeter, levels, 60)).toBeCloseTo(0.2, 9);
  });

  test("out while tracking is lost, and in again", () => {
    const retargeter = new HandRetargeter({ onset: 0.1 });
    frame(retargeter, levels, 0);
    expect(frame(retargeter, levels, 0.1)).toBe(1);
    expect(frame(retargeter, levels, 0.12, true)).toBeCloseTo(0.8, 9);
    expect(shown.every(Number.isNaN)).toBe(true);
    expect(frame(retargeter, levels, 0.13)).toBeCloseTo(0.9, 9);
  });

  test("another warp waits until the first has gone", () => {
    const retargeter = new HandRetargeter({ onset: 0.1 });
    const other = levels.at([1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1]);
    frame(retargeter, levels, 0);
    frame(retargeter, levels, 0.1);
    expect(frame(retargeter, other, 0.15)).toBeCloseTo(0.5, 9);
    expect(frame(retargeter, other, 0.2)).toBeCloseTo(0, 9);
    expect(frame(retargeter, other, 0.25)).toBeCloseTo(0.5, 9);
    retargeter.active = false;
    expect(frame(retargeter, other, 0.3)).toBeCloseTo(0, 9);
  });
});

test("a warp that is known better takes its place at once", () => {
  const retargeter = new HandRetargeter({ onset: 0.1 });
  const [levels, better] = [warpOf("levels"), warpOf("levels").at(matrix("carried.pose"))];
  const shown = new Float32Array(FRAME);
  retargeter.replace(better); // none is in use: nothing is replaced
  retargeter.update(levels, tracked(1), radii, 0, shown);
  retargeter.update(levels, tracked(1), radii, 0.1, shown);
  retargeter.replace(better);
  retargeter.update(better, tracked(1), radii, 0.15, shown);
  expect(retargeter.weight).toBe(1);
  const other = new HandRetargeter({ onset: 0 });
  const expected = new Float32Array(FRAME);
  other.update(better, tracked(1), radii, 0, expected);
  expect(difference(shown, expected)).toBe(0);
});

describe("a carried prop", () => {
  const pose = (x: number, angle = 0): number[] => {
    const [c, s] = [Math.cos(angle), Math.sin(angle)];
    return [c, s, 0, 0, -s, c, 0, 0, 0, 0, 1, 0, x, 0, 0, 1];
  };
  const u = (warp: Warp, x: number[]): Float64Array => {
    const out = Float64Array.from(x);
    warp.displacement(out, out);
    return out;
  };

  test("takes its warp along, at the hand's own time", () => {
    const carried = new CarriedWarp(warpOf("levels"));
    carried.addPose(pose(0.1, 0), 1);
    carried.addPose(pose(0.3, 0.4), 2);
    carried.addPose(pose(9, 0), 1.5); // late: passed over
    carried.placeAt(1.25);
    const there = warpOf("levels").at(pose(0.15, 0.1));
    expect(
      difference(u(carried.warp, [0.2, 0.03, 0.02]), u(there, [0.2, 0.03, 0.02])),
    ).toBeLessThan(1e-12);
    expect(carried.valid).toBe(false); // 0.25 s from the next pose
    carried.placeAt(2.05);
    expect(carried.valid).toBe(true);
    carried.placeAt(2.2);
    expect(carried.valid).toBe(false);
  });

  test("is not valid before a pose is known, nor far from fixed surroundings", () => {
    const rest = matrix("carried.pose");
    const carried = new CarriedWarp(warpOf("levels"), {
      fixedSurroundings: true,
      T_room_scene: rest,
    });
    carried.placeAt(0);
    expect(carried.valid).toBe(false);
    carried.addPose(rest, 0);
    carried.placeAt(0);
    expect(carried.valid).toBe(true);
    const moved = rest.slice();
    moved[12]! += 0.0019;
    carried.addPose(moved, 0.01);
    carried.placeAt(0.01);
    expect(carried.valid).toBe(true);
    moved[12]! += 0.0002;
    carried.addPose(moved, 0.02);
    carried.placeAt(0.02);
    expect(carried.valid).toBe(false);
  });

  test("that may go anywhere stays valid when moved as far", () => {
    const carried = new CarriedWarp(warpOf("levels"));
    carried.addPose(pose(0.5, 1), 0);
    carried.placeAt(0);
    expect(carried.valid).toBe(true);
  });

  test.each([
    ["", ["ball"], true],
    ['[[prop]]\nname = "fixed"', ["fixed"], true],
    ['[[prop]]\nname = "ball"\n\n[[fixed]]\nname = "table"', ["ball"], false],
    ["", ["ball", "cup"], false],
  ])("may go as far as its own scene says", (scene, propNames, valid) => {
    const levels = warpOf("levels");
    const meta = { ...levels.meta, scene, propNames };
    const carried = new CarriedWarp(Object.create(levels, { meta: { value: meta } }));
    carried.addPose(pose(0.05), 0);
    carried.placeAt(0);
    expect(carried.valid).toBe(valid);
  });

  test("eases the hand out where it is not valid", () => {
    const retargeter = new HandRetargeter({ onset: 0 });
    const carried = new CarriedWarp(warpOf("levels"));
    const shown = new Float32Array(FRAME);
    carried.addPose(pose(0), 0);
    retargeter.update(carried, tracked(1), radii, 0, shown);
    expect(retargeter.weight).toBe(1);
    retargeter.update(carried, tracked(1), radii, 5, shown);
    expect(retargeter.weight).toBe(0);
  });
});

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
