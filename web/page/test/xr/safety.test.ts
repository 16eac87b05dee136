import { Vector3 } from "three";
import { describe, expect, it } from "vitest";
import { HandsUp, isBeyondBounds, isOutside, Pinch } from "../../src/xr/safety.js";

const NONE = Number.NaN;

describe("hands up", () => {
  const hold = (wrists: [number, number], seconds: number) => {
    const gesture = new HandsUp();
    let fired = 0;
    for (let t = 0; t < seconds; t += 1 / 72) fired += Number(gesture.update(1.2, wrists, t));
    return fired;
  };

  it("is told once when both wrists stay above the eyes for half a second", () => {
    expect(hold([1.3, 1.4], 2)).toBe(1);
    expect(hold([1.3, 1.4], 0.4)).toBe(0);
  });

  it("takes the only tracked hand, if it stays for a second", () => {
    expect(hold([NONE, 1.4], 0.8)).toBe(0);
    expect(hold([NONE, 1.4], 1.2)).toBe(1);
  });

  it("is not told by one hand that reaches up while the other rests, nor by no hands", () => {
    expect(hold([0.8, 1.4], 3)).toBe(0);
    expect(hold([NONE, NONE], 3)).toBe(0);
  });
});

describe("the play volume", () => {
  const volume = { centre: new Vector3(0, 1.2, 0), radius: 0.6 };
  it("is left at its radius and entered again only 10 cm inside", () => {
    expect(isOutside(new Vector3(0.55, 1.2, 0), volume, false)).toBe(false);
    expect(isOutside(new Vector3(0.65, 1.2, 0), volume, false)).toBe(true);
    expect(isOutside(new Vector3(0.55, 1.2, 0), volume, true)).toBe(true);
    expect(isOutside(new Vector3(0.45, 1.2, 0), volume, true)).toBe(false);
  });
});

describe("bounds", () => {
  const el = [
    [0, 0],
    [2, 0],
    [2, 1],
    [1, 1],
    [1, 2],
    [0, 2],
  ].map(([x, z]) => ({ x: x!, z: z! }));
  it("hold what is inside an outline that is not convex", () => {
    expect(isBeyondBounds({ x: 0.5, z: 1.5 }, el)).toBe(false);
    expect(isBeyondBounds({ x: 1.5, z: 1.5 }, el)).toBe(true);
    expect(isBeyondBounds({ x: -0.1, z: 0.5 }, el)).toBe(true);
  });
  it("hold everything where the device tells of none", () => {
    expect(isBeyondBounds({ x: 9, z: 9 }, [])).toBe(false);
  });
});

describe("a pinch", () => {
  it("closes under 18 mm, opens over 30 mm, and opens when lost", () => {
    const pinch = new Pinch();
    const events = [0.05, 0.025, 0.015, 0.025, 0.035, 0.01, NONE].map((gap) => pinch.update(gap));
    expect(events).toEqual([null, null, "closed", null, "opened", "closed", "opened"]);
  });
});
