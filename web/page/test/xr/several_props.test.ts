import { Matrix4, Quaternion, Vector3 } from "three";
import { describe, expect, it } from "vitest";
import { Pose } from "../../src/calibrate/pose.js";
import { measuredPoses, movedProps } from "../../src/xr/several_props.js";

const room = new Pose(
  new Quaternion().setFromAxisAngle(new Vector3(0, 1, 0), 0.7),
  new Vector3(0.3, 0.8, -0.4),
);
const cup = { position: [0, 0, 0], rotation_deg: [0, 0, 0] } as const;
const box = { position: [0.2, 0.1, 0], rotation_deg: [10, -20, 30] } as const;

describe("several props", () => {
  it("that stand as the scene says need no new solve", () => {
    const measured = measuredPoses([
      { name: "cup", scenePose: cup, room },
      { name: "box", scenePose: box, room },
    ]);
    expect(movedProps(measured)).toEqual([]);
    for (const [k, degrees] of [10, -20, 30].entries()) {
      expect(measured[1]!.pose.rotation_deg[k]).toBeCloseTo(degrees, 6);
    }
  });

  it("are told of where they really stand, in the first one's scene", () => {
    // In the scene the box has been moved by 40 mm in x and turned by 15° about z, about the origin.
    const change = new Matrix4().makeRotationZ((15 * Math.PI) / 180).setPosition(0.04, 0, 0);
    const moved = room.matrix(new Matrix4()).multiply(change);
    const [place, turn, size] = [new Vector3(), new Quaternion(), new Vector3()];
    moved.decompose(place, turn, size);
    const [found] = movedProps(
      measuredPoses([
        { name: "cup", scenePose: cup, room },
        { name: "box", scenePose: box, room: new Pose(turn, place) },
      ]),
    );
    const expected = new Vector3(0.2, 0.1, 0).applyMatrix4(change);
    expect(found!.name).toBe("box");
    expect(new Vector3(...found!.pose.position).distanceTo(expected)).toBeLessThan(1e-9);
    // Rz(15°) · Rz(30°) · …: the turn about z adds up, the others stay.
    const expectedTurns = [10, -20, 45];
    found!.pose.rotation_deg.forEach((degrees, k) => {
      expect(degrees).toBeCloseTo(expectedTurns[k]!, 6);
    });
    expect((found!.turn * 180) / Math.PI).toBeCloseTo(15, 6);
  });
});
