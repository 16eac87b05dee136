import { Matrix4, Quaternion, Vector3 } from "three";
import { describe, expect, it } from "vitest";
import { Pose } from "../../src/calibrate/pose.js";
import { measuredPoses, movedProps, standsOn } from "../../src/xr/several_props.js";

const room = new Pose(
  new Quaternion().setFromAxisAngle(new Vector3(0, 1, 0), 0.7),
  new Vector3(0.3, 0.8, -0.4),
);
const cup = { position: [0, 0, 0], rotation_deg: [0, 0, 0] } as const;
const box = { position: [0.2, 0.1, 0], rotation_deg: [10, -20, 30] } as const;

describe("several props", () => {
  it("that stand as the scene says need no new solve", () => {
    const measured = measuredPoses([
      { name: "cup", scenePose: cup, room, onTable: false },
      { name: "box", scenePose: box, room, onTable: false },
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
        { name: "cup", scenePose: cup, room, onTable: false },
        { name: "box", scenePose: box, room: new Pose(turn, place), onTable: false },
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

  it.each([
    [true, true, 0.004, 0],
    [true, true, 0.03, 0.03],
    [false, true, 0.004, 0.004],
    [true, false, 0.004, 0.004],
  ])("on one table are as high as it: %s, %s, %d m", (first, second, raised, height) => {
    const up = new Pose(room.turn.clone(), room.place.clone().add(new Vector3(0, raised, 0)));
    // the room's vertical is y, the scene's z
    const upright = new Quaternion().setFromUnitVectors(new Vector3(0, 0, 1), new Vector3(0, 1, 0));
    up.turn.copy(upright);
    const measured = measuredPoses([
      { name: "cup", scenePose: cup, room: new Pose(upright, room.place), onTable: first },
      { name: "box", scenePose: box, room: up, onTable: second },
    ]);
    expect(measured[1]!.pose.position[2]).toBeCloseTo(height, 9);
  });

  it("stand on a level plane that their lowest point is on", () => {
    const table = { name: "table", point: [0, 0, 0.1], normal: [0, 0, 1] } as const;
    const wall = { name: "wall", point: [0, 0, 0], normal: [1, 0, 0] } as const;
    expect(standsOn([wall, table], 0.1003)).toBe(true);
    expect(standsOn([wall, table], 0.103)).toBe(false);
    expect(standsOn([wall], 0)).toBe(false);
  });
});
