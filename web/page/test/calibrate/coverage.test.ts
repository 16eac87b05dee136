import { describe, expect, it } from "vitest";
import { HEADSET_HANDS, type TrackingModel } from "../../src/calibrate/contact.js";
import { calibrateGuided, surprise } from "./guided.js";
import { mugSurface } from "./mug.js";
import { seeded, type TrackingFaults, uprightPose } from "./rubbing.js";

const RUNS = 200;
/** 95 % of χ² of four freedoms. */
const JOINT_95 = 9.488;

const FAULTS: TrackingFaults = {
  correlated: 0.003,
  delay: 0.045,
  dropOuts: 0.1,
  outliers: 0.05,
};

const mug = mugSurface();

/** Share of runs whose true pose lies in the stated 95 % region, and how many were refused. */
function coverage(runs: number, tracking: TrackingModel) {
  let covered = 0;
  let refused = 0;
  for (let run = 0; run < runs; run++) {
    const random = seeded(1000 + run);
    const truth = uprightPose(random);
    // The bias is fixed in the room in one half of the runs, in the hand in the other.
    const bias = run % 2 === 0 ? { roomBias: 0.01 } : { handBias: 0.01 };
    const faults = { ...FAULTS, ...bias, biasSeed: run };
    const guided = calibrateGuided(mug, truth, random, faults, tracking);
    if (guided.calibration.doubts.length > 0) refused++;
    else if (surprise(guided, truth) <= JOINT_95) covered++;
  }
  return { share: covered / (runs - refused), refused };
}

describe("10 mm bias, 3 mm lasting noise, 45 ms delay, drop-outs, 5 % outliers", () => {
  it(`the stated 95 % region holds the true pose in 95 % of ${RUNS} runs`, () => {
    const { share, refused } = coverage(RUNS, HEADSET_HANDS);
    console.info(`coverage ${(100 * share).toFixed(1)} %, ${refused} of ${RUNS} refused`);
    expect(share).toBeGreaterThanOrEqual(0.95);
    expect(refused).toBeLessThan(0.1 * RUNS);
  }, 900_000);

  it("which an estimator that believes in no bias does not reach", () => {
    const unbiased = { ...HEADSET_HANDS, roomBias: 1e-4, handBias: 1e-4 };
    expect(coverage(12, unbiased).share || 0).toBeLessThan(0.5);
  }, 300_000);
});
