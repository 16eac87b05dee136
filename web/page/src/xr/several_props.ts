import { Euler, Matrix4, Quaternion, Vector3 } from "three";
import type { Pose } from "../calibrate/pose.js";
import type { Plane, Pose as ScenePose } from "../live/messages.js";

/** A prop as its scene has it, and where calibrating it alone puts that scene. */
export interface CalibratedProp {
  readonly name: string;
  readonly scenePose: ScenePose;
  /** T_room_scene. */
  readonly room: Pose;
  /** Whether it stands on a level table of the scene. */
  readonly onTable: boolean;
}

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
/** Two props on one table are as high as the table; what touches say otherwise is their error, m. */
const SAME_HEIGHT = 0.015;

/** Where calibrated props stand in the scene of the first one. */
export function measuredPoses(placed: readonly CalibratedProp[]): Displaced[] {
  const [anchor] = placed as [CalibratedProp];
  const first = anchor.room.matrix(new Matrix4()).invert();
  return placed.map(({ name, scenePose, room, onTable }) => {
    const before = matrixOf(scenePose);
    const after = first.clone().multiply(room.matrix(new Matrix4())).multiply(before);
    const [place, turn, size] = [new Vector3(), new Quaternion(), new Vector3()];
    after.decompose(place, turn, size);
    const [placeBefore, turnBefore] = [new Vector3(), new Quaternion()];
    before.decompose(placeBefore, turnBefore, size);
    const raised = Math.abs(place.z - placeBefore.z);
    if (onTable && anchor.onTable && raised < SAME_HEIGHT) place.z = placeBefore.z;
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

/** Whether a prop's lowest point is on a level plane of the scene. */
export function standsOn(planes: readonly Plane[], lowest: number): boolean {
  return planes.some(
    ({ normal, point }) => normal[2] > 0.999 && Math.abs(lowest - point[2]) < 1e-3,
  );
}

function matrixOf({ position, rotation_deg }: ScenePose): Matrix4 {
  const [x, y, z] = rotation_deg.map((angle) => (angle * Math.PI) / 180);
  const turn = new Quaternion().setFromEuler(new Euler(x, y, z, "ZYX"));
  return new Matrix4().compose(new Vector3(...position), turn, new Vector3(1, 1, 1));
}
