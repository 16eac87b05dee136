/**
 * The skin that touches: where a fingertip, which has a size, should be displayed.
 *
 * A tracked fingertip is a point inside the finger, a radius r away from the skin. `centre` warps
 * that point itself. `pad` warps one point of the skin, which stands still in the fingertip's frame.
 * `skin` takes the point of the skin nearest to the prop, p = c − r m, with m the direction out of
 * the prop there, and displays the centre at f(p) + r m′, where m′ ∝ cof(∂f) m is what ∂f makes of
 * the tangent plane's normal: a ball that touches the prop at p is displayed as a ball that touches
 * the virtual surface at f(p). The farther the finger is from the prop, the more `skin` becomes
 * `centre`.
 */

/** m between skin and prop: up to NEAR the skin is displayed, from FAR on the centre. */
const NEAR = 5e-3;
const FAR = 30e-3;
const MELD = 5e-4;

/** The props' surface, for `contact: "skin"`. */
export interface NearestSurface {
  /**
   * Nearest points of the surface, and its outward unit normals there. Points of lost fingers are
   * NaN; what is written for them does not matter, but nothing may be thrown.
   * @param points rows of x, y, z in m, room frame.
   * @param nearest rows, written; m, room frame.
   * @param normals rows, written.
   */
  nearest(points: Float64Array, nearest: Float64Array, normals: Float64Array): void;
}

/** Six points from row `to` on: a step of `width` back and forth along each axis. */
export function writeStencil(points: Float64Array, of: number, width: number, to: number): void {
  for (let n = 0; n < 6; n++) {
    for (let d = 0; d < 3; d++) {
      const step = d === n >> 1 ? (n % 2 ? width : -width) : 0;
      points[3 * (to + n) + d] = points[3 * of + d]! + step;
    }
  }
}

/** J = ∂f/∂x, row by row, by central differences of f at `writeStencil`'s points. */
export function slopeOf(shown: Float64Array, row: number, width: number, J: Float64Array): void {
  for (let d = 0; d < 3; d++) {
    for (let e = 0; e < 3; e++) {
      const back = shown[3 * (row + 2 * e) + d]!;
      const forth = shown[3 * (row + 2 * e + 1) + d]!;
      J[3 * d + e] = (forth - back) / (2 * width);
    }
  }
}

/** Where the skin of each fingertip is nearest to the prop. */
export class TouchPoints {
  /** (5, 3): the way out of the prop. */
  readonly outward = new Float64Array(15);
  /** (5): 1 near the surface, 0 far from it. */
  readonly share = new Float64Array(5);
  private readonly centres = new Float64Array(15);
  private readonly nearest = new Float64Array(15);
  private readonly normals = new Float64Array(15);
  private readonly direction = new Float64Array(3);

  /** Rows 0 … 4 of `points` are the centres; the points of the skin are written from `to` on. */
  find(surface: NearestSurface, radii: Float64Array, points: Float64Array, to: number): void {
    const { centres, nearest, normals, outward, share } = this;
    for (let n = 0; n < 15; n++) {
      centres[n] = points[n]!;
    }
    surface.nearest(centres, nearest, normals);
    for (let n = 0; n < 5; n++) {
      let away = 0;
      let side = 0;
      for (let at = 3 * n; at < 3 * n + 3; at++) {
        const v = centres[at]! - nearest[at]!;
        away += v * v;
        side += v * normals[at]!;
      }
      const sign = side >= 0 ? 1 : -1;
      let length = 0;
      for (let at = 3 * n; at < 3 * n + 3; at++) {
        // at the surface itself the way to it has no direction: the normal takes over
        const v = sign * (centres[at]! - nearest[at]!) + MELD * normals[at]!;
        outward[at] = v;
        length += v * v;
      }
      length = Math.sqrt(length);
      const gap = sign * Math.sqrt(away) - radii[n]!;
      const part = Math.min(Math.max((FAR - gap) / (FAR - NEAR), 0), 1);
      share[n] = part * part * (3 - 2 * part);
      for (let d = 0; d < 3; d++) {
        outward[3 * n + d] = outward[3 * n + d]! / length;
        points[3 * (to + n) + d] = centres[3 * n + d]! - radii[n]! * outward[3 * n + d]!;
      }
    }
  }

  /**
   * Where to display the centre of fingertip n, into `goal`.
   * @param shown f of the points; row n is the centre, row `touch` the point of the skin.
   * @param J ∂f/∂x there, row by row.
   */
  place(
    n: number,
    shown: Float64Array,
    touch: number,
    J: Float64Array,
    radius: number,
    goal: Float64Array,
  ): void {
    const { direction, outward, share } = this;
    let length = 0;
    for (let d = 0; d < 3; d++) {
      const i = 3 * ((d + 1) % 3);
      const j = 3 * ((d + 2) % 3);
      let sum = 0;
      for (let e = 0; e < 3; e++) {
        const g = (e + 1) % 3;
        const h = (e + 2) % 3;
        sum += (J[i + g]! * J[j + h]! - J[i + h]! * J[j + g]!) * outward[3 * n + e]!;
      }
      direction[d] = sum;
      length += sum * sum;
    }
    length = Math.sqrt(length);
    for (let d = 0; d < 3; d++) {
      // where ∂f is singular there is no tangent plane: keep the direction
      const out = length > 1e-9 ? direction[d]! / length : outward[3 * n + d]!;
      const skin = shown[3 * touch + d]! + radius * out;
      const centre = shown[3 * n + d]!;
      goal[3 * n + d] = centre + share[n]! * (skin - centre);
    }
  }
}
