/** Where a person's finger pad is: calibrated from touches of a prop whose surface is known. */

import { solveSymmetric } from "../inverse.js";
import type { NearestSurface } from "./contact.js";
import { TIP_RADIUS } from "./skeleton.js";

/** m: by how much pads differ from finger to finger, as known beforehand. */
const SPREAD = 3e-3;
/** m: tracking noise of a touch; touches farther off count less (Huber's weights, 2 of these). */
const NOISE = 1e-3;
const ROUNDS = 20;

export interface Pad {
  /** (3) m from the fingertip's centre to the pad, in the tip's frame. */
  readonly offset: Float64Array;
  /** m, root mean square of the touches' distances from the surface. */
  readonly residual: number;
}

/**
 * The point of the fingertip's frame that lay on the surface at each touch.
 *
 * What touches do not tell, as the way along a plane that was always touched alike, stays as in a
 * finger whose pad is `radius` out of the palm's side.
 * @param poses n × 16 numbers, the fingertip's pose at each touch, column-major.
 * @throws RangeError there are no touches, or their numbers are not finite.
 */
export function calibratePad(
  poses: Float32Array | Float64Array,
  surface: NearestSurface,
  radius = TIP_RADIUS,
): Pad {
  const count = poses.length / 16;
  if (!Number.isInteger(count) || count === 0) {
    throw new RangeError(`The touches have ${poses.length} numbers; 16 for each are needed.`);
  }
  if (!poses.every(Number.isFinite)) {
    throw new RangeError("A touch has NaN or infinite entries; leave out lost ones.");
  }
  const usual = [0, -radius, 0];
  const offset = Float64Array.from(usual);
  const slopes = new Float64Array(3 * count);
  const away = new Float64Array(count);
  const points = new Float64Array(3 * count);
  const nearest = new Float64Array(3 * count);
  const normals = new Float64Array(3 * count);
  const measure = (): void => {
    for (let n = 0; n < count; n++) {
      for (let d = 0; d < 3; d++) {
        let sum = poses[16 * n + 12 + d]!;
        for (let e = 0; e < 3; e++) {
          sum += poses[16 * n + 4 * e + d]! * offset[e]!;
        }
        points[3 * n + d] = sum;
      }
    }
    surface.nearest(points, nearest, normals);
    for (let n = 0; n < count; n++) {
      away[n] = 0;
      for (let e = 0; e < 3; e++) {
        const at = 3 * n + e;
        away[n] = away[n]! + (points[at]! - nearest[at]!) * normals[at]!;
        slopes[at] = 0;
        for (let d = 0; d < 3; d++) {
          slopes[at] = slopes[at]! + poses[16 * n + 4 * e + d]! * normals[3 * n + d]!;
        }
      }
    }
  };
  for (let round = 0; round < ROUNDS; round++) {
    measure();
    const normal = Float64Array.of(1, 0, 0, 0, 1, 0, 0, 0, 1).map((one) => one / SPREAD ** 2);
    const pull = offset.map((value, d) => (value - usual[d]!) / SPREAD ** 2);
    for (let n = 0; n < count; n++) {
      const weight = Math.min(1, (2 * NOISE) / Math.max(Math.abs(away[n]!), 1e-12)) / NOISE ** 2;
      for (let d = 0; d < 3; d++) {
        const slope = weight * slopes[3 * n + d]!;
        pull[d] = pull[d]! + slope * away[n]!;
        for (let e = 0; e < 3; e++) {
          normal[3 * d + e] = normal[3 * d + e]! + slope * slopes[3 * n + e]!;
        }
      }
    }
    solveSymmetric(normal, pull, 3);
    for (let d = 0; d < 3; d++) {
      offset[d] = offset[d]! - pull[d]!;
    }
  }
  measure();
  const squares = away.reduce((sum, value) => sum + value * value, 0);
  return { offset, residual: Math.sqrt(squares / count) };
}
