import { Quaternion, Vector3 } from "three";
import type { Contact } from "./contact.js";
import type { Pose } from "./pose.js";
import { type ContactSurface, SurfaceFoot } from "./surface.js";

/**
 * One scalar equation of a contact: how far the tracked skin is off along `axis`.
 *
 * A finger on the surface gives one row, along the surface's normal there; one that was asked to a
 * named point gives three more, of how far it is beside that.
 */
export interface Row {
  contact: Contact;
  /** The fingertip's centre, mended by the offset, room frame. */
  readonly tip: Vector3;
  /** Unit, room frame; the residual falls by what the prop moves along it. */
  readonly axis: Vector3;
  /** Metres. */
  residual: number;
  /** A standard deviation of its own, besides that of tracking: how people aim. */
  aim: number;
}

/** Where the prop stands and by how much the tracked fingertips are off in their own frame. */
export interface Placement {
  readonly pose: Pose;
  /** m, fingertip frame: tracked = true + turn · offset. */
  readonly tipOffset: Vector3;
}

/** Calls `visit` with every row of the contacts; the row is one object, filled anew each time.
 * `coarse` takes distances from the surface's grid instead of its triangles. */
export function visitRows(
  surface: ContactSurface,
  contacts: readonly Contact[],
  { pose, tipOffset }: Placement,
  pointing: number,
  coarse: boolean,
  visit: (row: Row) => void,
): void {
  toProp.copy(pose.turn).invert();
  for (const contact of contacts) {
    row.contact = contact;
    row.tip.copy(tipOffset).applyQuaternion(contact.turn).negate().add(contact.tip);
    if (contact.named) visitNamed(contact, pose, pointing, coarse, visit);
    // However far beside the place a finger is, it is on the surface: the distance tells that, once
    // the pose is so near that the nearest surface is the one that is touched.
    if (!contact.named || !coarse) {
      inProp.subVectors(row.tip, pose.place).applyQuaternion(toProp);
      if (coarse) foot.distance = surface.field.at(inProp, foot.gradient);
      else surface.nearest(inProp, foot);
      row.axis.copy(foot.gradient).applyQuaternion(pose.turn);
      row.residual = foot.distance - contact.radius;
      row.aim = 0;
      visit(row);
    }
  }
}

function visitNamed(
  contact: Contact,
  pose: Pose,
  pointing: number,
  coarse: boolean,
  visit: (row: Row) => void,
): void {
  const { point, normal } = contact.named!;
  const outward = normal.clone().applyQuaternion(pose.turn);
  const offset = pose.toRoom(point).addScaledVector(outward, contact.radius).negate().add(row.tip);
  const helper = Math.abs(outward.y) < 0.9 ? new Vector3(0, 1, 0) : new Vector3(1, 0, 0);
  const first = helper.cross(outward).normalize();
  const second = new Vector3().crossVectors(outward, first);
  for (const axis of [outward, first, second]) {
    row.axis.copy(axis);
    row.residual = offset.dot(axis);
    // to the side by `pointing`, and on a curved surface lower for that
    row.aim = axis !== outward ? pointing : coarse ? 0 : pointing / 2;
    visit(row);
  }
}

/** Rows that stay. */
export function collectRows(
  surface: ContactSurface,
  contacts: readonly Contact[],
  placement: Placement,
  pointing: number,
): Row[] {
  const rows: Row[] = [];
  visitRows(surface, contacts, placement, pointing, false, (each) => {
    rows.push({ ...each, tip: each.tip.clone(), axis: each.axis.clone() });
  });
  return rows;
}

/**
 * Derivative of a row's residual to the unknowns: the prop's translation (3), its turns about axes
 * through `pivot`, and, if `out` has room for it, the fingertip's offset (3).
 */
export function rowDerivative(
  { axis, tip, contact }: Row,
  pivot: Vector3,
  axes: readonly Vector3[],
  out: Float64Array,
): void {
  out[0] = -axis.x;
  out[1] = -axis.y;
  out[2] = -axis.z;
  lever.subVectors(tip, pivot).cross(axis);
  for (let k = 0; k < axes.length; k++) out[3 + k] = -lever.dot(axes[k]!);
  const next = 3 + axes.length;
  if (out.length === next) return;
  lever.copy(axis).applyQuaternion(toHand.copy(contact.turn).invert());
  out[next] = -lever.x;
  out[next + 1] = -lever.y;
  out[next + 2] = -lever.z;
}

const inProp = new Vector3();
const lever = new Vector3();
const toProp = new Quaternion();
const toHand = new Quaternion();
const foot = new SurfaceFoot();
const row: Row = {
  contact: { tip: new Vector3(), turn: new Quaternion(), radius: 0, time: 0 },
  tip: new Vector3(),
  axis: new Vector3(),
  residual: 0,
  aim: 0,
};
