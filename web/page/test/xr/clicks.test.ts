import { beforeEach, describe, expect, it } from "vitest";
import { Clicks, LONGEST_CLICK } from "../../src/xr/clicks.js";
import type { Room } from "../../src/xr/room.js";

const AHEAD = [1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1];

/** A session whose hands point at what a test says, and what is pressed by them. */
class Hands extends EventTarget {
  now = 10;
  pointsAt: string | null = null;
  readonly pressed: string[] = [];
  readonly clicks: Clicks;

  constructor() {
    super();
    const button = (label: string) => ({ label, press: () => void this.pressed.push(label) });
    const room = {
      panel: { pointedAt: () => this.pointsAt && button(this.pointsAt) },
      renderer: { xr: { getReferenceSpace: () => ({}) } },
    };
    this.clicks = new Clicks(this as unknown as XRSession, room as unknown as Room, () => this.now);
  }

  tell(type: "selectstart" | "select", handedness: XRHandedness = "left", tracked = true): void {
    const pose = tracked ? { transform: { matrix: AHEAD } } : null;
    const inputSource = { handedness, targetRaySpace: {} };
    const event = Object.assign(new Event(type), { frame: { getPose: () => pose }, inputSource });
    this.dispatchEvent(event);
  }

  /** A pinch that closes on one thing and opens on another after some seconds. */
  pinch(from: string | null, to: string | null, seconds: number): void {
    this.pointsAt = from;
    this.tell("selectstart");
    this.now += seconds;
    this.pointsAt = to;
    this.tell("select");
  }
}

describe("a pinch", () => {
  let hands: Hands;
  beforeEach(() => {
    hands = new Hands();
  });

  it("presses the button on which it closes and soon opens, and is no stroke", () => {
    hands.pinch("Leave", "Leave", 0.3);
    expect(hands.pressed).toEqual(["Leave"]);
    expect(hands.clicks.was(0)).toBe(true);
    expect(hands.clicks.was(1)).toBe(false); // the other hand did nothing
  });

  it.each([
    ["closes beside the card", null, "Leave", 0.3],
    ["is held as long as a stroke", "Leave", "Leave", LONGEST_CLICK + 0.01],
  ] as const)("that %s presses nothing and is a stroke", (_, from, to, seconds) => {
    hands.pinch(from, to, seconds);
    expect(hands.pressed).toEqual([]);
    expect(hands.clicks.was(0)).toBe(false);
  });

  it.each([null, "Redo"])("that slides from its button to %s presses none", (to) => {
    hands.pinch("Leave", to, 0.3);
    expect(hands.pressed).toEqual([]);
    expect(hands.clicks.was(0)).toBe(true); // but it was meant as a click
  });

  it("is no stroke either where its joints are seen to part later", () => {
    hands.pinch("Redo", "Redo", LONGEST_CLICK);
    hands.now += 0.1;
    expect(hands.pressed).toEqual(["Redo"]);
    expect(hands.clicks.was(0)).toBe(true);
  });

  it("is a stroke again after one that was a click", () => {
    hands.pinch("Redo", "Redo", 0.2);
    hands.now += 0.1;
    hands.pinch(null, "Redo", 0.3);
    expect(hands.clicks.was(0)).toBe(false);
    expect(hands.pressed).toEqual(["Redo"]);
  });

  it("of a hand that is not tracked points at nothing", () => {
    hands.pointsAt = "Leave";
    hands.tell("selectstart", "left", false);
    hands.tell("select");
    expect(hands.pressed).toEqual([]);
  });
});
