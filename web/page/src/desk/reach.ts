import { Matrix4, type Plane, Vector3 } from "three";
import { type ContactSurface, SurfaceFoot } from "../calibrate/surface.js";
import { INDEX_TIP } from "../world/pointing_hand.js";

/** What a hand must not go through, and from where it is looked at. */
export interface Surroundings {
  readonly surfaces: readonly ContactSurface[];
  readonly tables: readonly Plane[];
  /** Unit, the viewer's right, and away from the viewer. */
  readonly right: Vector3;
  readonly ahead: Vector3;
}

/** Joints that stand for the whole hand: wrist, knuckles, middle joints, tips. */
const WATCHED = [0, 2, 4, 6, 7, 8, 11, 12, 14, 16, 17, 19, 21, 22, 24];
const WAYS = 16;
/** How steeply the finger meets the surface. */
const STEEPNESS = [0.35, 0.75, 1.15];
/** What a millimetre inside a prop costs, as a turn away from the way one likes to come, rad. */
const PER_MM = 0.25;
/** What changing one's mind costs. */
const LAZINESS = 0.25;

/**
 * The turn of a right hand whose index fingertip touches a place: of all ways to come there, the one
 * that goes least through things, else from the viewer's right, and hides little of what it touches.
 *
 * @param local 25 × 16, the hand in its wrist's frame; radii 25, m
 * @param skin where the fingertip's skin is to be, m; normal: outward there, unit
 * @param before the turn so far, to which it keeps where others are no better
 */
export function reach(
  local: Float32Array,
  radii: Float32Array,
  skin: Vector3,
  normal: Vector3,
  around: Surroundings,
  before: Matrix4 | null,
): Matrix4 {
  const liked = around.right.clone().addScaledVector(around.ahead, -0.35).setZ(0.35).normalize();
  const first = anyTangent(normal, around.right);
  const second = new Vector3().crossVectors(normal, first);
  let best = new Matrix4();
  let least = Number.POSITIVE_INFINITY;
  for (let way = 0; way < WAYS; way++) {
    const angle = (2 * Math.PI * way) / WAYS;
    const along = first.clone().multiplyScalar(Math.cos(angle));
    along.addScaledVector(second, Math.sin(angle));
    for (const steepness of STEEPNESS) {
      const turn = handTurn(along, normal, steepness);
      const cost =
        dislike(local, turn, liked, around) +
        PER_MM * 1e3 * inside(local, radii, turn, skin, normal, around) +
        (before === null ? 0 : LAZINESS * angleBetween(turn, before));
      if (cost < least) [best, least] = [turn, cost];
    }
  }
  return best;
}

/** Where the hand's wrist is then: T_room_wrist, its index fingertip's skin at a place. */
export function placed(
  local: Float32Array,
  radii: Float32Array,
  turn: Matrix4,
  skin: Vector3,
  normal: Vector3,
): Matrix4 {
  const tip = joint(local, INDEX_TIP, new Vector3()).applyMatrix4(turn);
  const centre = skin.clone().addScaledVector(normal, radii[INDEX_TIP]!);
  return turn.clone().setPosition(centre.sub(tip));
}

/** How far the hand is inside of things, m, in all. */
export function inside(
  local: Float32Array,
  radii: Float32Array,
  turn: Matrix4,
  skin: Vector3,
  normal: Vector3,
  { surfaces, tables }: Pick<Surroundings, "surfaces" | "tables">,
): number {
  const T = placed(local, radii, turn, skin, normal);
  let depth = 0;
  for (const index of WATCHED) {
    joint(local, index, place).applyMatrix4(T);
    for (const surface of surfaces) {
      if (place.distanceTo(surface.centre) > surface.reach + radii[index]!) continue;
      depth += Math.max(0, radii[index]! - surface.nearest(place, foot).distance);
    }
    for (const table of tables) {
      depth += Math.max(0, radii[index]! - table.distanceToPoint(place));
    }
  }
  return depth;
}

/** How far, rad, the hand comes from where one would not: with its palm up, or in the way. */
function dislike(
  local: Float32Array,
  turn: Matrix4,
  liked: Vector3,
  { ahead }: Surroundings,
): number {
  joint(local, 0, wrist)
    .sub(joint(local, INDEX_TIP, tip))
    .transformDirection(turn);
  const backUp = new Vector3().setFromMatrixColumn(turn, 1).z;
  return wrist.angleTo(liked) + Math.max(0, -backUp) + Math.max(0, -wrist.dot(ahead) - 0.6);
}

/** The turn whose finger comes along a tangent, tilted into the surface, its pad on it. */
function handTurn(along: Vector3, normal: Vector3, steepness: number): Matrix4 {
  const finger = along.clone().multiplyScalar(Math.cos(steepness));
  finger.addScaledVector(normal, -Math.sin(steepness));
  const back = normal.clone().addScaledVector(finger, -normal.dot(finger)).normalize();
  const z = finger.negate();
  return new Matrix4().makeBasis(new Vector3().crossVectors(back, z), back, z);
}

function anyTangent(normal: Vector3, near: Vector3): Vector3 {
  const tangent = near.clone().addScaledVector(normal, -near.dot(normal));
  if (tangent.lengthSq() < 1e-6) tangent.set(0, 0, 1).addScaledVector(normal, -normal.z);
  return tangent.normalize();
}

function angleBetween(one: Matrix4, other: Matrix4): number {
  let trace = 0;
  for (const k of [0, 1, 2, 4, 5, 6, 8, 9, 10]) trace += one.elements[k]! * other.elements[k]!;
  return Math.acos(Math.min(1, Math.max(-1, (trace - 1) / 2)));
}

function joint(poses: Float32Array, index: number, out: Vector3): Vector3 {
  return out.fromArray(poses, 16 * index + 12);
}

const place = new Vector3();
const wrist = new Vector3();
const tip = new Vector3();
const foot = new SurfaceFoot();
