/** Rotations as 9 numbers, row by row, in arrays that are used again. */

/** R = rotation by `angle` about the unit axis at `axis[at…]`. */
export function turnAbout(axis: Float64Array, at: number, angle: number, R: Float64Array): void {
  const c = Math.cos(angle);
  const s = Math.sin(angle);
  const x = axis[at]!;
  const y = axis[at + 1]!;
  const z = axis[at + 2]!;
  const o = 1 - c;
  R[0] = c + o * x * x;
  R[1] = o * x * y - s * z;
  R[2] = o * x * z + s * y;
  R[3] = o * x * y + s * z;
  R[4] = c + o * y * y;
  R[5] = o * y * z - s * x;
  R[6] = o * x * z - s * y;
  R[7] = o * y * z + s * x;
  R[8] = c + o * z * z;
}

/**
 * out = T R, R the rotation by the n-th angle about the n-th of the unit axes a, and moved's n-th
 * three = T a.
 *
 * Row by row, t R = cos t + sin (t × a) + (1 − cos) (t · a) a. out is not T. The angle comes in its
 * array, since a number that is handed over by itself is allocated.
 */
export function turnOn(
  T: Float64Array,
  axis: Float64Array,
  angles: Float64Array,
  n: number,
  out: Float64Array,
  moved: Float64Array,
): void {
  const at = 3 * n;
  const c = Math.cos(angles[n]!);
  const s = Math.sin(angles[n]!);
  const x = axis[at]!;
  const y = axis[at + 1]!;
  const z = axis[at + 2]!;
  for (let d = 0; d < 3; d++) {
    const t0 = T[3 * d]!;
    const t1 = T[3 * d + 1]!;
    const t2 = T[3 * d + 2]!;
    const along = t0 * x + t1 * y + t2 * z;
    const part = (1 - c) * along;
    out[3 * d] = c * t0 + s * (t1 * z - t2 * y) + part * x;
    out[3 * d + 1] = c * t1 + s * (t2 * x - t0 * z) + part * y;
    out[3 * d + 2] = c * t2 + s * (t0 * y - t1 * x) + part * z;
    moved[at + d] = along;
  }
}

const unit = new Float64Array(3);

/** R = rotation by |(x, y, z)| about it. */
export function turnBy(x: number, y: number, z: number, R: Float64Array): void {
  const angle = Math.sqrt(x * x + y * y + z * z);
  if (angle < 1e-12) {
    setIdentity(R);
    return;
  }
  unit[0] = x / angle;
  unit[1] = y / angle;
  unit[2] = z / angle;
  turnAbout(unit, 0, angle, R);
}

export function setIdentity(R: Float64Array): void {
  R.fill(0);
  R[0] = 1;
  R[4] = 1;
  R[8] = 1;
}

/** out = A B; out is neither. */
export function multiply(A: Float64Array, B: Float64Array, out: Float64Array): void {
  for (let i = 0; i < 9; i += 3) {
    const a = A[i]!;
    const b = A[i + 1]!;
    const c = A[i + 2]!;
    out[i] = a * B[0]! + b * B[3]! + c * B[6]!;
    out[i + 1] = a * B[1]! + b * B[4]! + c * B[7]!;
    out[i + 2] = a * B[2]! + b * B[5]! + c * B[8]!;
  }
}

/** out = A Bᵀ; out is neither. */
export function multiplyTransposed(A: Float64Array, B: Float64Array, out: Float64Array): void {
  for (let i = 0; i < 9; i += 3) {
    for (let j = 0; j < 3; j++) {
      out[i + j] = A[i]! * B[3 * j]! + A[i + 1]! * B[3 * j + 1]! + A[i + 2]! * B[3 * j + 2]!;
    }
  }
}

/** out[to…] = R v[at…]. */
export function rotate(
  R: Float64Array,
  v: Float64Array,
  at: number,
  out: Float64Array,
  to: number,
): void {
  const x = v[at]!;
  const y = v[at + 1]!;
  const z = v[at + 2]!;
  out[to] = R[0]! * x + R[1]! * y + R[2]! * z;
  out[to + 1] = R[3]! * x + R[4]! * y + R[5]! * z;
  out[to + 2] = R[6]! * x + R[7]! * y + R[8]! * z;
}

/** The vector θ of a rotation R = exp[θ]×, of an angle below π. */
export function rotationVector(R: Float64Array, out: Float64Array): void {
  const x = R[7]! - R[5]!;
  const y = R[2]! - R[6]!;
  const z = R[3]! - R[1]!;
  const twiceSine = Math.sqrt(x * x + y * y + z * z);
  const angle = Math.atan2(twiceSine, R[0]! + R[4]! + R[8]! - 1);
  const scale = twiceSine < 1e-9 ? 0.5 : angle / twiceSine;
  out[0] = scale * x;
  out[1] = scale * y;
  out[2] = scale * z;
}

const SWEEPS = 20;
const step = new Float64Array(9);
const turned = new Float64Array(9);

/**
 * R = the rotation nearest to J (row by row), by turning on from the identity (Müller et al. 2016).
 *
 * Every sweep is continuous in J, so R is, also where J is singular; only where J mirrors, by more
 * than it stretches elsewhere, is there no one nearest rotation.
 */
export function turnOf(J: Float64Array, R: Float64Array): void {
  setIdentity(R);
  for (let sweep = 0; sweep < SWEEPS; sweep++) {
    let x = 0;
    let y = 0;
    let z = 0;
    let along = 0;
    for (let c = 0; c < 3; c++) {
      x += R[3 + c]! * J[6 + c]! - R[6 + c]! * J[3 + c]!;
      y += R[6 + c]! * J[c]! - R[c]! * J[6 + c]!;
      z += R[c]! * J[3 + c]! - R[3 + c]! * J[c]!;
      along += R[c]! * J[c]! + R[3 + c]! * J[3 + c]! + R[6 + c]! * J[6 + c]!;
    }
    const scale = 1 / (Math.abs(along) + 1e-9);
    x *= scale;
    y *= scale;
    z *= scale;
    if (Math.sqrt(x * x + y * y + z * z) < 1e-12) {
      break;
    }
    turnBy(x, y, z, step);
    multiply(step, R, turned);
    R.set(turned);
  }
}
