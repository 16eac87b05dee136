import { Euler, Matrix4, Quaternion, Vector3 } from "three";
import type { Pose } from "../calibrate/pose.js";
import type { Pose as ScenePose } from "../live/messages.js";

/** How far a prop stands from where the scene says. */
export interface Displaced {
  readonly name: string;
  readonly shift: number;
  readonly turn: number;
  readonly pose: ScenePose;
}

/** Below this a scene is as measured, m and rad: well under what calibration can tell. */
const SAME_PLACE = 0.001;
const SAME_TURN = (0.5 * Math.PI) / 180;

/**
 * Where calibrated props stand in the scene of the first one.
 *
 * @param placed each prop's pose in the scene file, and T_room_scene as calibrated by that prop alone
 */
export function measuredPoses(
  placed: readonly { name: string; scenePose: ScenePose; room: Pose }[],
): Displaced[] {
  const first = placed[0]!.room.matrix(new Matrix4()).invert();
  return placed.map(({ name, scenePose, room }) => {
    const before = matrixOf(scenePose);
    const after = first.clone().multiply(room.matrix(new Matrix4())).multiply(before);
    const [place, turn, size] = [new Vector3(), new Quaternion(), new Vector3()];
    after.decompose(place, turn, size);
    const [placeBefore, turnBefore] = [new Vector3(), new Quaternion()];
    before.decompose(placeBefore, turnBefore, size);
    // R = Rz·Ry·Rx, which three calls the order ZYX.
    const { x, y, z } = new Euler().setFromQuaternion(turn, "ZYX");
    const degrees = [x, y, z].map((angle) => (angle * 180) / Math.PI);
    return {
      name,
      shift: place.distanceTo(placeBefore),
      turn: turn.angleTo(turnBefore),
      pose: {
        position: place.toArray(),
        rotation_deg: [degrees[0]!, degrees[1]!, degrees[2]!],
      },
    };
  });
}

/** Those that stand elsewhere than the scene says. */
export function movedProps(measured: readonly Displaced[]): Displaced[] {
  return measured.filter(({ shift, turn }) => shift > SAME_PLACE || turn > SAME_TURN);
}

function matrixOf({ position, rotation_deg }: ScenePose): Matrix4 {
  const [x, y, z] = rotation_deg.map((angle) => (angle * Math.PI) / 180);
  const turn = new Quaternion().setFromEuler(new Euler(x, y, z, "ZYX"));
  return new Matrix4().compose(new Vector3(...position), turn, new Vector3(1, 1, 1));
}
