import { Box3, Matrix4, type Mesh, Quaternion, Scene, Vector3 } from "three";
import { expect, test } from "vitest";
import { Replay } from "../../src/desk/replay.js";
import type { Stage } from "../../src/desk/stage.js";
import { COLUMNS, writeRow } from "../../src/live/rows.js";
import type { HandPicture } from "../../src/world/hand_picture.js";
import { pointingPoses, pointingRadii } from "../../src/world/pointing_hand.js";

/** As a headset tells it: y is up, and the scene stands somewhere in the room. */
const T_ROOM_SCENE = new Matrix4().compose(
  new Vector3(0.3, 0.8, -0.4),
  new Quaternion().setFromUnitVectors(new Vector3(0, 0, 1), new Vector3(0, 1, 0)),
  new Vector3(1, 1, 1),
);

/** A pointing hand moved by `along` m in the scene, where the room has it. */
function hand(along: number): Float32Array {
  const poses = pointingPoses();
  const joint = new Matrix4();
  for (let at = 0; at < poses.length; at += 16) {
    joint.fromArray(poses, at).premultiply(new Matrix4().makeTranslation(along, 0, 0));
    joint.premultiply(T_ROOM_SCENE).toArray(poses, at);
  }
  return poses;
}

function recording(columns: readonly string[] = COLUMNS): Replay {
  const rows = new Float64Array(3 * COLUMNS.length);
  const row = (index: number, time: number, side: 0 | 1, along: number) =>
    writeRow(
      rows,
      index * COLUMNS.length,
      time,
      side,
      1,
      0,
      hand(along),
      hand(along + 1),
      pointingRadii,
      T_ROOM_SCENE.elements,
    );
  row(0, 1000, 0, 0);
  row(1, 1000, 1, 5);
  row(2, 1014, 1, 6);
  const stage = { scene: new Scene(), draw: () => {} } as unknown as Stage;
  return new Replay(stage, columns, rows);
}

/** The middle of each hand that is to be seen, left first: real, ghost, displayed. */
function middles({ stage }: Replay): (Vector3 | null)[] {
  return stage.scene.children.map((picture) => {
    if (!picture.visible) return null;
    const { geometry } = (picture as HandPicture).children[0] as Mesh;
    const positions = geometry.getAttribute("position").array;
    const drawn = Array.from(geometry.index!.array, (n) =>
      new Vector3().fromArray(positions, 3 * n),
    );
    return new Box3().setFromPoints(drawn).getCenter(new Vector3());
  });
}

test("both hands of a moment are shown, where they were beside the prop", () => {
  const replay = recording();
  expect(replay.moments.map(({ time }) => time)).toEqual([0, 14]);
  replay.show();
  const [left, , leftShown, right, , rightShown] = middles(replay);
  expect(right!.x - left!.x).toBeCloseTo(5, 5);
  expect(leftShown!.x - left!.x).toBeCloseTo(1, 5);
  expect(rightShown!.x - right!.x).toBeCloseTo(1, 5);
  // the same hand that was never carried into a room
  const poses = pointingPoses();
  const wrist = new Vector3().fromArray(poses, 12);
  expect(left!.distanceTo(wrist)).toBeLessThan(0.25);
});

test("a hand that is not in a moment is not shown", () => {
  const replay = recording();
  expect(replay.advance(20)).toBe(true);
  expect(replay.ended).toBe(true);
  replay.show();
  expect(middles(replay).map((middle) => middle === null)).toEqual([
    true,
    true,
    true,
    false,
    false,
    false,
  ]);
});

test("without the scene's pose hands are where the room had them: the twin", () => {
  const told = recording(COLUMNS.map((name) => name.replace("scene.", "other.")));
  told.show();
  const moved = recording();
  moved.show();
  expect(middles(told)[0]!.distanceTo(middles(moved)[0]!)).toBeGreaterThan(0.3);
});
