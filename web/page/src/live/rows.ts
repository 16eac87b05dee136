import type { Quaternion, Vector3 } from "three";
import type { ChunkHeader } from "./messages.js";

export const JOINTS = [
  "wrist",
  ...["thumb-metacarpal", "thumb-phalanx-proximal", "thumb-phalanx-distal", "thumb-tip"],
  ...["index", "middle", "ring", "pinky"].flatMap((finger) =>
    ["metacarpal", "phalanx-proximal", "phalanx-intermediate", "phalanx-distal", "tip"].map(
      (part) => `${finger}-finger-${part}`,
    ),
  ),
] as const;

const POSE = ["x", "y", "z", "qx", "qy", "qz", "qw"];

/** The numbers of one row: one hand in one frame. Lengths in m, room frame; NaN where lost. */
export const COLUMNS: readonly string[] = [
  "time_ms",
  "hand",
  "weight",
  "contacts",
  ...["real", "displayed"].flatMap((which) =>
    JOINTS.flatMap((joint) => POSE.map((part) => `${which}.${joint}.${part}`)),
  ),
  ...JOINTS.map((joint) => `radius.${joint}`),
  ...POSE.map((part) => `scene.${part}`),
];

const FIRST_POSE = 4;
const RADII = FIRST_POSE + 2 * 7 * JOINTS.length;
const SCENE = RADII + JOINTS.length;

/**
 * Write one hand of one frame as a row at `start`; allocates nothing.
 * @param poses 25 × 16 numbers each, column-major, as `XRFrame.fillPoses` gives them.
 * @param T_room_scene column-major: where the scene stands.
 */
export function writeRow(
  out: Float64Array,
  start: number,
  time: number,
  hand: 0 | 1,
  weight: number,
  contacts: number,
  real: Float32Array,
  displayed: Float32Array,
  radii: Float32Array,
  T_room_scene: ArrayLike<number>,
): void {
  out[start] = time;
  out[start + 1] = hand;
  out[start + 2] = weight;
  out[start + 3] = contacts;
  for (let joint = 0; joint < JOINTS.length; joint++) {
    const place = start + FIRST_POSE + 7 * joint;
    writePose(out, place, real, 16 * joint);
    writePose(out, place + 7 * JOINTS.length, displayed, 16 * joint);
    out[start + RADII + joint] = radii[joint]!;
  }
  writePose(out, start + SCENE, T_room_scene, 0);
}

/** Position and unit quaternion of a rigid matrix, by its greatest component (Shepperd 1978). */
function writePose(out: Float64Array, at: number, m: ArrayLike<number>, o: number): void {
  out[at] = m[o + 12]!;
  out[at + 1] = m[o + 13]!;
  out[at + 2] = m[o + 14]!;
  const xx = m[o]!;
  const yy = m[o + 5]!;
  const zz = m[o + 10]!;
  const trace = xx + yy + zz;
  let x: number;
  let y: number;
  let z: number;
  let w: number;
  if (trace >= xx && trace >= yy && trace >= zz) {
    w = 1 + trace;
    x = m[o + 6]! - m[o + 9]!;
    y = m[o + 8]! - m[o + 2]!;
    z = m[o + 1]! - m[o + 4]!;
  } else if (xx >= yy && xx >= zz) {
    w = m[o + 6]! - m[o + 9]!;
    x = 1 + xx - yy - zz;
    y = m[o + 1]! + m[o + 4]!;
    z = m[o + 8]! + m[o + 2]!;
  } else if (yy >= zz) {
    w = m[o + 8]! - m[o + 2]!;
    x = m[o + 1]! + m[o + 4]!;
    y = 1 + yy - xx - zz;
    z = m[o + 6]! + m[o + 9]!;
  } else {
    w = m[o + 1]! - m[o + 4]!;
    x = m[o + 8]! + m[o + 2]!;
    y = m[o + 6]! + m[o + 9]!;
    z = 1 + zz - xx - yy;
  }
  const length = Math.hypot(x, y, z, w);
  out[at + 3] = x / length;
  out[at + 4] = y / length;
  out[at + 5] = z / length;
  out[at + 6] = w / length;
}

/** Joint positions of a row: which = 0 real, 1 displayed. */
export function readPositions(
  rows: Float64Array,
  start: number,
  which: 0 | 1,
  out: Float32Array,
): void {
  for (let joint = 0; joint < JOINTS.length; joint++) {
    const place = start + FIRST_POSE + 7 * (joint + which * JOINTS.length);
    for (let d = 0; d < 3; d++) out[3 * joint + d] = rows[place + d]!;
  }
}

/** Where the scene stood in the room; false in a recording that does not tell. */
export function readScenePose(
  rows: Float64Array,
  start: number,
  columns: readonly string[],
  place: Vector3,
  turn: Quaternion,
): boolean {
  const first = columns.indexOf("scene.x");
  if (first < 0) return false;
  place.fromArray(rows, start + first);
  turn.fromArray(rows, start + first + 3);
  return true;
}

/** A binary message: u32 length of the header, the header, padding to 8 bytes, float64 rows. */
export function packChunk(header: ChunkHeader, numbers: Float64Array): ArrayBuffer {
  const text = new TextEncoder().encode(JSON.stringify(header));
  const begin = Math.ceil((4 + text.length) / 8) * 8;
  const bytes = new ArrayBuffer(begin + 8 * numbers.length);
  new DataView(bytes).setUint32(0, text.length, true);
  new Uint8Array(bytes).set(text, 4);
  new Float64Array(bytes, begin).set(numbers);
  return bytes;
}

/** The same undone. */
export function unpackChunk<H>(bytes: ArrayBuffer): { header: H; numbers: Float64Array } {
  const length = new DataView(bytes).getUint32(0, true);
  const header = JSON.parse(new TextDecoder().decode(new Uint8Array(bytes, 4, length))) as H;
  return { header, numbers: new Float64Array(bytes, Math.ceil((4 + length) / 8) * 8) };
}
