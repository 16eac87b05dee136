import { Plane, Vector3 } from "three";
import { describe, expect, it } from "vitest";
import { inside, placed, reach, type Surroundings } from "../../src/desk/reach.js";
import { INDEX_TIP, pointingPoses, pointingRadii } from "../../src/world/pointing_hand.js";
import { mugSurface } from "../calibrate/mug.js";

const mug = mugSurface();
const around: Surroundings = {
  surfaces: [mug],
  tables: [new Plane(new Vector3(0, 0, 1), 0)],
  right: new Vector3(1, 0, 0),
  ahead: new Vector3(0, 0.85, -0.53),
};
const nothing = { ...around, surfaces: [], tables: [] };
const hand = pointingPoses();
const radii = pointingRadii;

/** Places that a mouse can point at: the side of the mug that looks to the viewer. */
const places = mug
  .sample(150)
  .filter(({ point, normal }) => normal.dot(around.ahead) < -0.3 && point.z > 0.03);

/** How far, m, the hand is inside of mug and table at these places, in the middle and at most. */
function depths(surroundings: Surroundings): { typical: number; most: number } {
  const all = places.map(({ point, normal }) => {
    const turn = reach(hand, radii, point, normal, surroundings, null);
    return inside(hand, radii, turn, point, normal, around);
  });
  all.sort((one, other) => one - other);
  return { typical: all[all.length >> 1]!, most: all.at(-1)! };
}

describe("how the hand reaches a place", () => {
  it("goes round the mug and over the table", () => {
    const { typical, most } = depths(around);
    expect(typical).toBeLessThan(0.001);
    expect(most).toBeLessThan(0.01);
  });

  it("would go through them if it did not look", () => {
    expect(depths(nothing).most).toBeGreaterThan(0.03);
  });

  it("puts the fingertip's skin there", () => {
    const { point, normal } = places[3]!;
    const turn = reach(hand, radii, point, normal, around, null);
    const T = placed(hand, radii, turn, point, normal);
    const tip = new Vector3().fromArray(hand, 16 * INDEX_TIP + 12).applyMatrix4(T);
    const radius = radii[INDEX_TIP]!;
    expect(tip.distanceTo(point.clone().addScaledVector(normal, radius))).toBeLessThan(1e-7);
  });

  it("comes from the viewer's right where nothing is in the way", () => {
    const turn = reach(hand, radii, new Vector3(0, 0, 0.3), new Vector3(0, 0, 1), nothing, null);
    const T = placed(hand, radii, turn, new Vector3(0, 0, 0.3), new Vector3(0, 0, 1));
    expect(new Vector3().fromArray(hand, 12).applyMatrix4(T).x).toBeGreaterThan(0.08);
  });

  it("keeps to the way it has come unless another is much better", () => {
    const { point, normal } = places[3]!;
    const before = reach(hand, radii, point, normal, around, null);
    const moved = point.clone().add(new Vector3(0.0005, 0, 0));
    const after = reach(hand, radii, moved, normal, around, before);
    expect(after.elements).toEqual(before.elements);
  });
});
