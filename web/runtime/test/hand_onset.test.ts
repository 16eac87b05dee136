/** The displacement comes and goes at a bounded rate; props that are carried. */

import { describe, expect, test } from "vitest";
import { CarriedWarp, HandRetargeter, type Warp } from "../src/index.js";
import { FRAME, radii, tracked } from "./hands.js";
import { difference, matrix, warpOf } from "./vectors.js";

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
