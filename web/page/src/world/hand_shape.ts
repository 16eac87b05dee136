import { Vector3 } from "three";

/**
 * A hand's skin over balls, one at each joint: round cones between two of them, and over the palm two
 * smooth sheets that touch the balls (after the sphere-meshes of Thiery et al. 2013). At a fingertip
 * the skin is the joint's own ball, so what is seen to touch is what the warp makes touch.
 */

export const JOINT_COUNT = 25;
/** The ball at each side of the wrist and of the stump behind it, after WebXR's joints. */
const [WRIST_IN, WRIST_OUT, STUMP_IN, STUMP_OUT] = [25, 26, 27, 28] as const;
export const BALL_COUNT = 29;

/** Pairs of balls: the bones of fingers, the palm's outline, and the wrist's. */
export const CONES: readonly (readonly [number, number])[] = [
  ...[1, 2, 3].map((joint) => [joint, joint + 1] as const),
  ...[6, 11, 16, 21].flatMap((knuckle) =>
    [0, 1, 2].map((k) => [knuckle + k, knuckle + k + 1] as const),
  ),
  ...[6, 11, 16].map((knuckle) => [knuckle, knuckle + 5] as const),
  [5, 6],
  [20, 21],
  [WRIST_IN, 1],
  [WRIST_OUT, 20],
  [WRIST_IN, STUMP_IN],
  [WRIST_OUT, STUMP_OUT],
  [STUMP_IN, STUMP_OUT],
];

/** Triples of balls that the sheets span: palm, web of the thumb, wrist; all wound the same way. */
const WEDGES: readonly (readonly [number, number, number])[] = [
  ...[5, 10, 15].flatMap((ray) => [
    [ray, ray + 1, ray + 6] as const,
    [ray, ray + 6, ray + 5] as const,
  ]),
  [WRIST_IN, 5, 10],
  [WRIST_IN, 10, 15],
  [WRIST_IN, 15, WRIST_OUT],
  [WRIST_OUT, 15, 20],
  [WRIST_IN, 1, 5],
  [1, 2, 5],
  [2, 6, 5],
  [WRIST_IN, WRIST_OUT, STUMP_IN],
  [STUMP_IN, WRIST_OUT, STUMP_OUT],
];

/** Of the wrist's radius: how far apart its two balls are from its middle, how thick they are, and
 * how far behind it the stump ends. */
const [APART, THICK, BEHIND] = [0.62, 0.8, 1.5];
const USUAL_RADIUS = 0.008;

/** The balls of a hand: centres (29, 3) and radii (29), m; a lost joint's radius is 0. */
export class Balls {
  readonly centres = new Float32Array(3 * BALL_COUNT);
  readonly radii = new Float32Array(BALL_COUNT);
  #across = new Vector3();
  #back = new Vector3();
  #wrist = new Vector3();

  /**
   * @param positions rows of `stride` numbers from `offset`: (3, 0) points, (16, 12) matrices.
   * @param radii 25, m; NaN counts as 8 mm.
   */
  place(positions: ArrayLike<number>, radii: ArrayLike<number>, stride: number, offset: number) {
    const { centres } = this;
    for (let joint = 0; joint < JOINT_COUNT; joint++) {
      for (let d = 0; d < 3; d++) centres[3 * joint + d] = positions[stride * joint + offset + d]!;
      const radius = radii[joint]!;
      const lost = Number.isNaN(centres[3 * joint]!);
      this.radii[joint] = lost ? 0 : radius > 0 ? radius : USUAL_RADIUS;
    }
    this.#placeWrist();
  }

  /** The wrist is flat: across is from the index finger's side to the little finger's. */
  #placeWrist(): void {
    const { centres, radii } = this;
    const wrist = this.#wrist.fromArray(centres, 0);
    const across = this.#across.fromArray(centres, 3 * 20).sub(this.#back.fromArray(centres, 15));
    const back = this.#back
      .fromArray(centres, 3 * 10)
      .sub(wrist)
      .negate()
      .normalize();
    across.addScaledVector(back, -across.dot(back)).normalize();
    const radius = radii[0]!;
    const known = radius > 0 && Number.isFinite(across.x + back.x);
    for (let k = 0; k < 4; k++) {
      const side = k % 2 === 0 ? -APART : APART;
      const behind = k < 2 ? 0 : BEHIND;
      for (let d = 0; d < 3; d++) {
        centres[3 * (WRIST_IN + k) + d] =
          wrist.getComponent(d) +
          radius * (side * across.getComponent(d) + behind * back.getComponent(d));
      }
      radii[WRIST_IN + k] = known ? THICK * radius : 0;
    }
  }
}

/** Around a cone, and from its pole to the rim of each cap: with fewer, sheets and cones that touch
 * along a line cut each other in teeth. */
const AROUND = 24;
const RINGS = 5;
export const CONE_VERTICES = 2 * RINGS * AROUND;

const SHEETS = CONE_VERTICES * CONES.length;

export const VERTEX_COUNT = SHEETS + 2 * BALL_COUNT;

const COS = Float32Array.from({ length: AROUND }, (_, k) => Math.cos((2 * Math.PI * k) / AROUND));
const SIN = Float32Array.from({ length: AROUND }, (_, k) => Math.sin((2 * Math.PI * k) / AROUND));

/** Triangles, always the same ones. */
export function skinFaces(): Uint16Array {
  const faces: number[] = [];
  for (let cone = 0; cone < CONES.length; cone++) {
    const first = cone * CONE_VERTICES;
    for (let ring = 0; ring + 1 < 2 * RINGS; ring++) {
      for (let k = 0; k < AROUND; k++) {
        const next = (k + 1) % AROUND;
        const [a, b] = [first + ring * AROUND + k, first + ring * AROUND + next];
        faces.push(a, b, b + AROUND, a, b + AROUND, a + AROUND);
      }
    }
  }
  for (const [a, b, c] of WEDGES) {
    faces.push(SHEETS + a, SHEETS + b, SHEETS + c);
    faces.push(SHEETS + BALL_COUNT + a, SHEETS + BALL_COUNT + c, SHEETS + BALL_COUNT + b);
  }
  return Uint16Array.from(faces);
}

/** Which vertices are on the outermost part of a fingertip: by finger, thumb first. */
export function tipVertices(): number[][] {
  return [4, 9, 14, 19, 24].map((tip) => {
    const cone = CONES.findIndex(([, end]) => end === tip);
    const from = cone * CONE_VERTICES + (RINGS + 1) * AROUND;
    return Array.from({ length: (RINGS - 1) * AROUND }, (_, k) => from + k);
  });
}

/** Vertices and normals of the skin, (VERTEX_COUNT, 3) each, written. */
export function writeSkin(balls: Balls, positions: Float32Array, normals: Float32Array): void {
  CONES.forEach(([a, b], cone) => {
    writeCone(balls, a, b, cone * CONE_VERTICES, positions, normals);
  });
  writeSheets(balls, positions, normals);
}

/** The hull of two balls: two caps that end where one cone touches both. */
function writeCone(
  { centres, radii }: Balls,
  a: number,
  b: number,
  first: number,
  positions: Float32Array,
  normals: Float32Array,
): void {
  from.fromArray(centres, 3 * a);
  axis.fromArray(centres, 3 * b).sub(from);
  const length = axis.length();
  const [ra, rb] = [radii[a]!, radii[b]!];
  if (!(ra > 0 && rb > 0 && length > 1e-6)) {
    positions.fill(0, 3 * first, 3 * (first + CONE_VERTICES));
    return;
  }
  axis.divideScalar(length);
  side.set(Math.abs(axis.x) < 0.7 ? 1 : 0, Math.abs(axis.x) < 0.7 ? 0 : 1, 0);
  side.addScaledVector(axis, -side.dot(axis)).normalize();
  other.crossVectors(axis, side);
  const rim = Math.asin(Math.min(1, Math.max(-1, (ra - rb) / length)));
  let at = 3 * first;
  for (let ring = 0; ring < 2 * RINGS; ring++) {
    const atEnd = ring >= RINGS;
    const share = (ring % RINGS) / (RINGS - 1);
    const height = atEnd
      ? rim + share * (Math.PI / 2 - rim)
      : -Math.PI / 2 + share * (rim + Math.PI / 2);
    const [up, out] = [Math.sin(height), Math.cos(height)];
    const [radius, centre] = atEnd ? [rb, 3 * b] : [ra, 3 * a];
    for (let k = 0; k < AROUND; k++) {
      const [c, s] = [out * COS[k]!, out * SIN[k]!];
      const x = up * axis.x + c * side.x + s * other.x;
      const y = up * axis.y + c * side.y + s * other.y;
      const z = up * axis.z + c * side.z + s * other.z;
      normals[at] = x;
      normals[at + 1] = y;
      normals[at + 2] = z;
      positions[at] = centres[centre]! + radius * x;
      positions[at + 1] = centres[centre + 1]! + radius * y;
      positions[at + 2] = centres[centre + 2]! + radius * z;
      at += 3;
    }
  }
}

/** Where the sheets touch each ball: in the direction of the planes that touch it and its neighbours. */
function writeSheets(balls: Balls, positions: Float32Array, normals: Float32Array): void {
  const { centres, radii } = balls;
  positions.fill(0, 3 * SHEETS);
  normals.fill(0, 3 * SHEETS);
  for (const corners of WEDGES) {
    if (corners.some((ball) => !(radii[ball]! > 0))) continue;
    for (const [up, first] of [
      [1, SHEETS],
      [-1, SHEETS + BALL_COUNT],
    ] as const) {
      touchingPlane(balls, corners, up, normal);
      for (const ball of corners) {
        const at = 3 * (first + ball);
        for (let d = 0; d < 3; d++) normals[at + d]! += normal.getComponent(d);
      }
    }
  }
  for (let vertex = SHEETS; vertex < VERTEX_COUNT; vertex++) {
    const ball = (vertex - SHEETS) % BALL_COUNT;
    normal.fromArray(normals, 3 * vertex);
    if (normal.lengthSq() === 0) continue;
    normal.normalize().toArray(normals, 3 * vertex);
    for (let d = 0; d < 3; d++) {
      positions[3 * vertex + d] = centres[3 * ball + d]! + radii[ball]! * normal.getComponent(d);
    }
  }
}

/** The normal of the plane that touches three balls on one side, times the triangle's area. */
function touchingPlane(
  { centres, radii }: Balls,
  [a, b, c]: readonly [number, number, number],
  up: 1 | -1,
  out: Vector3,
): void {
  // n with n·(b − a) = ra − rb and n·(c − a) = ra − rc, |n| = 1
  from.fromArray(centres, 3 * a);
  side.fromArray(centres, 3 * b).sub(from);
  other.fromArray(centres, 3 * c).sub(from);
  axis.crossVectors(side, other);
  const [p, q, r] = [side.lengthSq(), side.dot(other), other.lengthSq()];
  const [u, v] = [radii[a]! - radii[b]!, radii[a]! - radii[c]!];
  const area = p * r - q * q;
  const s = (u * r - v * q) / area;
  const t = (v * p - u * q) / area;
  // where one ball hides the others no plane touches all three: the triangle's own then
  const rest = 1 - (s * s * p + 2 * s * t * q + t * t * r);
  if (rest > 0) {
    out.copy(side).multiplyScalar(s).addScaledVector(other, t);
    out.addScaledVector(axis, up * Math.sqrt(rest / axis.lengthSq()));
    out.multiplyScalar(Math.sqrt(area));
  } else out.copy(axis).multiplyScalar(up);
}

const from = new Vector3();
const axis = new Vector3();
const side = new Vector3();
const other = new Vector3();
const normal = new Vector3();
