/** How long a frame takes: the lookup of two hands of 25 joints, and two whole hands; in Node.
 *
 * npm run benchmark -w runtime
 */

import { readFileSync } from "node:fs";
import { AffineBases, HandRetargeter, parseWarp } from "../dist/index.js";

const FOLDER = new URL("../../../tests/vectors/", import.meta.url);

/** The least time of one call, in µs, of rounds short enough not to be interrupted; the first ones
 * compile. */
export function best(call, times = 50, rounds = 1000) {
  let least = Number.POSITIVE_INFINITY;
  for (let round = 0; round < rounds; round++) {
    const start = performance.now();
    for (let n = 0; n < times; n++) {
      call();
    }
    least = Math.min(least, (1e3 * (performance.now() - start)) / times);
  }
  return least;
}

export function show(name, figure, limit) {
  const told = limit === undefined ? "" : `  (at most ${limit})`;
  console.log(`${name.padEnd(48)} ${figure.toFixed(2).padStart(8)} µs${told}`);
}

export function readWarp(name) {
  return parseWarp(readFileSync(new URL(name, FOLDER)), name);
}

const JOINTS = 50;
// inside the finest brick of the table, where a lookup has the farthest way
const points = Float64Array.from({ length: 3 * JOINTS }, (_, n) => 0.03 + 0.002 * Math.sin(7 * n));
const out = new Float64Array(3 * JOINTS);
const slopes = new Float64Array(9 * JOINTS);

const levels = readWarp("levels.warp");
show(
  "displayed, two hands of 25 joints",
  best(() => levels.displayed(points, out)),
  20,
);
show(
  "jacobian, two hands of 25 joints",
  best(() => levels.jacobian(points, slopes)),
);
const bases = readWarp("bases.warp");
if (bases instanceof AffineBases) {
  const goal = [1.1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1];
  const warp = bases.warp({ ball: goal });
  // the middle of its table, in the room
  const middle = [0.29, 0.09, 0.48];
  const inside = points.map((x, n) => x - 0.03 + middle[n % 3]);
  show(
    "displayed by bases, two hands of 25 joints",
    best(() => warp.displayed(inside, out)),
    20,
  );
  show(
    "a new goal",
    best(() => warp.setGoal("ball", goal)),
  );
}

/** A tracked hand of the vectors, column-major. */
function trackedHand() {
  const bytes = readFileSync(new URL("vectors.safetensors", FOLDER));
  const length = Number(bytes.readBigUInt64LE(0));
  const header = JSON.parse(bytes.subarray(8, 8 + length).toString());
  const begin = 8 + length + header["hand.poses"].data_offsets[0] + 4 * 400;
  return Float32Array.from({ length: 400 }, (_, n) => {
    const [joint, i, j] = [n >> 4, n & 3, (n >> 2) & 3];
    return bytes.readFloatLE(begin + 4 * (16 * joint + 4 * i + j));
  });
}

const hand = trackedHand();
const displayed = new Float32Array(hand.length);
const ball = {
  nearest(points, nearest, normals) {
    for (let n = 0; n < points.length; n += 3) {
      const scale = 1 / Math.hypot(points[n], points[n + 1], points[n + 2]);
      for (let d = n; d < n + 3; d++) {
        normals[d] = points[d] * scale;
        nearest[d] = 0.05 * normals[d];
      }
    }
  },
};
const ways = {
  points: { mode: "points" },
  rigid: { mode: "rigid" },
  fingertips: {},
  "fingertips, turned": { orientation: "turned" },
  "fingertips, turned, skin": { orientation: "turned", contact: "skin", surface: ball },
};
for (const [name, options] of Object.entries(ways)) {
  const hands = [0, 1].map(() => new HandRetargeter({ ...options, onset: 0 }));
  const frame = () => {
    for (const retargeter of hands) {
      retargeter.update(levels, hand, null, 0, displayed);
    }
  };
  show(`two hands: ${name}`, best(frame, 10), 200);
}
