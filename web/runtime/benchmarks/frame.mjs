/** How long the lookup takes for two hands of 25 joints; in Node, on the committed small warps.
 *
 * npm run benchmark -w runtime
 */

import { readFileSync } from "node:fs";
import { AffineBases, parseWarp } from "../dist/index.js";

const FOLDER = new URL("../../../tests/vectors/", import.meta.url);

/** The least time of one call, in µs, of some rounds; the first ones compile. */
export function best(call, times = 2000, rounds = 30) {
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
