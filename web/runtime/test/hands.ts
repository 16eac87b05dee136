/** What the tests of hands share: the tracked hands, a ball, comparison with Python's numbers. */

import {
  type CarriedWarp,
  type HandOptions,
  HandRetargeter,
  type NearestSurface,
  type Points,
  type Warp,
} from "../src/index.js";
import { difference, vector } from "./vectors.js";

/** m and entries of rotations; float32 in and out leave 1e-7. */
export const TOLERANCE = 1e-6;
export const JOINTS = 25;
export const FRAME = 16 * JOINTS;
export const RADIUS = 0.05;
export const TIMES = [0, 0.05, 0.1, 0.3];

/** The ball that the warps are about. */
export const BALL: NearestSurface = {
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

export const CASES: readonly [string, HandOptions][] = [
  ["fingertips", { onset: 0 }],
  ["turned_pads", { orientation: "turned", contact: "pad", onset: 0.2 }],
  ["skin", { contact: "skin", surface: BALL, weights: [1, 9, 1, 0.3, 4], onset: 0 }],
  ["rigid", { mode: "rigid", leader: "middle", orientation: "turned", onset: 0 }],
  ["points", { mode: "points", onset: 0 }],
];

/** f(x) = (1 − pull) x: everything shrinks about the ball's middle. */
export const PULLING = { dimension: 3, meta: { outerBox: null } };
export function pullIn(from: Points, to: Points, pull: number): void {
  for (let n = 0; n < from.length; n++) to[n] = (1 - pull) * from[n]!;
}

/** Frame n of the tracked hands, as WebXR gives them: float32, column-major. */
export function tracked(n: number, palmFirst = false): Float32Array {
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

export const radii = Float32Array.from(vector("hand.radii"));

/** The upper three rows of column-major matrices, row by row, as the vectors keep them. */
export function upperRows(poses: Float32Array): Float64Array {
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
export function compare(
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
