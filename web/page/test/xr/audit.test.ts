import { Vector3 } from "three";
import { describe, expect, it } from "vitest";
import { StopDetector, TouchAudit } from "../../src/xr/audit.js";
import { gaussian, randomDirection, seeded } from "../calibrate/rubbing.js";

/** Contacts all around a prop that stands `shift` beside where it was calibrated. */
function audited(shift: Vector3, tracking: number, contacts = 24, seed = 5): TouchAudit {
  const random = seeded(seed);
  const audit = new TouchAudit();
  for (let k = 0; k < contacts; k++) {
    const normal = randomDirection(random);
    const noise = gaussian(random, tracking, new Vector3()).x;
    const settled = normal.dot(shift) + noise + 2e-5;
    audit.add({
      time: k,
      hand: 1,
      finger: 1,
      signal: "stopped",
      normal,
      gapAtContact: settled + 0.001,
      gapSettled: settled,
      warp: 2e-5,
    });
  }
  return audit;
}

describe("the touch audit", () => {
  it("finds a prop that has moved by 8 mm, within 3 mm, and asks for calibration", () => {
    const shift = new Vector3(0.005, -0.002, 0.006);
    const audit = audited(shift, 0.003);
    expect(audit.shift.distanceTo(shift)).toBeLessThan(0.003);
    expect(audit.hasDrifted).toBe(true);
  });

  it("asks for calibration when the prop has moved, and hardly ever when it has not", () => {
    const asked = (shift: number, tracking: number, contacts: number) => {
      const runs = Array.from({ length: 200 }, (_, seed) =>
        audited(new Vector3(shift, 0, 0), tracking, contacts, seed),
      );
      return runs.filter((audit) => audit.hasDrifted).length / runs.length;
    };
    for (const contacts of [8, 12, 24]) expect(asked(0, 0.005, contacts)).toBeLessThan(0.03);
    expect(asked(0.012, 0.002, 12)).toBeGreaterThan(0.95);
    expect(asked(0.009, 0.003, 24)).toBeGreaterThan(0.95);
  });

  it("is not misled by a touch that was something else", () => {
    const shift = new Vector3(0.009, 0, 0);
    const audit = audited(shift, 0.001, 12);
    for (const gap of [0.03, -0.025]) {
      const normal = new Vector3(1, 0, 0);
      const rest = { time: 0, hand: 1, finger: 2, signal: "stopped", normal, warp: 0 } as const;
      audit.add({ ...rest, gapAtContact: gap, gapSettled: gap });
    }
    expect(audit.shift.distanceTo(shift)).toBeLessThan(0.003);
  });

  it("blames tracking, not calibration, for gaps that no shift explains", () => {
    const audit = audited(new Vector3(), 0.005);
    expect(audit.hasDrifted).toBe(false);
    expect(audit.typical!.tracking).toBeGreaterThan(3 * Math.abs(audit.typical!.calibration));
  });

  it("shares every gap out without a rest", () => {
    for (const { gap, warp, calibration, tracking, latency } of audited(new Vector3(), 0.004)
      .contacts) {
      expect(warp + calibration + tracking + latency).toBeCloseTo(gap, 12);
    }
  });

  it("tells shares that add up to the whole, also where causes cancel each other", () => {
    for (const shift of [new Vector3(), new Vector3(0.007, 0, 0)]) {
      const { gap, warp, calibration, tracking, latency } = audited(shift, 0.004).typical!;
      expect(warp + calibration + tracking + latency).toBeCloseTo(gap, 12);
      expect(gap).toBeGreaterThan(0.001);
    }
  });

  it("tells a cause that made the gaps smaller with a minus", () => {
    const audit = new TouchAudit();
    const normal = new Vector3(0, 0, 1);
    const rest = { time: 0, hand: 1, finger: 1, signal: "stopped", normal, warp: 0 } as const;
    audit.add({ ...rest, gapAtContact: 0.004, gapSettled: 0.006 });
    expect(audit.line).toMatch(/^Gap 4\.0 mm: .*−2\.0 latency/);
    expect(audit.typical!.latency).toBeCloseTo(-0.002, 12);
  });

  it("says it in one line, the greatest cause first", () => {
    expect(new TouchAudit().line).toBe("No contact yet.");
    expect(audited(new Vector3(0, 0, 0), 0.006).line).toMatch(
      /^Gap [\d.]+ mm: [\d.]+ tracker, .* latency.*, 0\.0\d warp$/,
    );
  });
});

/** A fingertip that comes at 0.3 m/s, stops at `stop` m from the surface, and stays. */
function approach(stop: number, leads = true): ReturnType<StopDetector["update"]>[] {
  const detector = new StopDetector();
  const told = [];
  for (let t = 0; t < 1.5; t += 1 / 72) {
    const height = Math.max(stop, 0.15 - 0.3 * t);
    // What is displayed lags: it is 5 mm off at first and settles.
    const gap = 0.002 + 0.005 * Math.exp(-Math.max(0, t - 0.5) / 0.03);
    told.push(detector.update(t, new Vector3(0, height, 0), height, gap, leads));
  }
  return told.filter((contact) => contact !== null);
}

describe("a contact", () => {
  it("is told once, where a coming finger stops near the surface", () => {
    const contacts = approach(0.001);
    expect(contacts).toHaveLength(1);
    expect(contacts[0]!.time).toBeCloseTo(0.5, 1);
    expect(contacts[0]!.gapSettled).toBeCloseTo(0.002, 3);
    expect(contacts[0]!.gapAtContact).toBeGreaterThan(0.004);
  });

  it("is not told by a finger that stops far off, nor by one that never came", () => {
    expect(approach(0.05)).toHaveLength(0);
    expect(approach(0.012)).toHaveLength(0);
    expect(approach(0.008)).toHaveLength(1);
    expect(approach(0.149)).toHaveLength(0);
  });

  it("is told by the nearest fingertip only: the others stop because it does", () => {
    expect(approach(0.001, true)).toHaveLength(1);
    expect(approach(0.001, false)).toHaveLength(0);
  });
});
