import { describe, expect, it } from "vitest";
import { HEADSET_HANDS } from "../../src/calibrate/contact.js";
import { coverage, RUNS } from "./coverage.js";

// One half of the runs; the other has a file of its own, for another core.
describe("10 mm bias in the hand, 3 mm lasting noise, 45 ms delay, drop-outs, 5 % outliers", () => {
  it(`the stated 95 % region holds the true pose in 95 % of ${RUNS} runs`, () => {
    const { share, refused } = coverage("handBias", RUNS, HEADSET_HANDS);
    console.info(`coverage ${(100 * share).toFixed(1)} %, ${refused} of ${RUNS} refused`);
    expect(share).toBeGreaterThanOrEqual(0.95);
    expect(refused).toBeLessThan(0.1 * RUNS);
  }, 900_000);

  it("which an estimator that believes in no bias does not reach", () => {
    const unbiased = { ...HEADSET_HANDS, roomBias: 1e-4, handBias: 1e-4 };
    expect(coverage("handBias", 6, unbiased).share || 0).toBeLessThan(0.5);
  }, 300_000);
});
