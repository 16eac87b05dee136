import { Quaternion, Vector3 } from "three";
import type { Contact } from "./contact.js";
import { Pose, uprightTurn } from "./pose.js";
import type { Task } from "./register.js";

const HEIGHTS = [-0.5, -0.25, 0, 0.25, 0.5];

/** Poses turned all around, the prop's middle in the middle of the contacts, or higher or lower. */
export function startPoses(task: Task): Pose[] {
  const upright = uprightTurn(task.up);
  const sides = task.freedom === 4 ? [new Quaternion()] : sixSides();
  const count = task.freedom === 4 ? 36 : 18;
  const middle = boxCentre(task.contacts);
  const tall = task.surface.highest.z - task.surface.lowest.z;
  const starts: Pose[] = [];
  for (const side of sides) {
    for (let k = 0; k < count; k++) {
      const turn = new Quaternion().setFromAxisAngle(task.up, (2 * Math.PI * k) / count);
      turn.multiply(upright).multiply(side);
      for (const height of HEIGHTS) {
        const place = task.surface.centre.clone().applyQuaternion(turn).negate().add(middle);
        starts.push(new Pose(turn, place.addScaledVector(task.up, height * tall)));
      }
    }
  }
  return starts;
}

/** The turns that put each side of a die on top. */
function sixSides(): Quaternion[] {
  const x = new Vector3(1, 0, 0);
  const y = new Vector3(0, 1, 0);
  return [
    ...[0, 1, 2, 3].map((k) => new Quaternion().setFromAxisAngle(x, (k * Math.PI) / 2)),
    ...[1, 3].map((k) => new Quaternion().setFromAxisAngle(y, (k * Math.PI) / 2)),
  ];
}

/** Middle of the box that holds the contacts, but for the farthest tenth on each side. */
function boxCentre(contacts: readonly Contact[]): Vector3 {
  const middle = new Vector3();
  for (let axis = 0; axis < 3; axis++) {
    const along = contacts.map(({ tip }) => tip.getComponent(axis)).sort((a, b) => a - b);
    const tail = Math.floor(along.length / 10);
    middle.setComponent(axis, (along[tail]! + along[along.length - 1 - tail]!) / 2);
  }
  return middle;
}
