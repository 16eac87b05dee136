import { Matrix4, Quaternion, Vector3 } from "three";

/** Which motions of the prop are sought: an upright prop keeps its axis along `up`. */
export type Freedom = 4 | 6;

/** A rigid pose; acts on columns, x_room = turn · x_prop + place. */
export class Pose {
  constructor(
    readonly turn = new Quaternion(),
    readonly place = new Vector3(),
  ) {}

  /** Of a rigid T_room_prop. */
  static of(matrix: Matrix4): Pose {
    const pose = new Pose();
    matrix.decompose(pose.place, pose.turn, size);
    pose.turn.normalize();
    return pose;
  }

  clone(): Pose {
    return new Pose(this.turn.clone(), this.place.clone());
  }

  toRoom(point: Vector3, out = new Vector3()): Vector3 {
    return out.copy(point).applyQuaternion(this.turn).add(this.place);
  }

  toProp(point: Vector3, out = new Vector3()): Vector3 {
    return out.subVectors(point, this.place).applyQuaternion(inverse.copy(this.turn).invert());
  }

  /** T_room_prop. */
  matrix(out = new Matrix4()): Matrix4 {
    return out.compose(this.place, this.turn, ONE);
  }

  /** This pose, turned by `rotation` (a rotation vector, room frame) about `pivot`, then moved. */
  moved(rotation: Vector3, pivot: Vector3, translation: Vector3): Pose {
    const angle = rotation.length();
    const step = new Quaternion();
    if (angle > 0) step.setFromAxisAngle(rotation.clone().divideScalar(angle), angle);
    const place = this.place.clone().sub(pivot).applyQuaternion(step).add(pivot).add(translation);
    return new Pose(step.multiply(this.turn).normalize(), place);
  }
}

const ONE = new Vector3(1, 1, 1);
const inverse = new Quaternion();
const size = new Vector3();

/** The turn that takes a scene with z up to a room whose vertical is `up`. */
export function uprightTurn(up: Vector3): Quaternion {
  return new Quaternion().setFromUnitVectors(new Vector3(0, 0, 1), up);
}

/** Rotation axes of the freedom: the vertical, or all three of the room. */
export function turnAxes(freedom: Freedom, up: Vector3): Vector3[] {
  return freedom === 4
    ? [up.clone()]
    : [new Vector3(1, 0, 0), new Vector3(0, 1, 0), new Vector3(0, 0, 1)];
}
