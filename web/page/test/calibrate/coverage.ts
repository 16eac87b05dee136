import type { TrackingModel } from "../../src/calibrate/contact.js";
import { calibrateGuided, surprise } from "./guided.js";
import { mugSurface } from "./mug.js";
import { seeded, type TrackingFaults, uprightPose } from "./rubbing.js";

export const RUNS = 100;
/** 95 % of χ² of four freedoms. */
const JOINT_95 = 9.488;

const FAULTS: TrackingFaults = {
  correlated: 0.003,
  delay: 0.045,
  dropOuts: 0.1,
  outliers: 0.05,
};

const mug = mugSurface();

/** Where the 10 mm of bias are fixed. */
export type Bias = "roomBias" | "handBias";

/** Share of runs whose true pose lies in the stated 95 % region, and how many were refused. */
export function coverage(fixedIn: Bias, runs: number, tracking: TrackingModel) {
  let covered = 0;
  let refused = 0;
  for (let k = 0; k < runs; k++) {
    const run = 2 * k + Number(fixedIn === "handBias"); // no run is in both halves
    const random = seeded(1000 + run);
    const truth = uprightPose(random);
    const faults = { ...FAULTS, [fixedIn]: 0.01, biasSeed: run };
    const guided = calibrateGuided(mug, truth, random, faults, tracking);
    if (guided.calibration.doubts.length > 0) refused++;
    else if (surprise(guided, truth) <= JOINT_95) covered++;
  }
  return { share: covered / (runs - refused), refused };
}
