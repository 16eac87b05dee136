import { describe, expect, it } from "vitest";
import type { Contact } from "../../src/calibrate/contact.js";
import { findProp } from "../../src/calibrate/find.js";
import {
  packContacts,
  packFinding,
  unpackContacts,
  unpackFinding,
} from "../../src/calibrate/packing.js";
import { placesToTouch } from "../../src/calibrate/places.js";
import type { Pose } from "../../src/calibrate/pose.js";
import { SurfaceFoot } from "../../src/calibrate/surface.js";
import { type Guided, poseError, surprise } from "./guided.js";
import { mugSurface } from "./mug.js";
import { dwell, seeded, type TrackingFaults, uprightPose } from "./rubbing.js";

const mug = mugSurface();
const goal = { surface: mug, virtual: mug.positions };
/** How far beside a place people touch, m, one sigma. */
const ASIDE = 0.004;

/** A person who touches one shown place after another, until nothing is in doubt. */
function touchPlaces(truth: Pose, seed: number, aside: number, faults: TrackingFaults) {
  const random = seeded(seed);
  const places = placesToTouch(mug, 12);
  const contacts: Contact[] = [];
  let finding = findProp(goal, contacts, 4);
  for (let k = 0; k < 14 && !(finding.calibration?.doubts.length === 0); k++) {
    const place = finding.suggestion ?? places[k]!;
    const how = { ...faults, biasSeed: seed, begin: 3 * k };
    contacts.push(dwell(mug, truth, random, place, aside, how));
    finding = findProp(goal, contacts, 4);
  }
  return { contacts, finding };
}

describe("places to touch", () => {
  const places = placesToTouch(mug, 12);

  it("are far from one another, begin at the handle, and can be reached", () => {
    expect(places).toHaveLength(12);
    expect(places[0]!.point.x).toBeGreaterThan(0.06);
    const foot = new SurfaceFoot();
    for (const [k, { point, normal }] of places.entries()) {
      expect(point.z).toBeGreaterThan(0.01);
      const tip = point.clone().addScaledVector(normal, 0.008);
      expect(mug.nearest(tip, foot).distance).toBeGreaterThan(0.007);
      for (const other of places.slice(0, k)) {
        const turned = normal.dot(other.normal) < 0.7;
        expect(turned || point.distanceTo(other.point) > 0.015).toBe(true);
      }
    }
  });

  it("find the prop, within 1 mm with 1 mm of noise", () => {
    for (let run = 0; run < 6; run++) {
      const truth = uprightPose(seeded(300 + run));
      const { finding, contacts } = touchPlaces(truth, 300 + run, 0, { white: 0.001 });
      const found = { task: { surface: mug }, calibration: finding.calibration! } as Guided;
      const { shift, turn } = poseError(found, truth);
      expect(contacts.length).toBeLessThan(12);
      expect(shift.length()).toBeLessThan(0.001);
      expect(Math.abs(turn)).toBeLessThan((1 * Math.PI) / 180);
    }
  });

  it("tell what they do not know: the stated region holds the true pose", () => {
    const faults = { correlated: 0.003, delay: 0.045, dropOuts: 0.1, outliers: 0.05 };
    let [accepted, covered] = [0, 0];
    for (let run = 0; run < 30; run++) {
      const bias = run % 2 ? { handBias: 0.01 } : { roomBias: 0.01 };
      const truth = uprightPose(seeded(600 + run));
      const { finding } = touchPlaces(truth, 600 + run, ASIDE, { ...faults, ...bias });
      const { calibration } = finding;
      if (calibration === null || calibration.doubts.length > 0) continue;
      accepted++;
      const found = { task: { surface: mug }, calibration } as Guided;
      if (surprise(found, truth) <= 9.488) covered++;
    }
    console.info(`by places: ${covered} of ${accepted} accepted runs covered, of 30`);
    expect(accepted).toBeGreaterThan(22);
    expect(covered / accepted).toBeGreaterThanOrEqual(0.95);
  }, 120_000);
});

describe("what goes to the thread that registers, and back,", () => {
  it("is as it was", () => {
    const { contacts, finding } = touchPlaces(uprightPose(seeded(1)), 1, 0, { white: 0.001 });
    const there = unpackContacts(structuredClone(packContacts(contacts)));
    expect(there).toHaveLength(contacts.length);
    there.forEach((contact, k) => {
      const sent = contacts[k]!;
      expect(contact.tip.equals(sent.tip) && contact.turn.equals(sent.turn)).toBe(true);
      expect(contact.named!.point.equals(sent.named!.point)).toBe(true);
      expect([contact.radius, contact.time]).toEqual([sent.radius, sent.time]);
    });
    const back = unpackFinding(structuredClone(packFinding(finding)));
    const [sent, got] = [finding.calibration!, back.calibration!];
    expect(got.pose.turn.equals(sent.pose.turn)).toBe(true);
    expect(got.covariance.inRoom.to2DArray()).toEqual(sent.covariance.inRoom.to2DArray());
    expect(got.rivals).toHaveLength(sent.rivals.length);
    expect([got.turn95, got.scale, got.doubts]).toEqual([sent.turn95, sent.scale, sent.doubts]);
    expect(back.suggestion!.point.equals(finding.suggestion!.point)).toBe(true);
    expect(back.harmless).toBe(finding.harmless);
    expect(unpackFinding(packFinding(findProp(goal, [], 4))).calibration).toBeNull();
  });
});
