import { describe, expect, it } from "vitest";
import {
  advance,
  begin,
  fade,
  isDisplaced,
  type Session,
  type SessionEvent,
  worldGoal,
} from "../../src/xr/session.js";

const go = (session: Session, ...events: SessionEvent[]) => events.reduce(advance, session);
const READY = { kind: "ready" } as const;
const CALIBRATED = { kind: "calibrated" } as const;
const VERIFIED = { kind: "verified" } as const;
const immersed = go(begin(1), READY, CALIBRATED, VERIFIED);

describe("a session", () => {
  it("displaces hands only after it was calibrated and verified", () => {
    const passed = [READY, CALIBRATED].map((_, k, all) => go(begin(1), ...all.slice(0, k + 1)));
    for (const session of [begin(1), ...passed]) expect(isDisplaced(session)).toBe(false);
    expect(isDisplaced(immersed)).toBe(true);
  });

  it("cannot skip a step, whatever comes in whatever order", () => {
    const events: SessionEvent[] = [
      { kind: "resolved" },
      VERIFIED,
      CALIBRATED,
      READY,
      VERIFIED,
      { kind: "origin moved" },
      { kind: "redo" },
      { kind: "missed", reason: "" },
    ];
    let session = begin(1);
    let calibrated = false;
    for (let k = 0; k < 400; k++) {
      const event = events[(k * 7 + (k >> 3)) % events.length]!;
      calibrated ||= event.kind === "calibrated" && session.phase === "calibrate";
      session = advance(session, event);
      if (isDisplaced(session)) expect(calibrated).toBe(true);
    }
  });

  it("calibrates every prop, solves, and verifies every prop", () => {
    let session = go(begin(2), READY);
    expect([session.phase, session.prop]).toEqual(["calibrate", 0]);
    session = go(session, CALIBRATED);
    expect([session.phase, session.prop]).toEqual(["calibrate", 1]);
    session = go(session, CALIBRATED);
    expect(session.phase).toBe("resolve");
    session = go(session, { kind: "resolved" }, VERIFIED);
    expect([session.phase, session.prop]).toEqual(["verify", 1]);
    expect(isDisplaced(go(session, VERIFIED))).toBe(true);
  });

  it.each(["asked", "hidden", "outside", "unready"] as const)(
    "shows nothing virtual while paused: %s",
    (pause) => {
      const paused = go(immersed, { kind: "pause", pause });
      expect(isDisplaced(paused)).toBe(false);
      expect(worldGoal(paused)).toBe(0);
      expect(isDisplaced(go(paused, { kind: "resume", pause }))).toBe(true);
    },
  );

  it("goes on only when no pause is left", () => {
    const both = go(
      immersed,
      { kind: "pause", pause: "asked" },
      { kind: "pause", pause: "hidden" },
    );
    expect(isDisplaced(go(both, { kind: "resume", pause: "hidden" }))).toBe(false);
  });

  it("asks for verification when the origin has moved, and for calibration when that misses", () => {
    const moved = go(immersed, { kind: "origin moved" });
    expect([moved.phase, moved.doubted, isDisplaced(moved)]).toEqual(["verify", true, false]);
    expect(go(moved, VERIFIED).phase).toBe("immersed");
    const missed = go(moved, { kind: "missed", reason: "20 mm off" });
    expect([missed.phase, missed.trouble]).toEqual(["calibrate", "20 mm off"]);
  });

  it("begins with the first prop when the second one's touches miss", () => {
    const second = go(begin(2), READY, CALIBRATED, CALIBRATED, { kind: "resolved" }, VERIFIED);
    const missed = go(second, { kind: "missed", reason: "" });
    expect([second.prop, missed.phase, missed.prop]).toEqual([1, "calibrate", 0]);
  });

  it("goes back to calibration when props cannot be solved, and ends for good", () => {
    const solving = go(begin(2), READY, CALIBRATED, CALIBRATED);
    const failed = go(solving, { kind: "unresolved", reason: "they overlap" });
    expect([failed.phase, failed.trouble]).toEqual(["calibrate", "they overlap"]);
    expect(go(immersed, { kind: "end" }, { kind: "redo" }).phase).toBe("ended");
  });
});

describe("fading", () => {
  it("moves by no more than the share of the time that passed, and never beyond", () => {
    expect(fade(0, 1, 0.1, 1)).toBeCloseTo(0.1);
    expect(fade(0.95, 1, 0.1, 1)).toBe(1);
    expect(fade(1, 0, 0.05, 0.2)).toBeCloseTo(0.75);
  });
});
