import { Quaternion, Vector3 } from "three";
import { describe, expect, it } from "vitest";
import { HEADSET_HANDS } from "../../src/calibrate/contact.js";
import { Pose } from "../../src/calibrate/pose.js";
import { SurfaceFoot } from "../../src/calibrate/surface.js";
import { swollen } from "../../src/calibrate/swelling.js";
import { studentQuantile95 } from "../../src/calibrate/uncertainty.js";
import { mugSurface } from "./mug.js";
import { gaussian, seeded, UP } from "./rubbing.js";

describe("Student's quantile", () => {
  it("is that of the tables", () => {
    const tables = [
      [4, 2.776],
      [10, 2.228],
      [30, 2.042],
      [1e6, 1.96],
    ] as const;
    for (const [freedoms, quantile] of tables) {
      expect(Math.abs(studentQuantile95(freedoms) / quantile - 1)).toBeLessThan(0.01);
    }
  });

  it("is not the normal one for few samples", () => {
    expect(studentQuantile95(4) / 1.96).toBeGreaterThan(1.3);
  });
});

describe("a fingertip on the mug's rim, with 3 mm of noise", () => {
  const mug = mugSurface();
  const rim = new Vector3(0, 0.038, 0.095 + 0.008);
  const noise = 0.003;
  const random = seeded(9);
  const foot = new SurfaceFoot();
  let sum = 0;
  const count = 4000;
  for (let k = 0; k < count; k++) {
    sum += mug.nearest(gaussian(random, noise, rim.clone()), foot).distance;
  }
  const seen = sum / count;
  const contact = { tip: rim, turn: new Quaternion(), radius: 0.008, time: 0 };
  const task = {
    surface: mug,
    contacts: [contact],
    freedom: 4,
    up: UP,
    tracking: HEADSET_HANDS,
  } as const;
  const fit = { pose: new Pose(), tipOffset: new Vector3(), scale: noise, cost: 0 };
  const [believed] = swollen(task, fit);

  it("seems as far away, on average, as is then believed", () => {
    expect(Math.abs(seen - believed!.radius)).toBeLessThan(0.05e-3);
  });

  it("which is farther than it is", () => {
    expect(seen - contact.radius).toBeGreaterThan(0.15e-3);
  });
});
