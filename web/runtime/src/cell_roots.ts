/**
 * The root of f(x) = y in one cell of a table that is nearest to y.
 *
 * In a cell f = x + u is trilinear, so over any box in it f stays in the hull of its values at the
 * box's corners. A box is halved until its hull leaves y out or f is provably one-to-one in it:
 * |I − J₀⁻¹J| ≤ ½ at the corners bounds it inside, as J is multi-affine. There a contraction that
 * never leaves the box finds the root, or stops where there is none.
 */

import { LINE, SHEET } from "./bricks.js";

/** m, by which hulls are widened against rounding. */
export const SLACK = 1e-12;

/** A part of a cell that has been halved so often is not halved again. */
const SMALLEST = 2 ** -12;
const MOST_PARTS = 4096;
const ACCEPT = 1e-10;

/** Squared distance from y to a box. */
export function distanceToBox(y: Float64Array, low: Float64Array, side: Float64Array): number {
  let sum = 0;
  for (let d = 0; d < 3; d++) {
    const away = Math.max(low[d]! - y[d]!, 0, y[d]! - low[d]! - side[d]!);
    sum += away * away;
  }
  return sum;
}

/** Searches one cell after another, and keeps the nearest root. */
export class CellRoots {
  /** Squared distance of the nearest root, or of how far roots are looked for. */
  best = 0;
  found = false;
  /** m, table frame. */
  readonly root = new Float64Array(3);
  private y: Float64Array = new Float64Array(3);
  private low: Float64Array = new Float64Array(3);
  private side: Float64Array = new Float64Array(3);
  private parts = 0;
  /** f − y at the cell's corners. */
  private readonly corner = new Float64Array(24);
  private readonly g = new Float64Array(3);
  private readonly J = new Float64Array(9);
  private readonly K = new Float64Array(9);
  private readonly place = new Float64Array(3);

  /** A new search: y in m, table frame; roots farther than √best are not wanted. */
  begin(y: Float64Array, best: number): void {
    this.y = y;
    this.best = best;
    this.found = false;
  }

  /** A cell by its lowest corner and sides; `at` is where its lowest node is in `values`. */
  search(values: Float32Array, at: number, low: Float64Array, side: Float64Array): void {
    this.low = low;
    this.side = side;
    for (let d = 0; d < 3; d++) {
      let least = Number.POSITIVE_INFINITY;
      let most = Number.NEGATIVE_INFINITY;
      for (let n = 0; n < 8; n++) {
        const node = (n >> 2) * SHEET + ((n >> 1) & 1) * LINE + (n & 1);
        const step = (n >> (2 - d)) & 1;
        const v = low[d]! + step * side[d]! - this.y[d]! + values[at + 3 * node + d]!;
        this.corner[3 * n + d] = v;
        least = Math.min(least, v);
        most = Math.max(most, v);
      }
      if (least > SLACK || most < -SLACK) {
        return;
      }
    }
    this.parts = 0;
    this.searchPart(0, 0, 0, 1);
  }

  private searchPart(a: number, b: number, c: number, size: number): void {
    this.parts++;
    if (this.parts > MOST_PARTS || this.partDistance(a, b, c, size) >= this.best) {
      return;
    }
    if (!this.hullHolds(a, b, c, size)) {
      return;
    }
    const middle = 0.5 * size;
    this.setSlope(a + middle, b + middle, c + middle);
    const single = this.invert() && this.departure(a, b, c, size) <= 0.5;
    if (single || size <= SMALLEST) {
      if (this.settle(a, b, c, size, !single)) {
        this.keep();
      }
      return;
    }
    for (let n = 7; n >= 0; n--) {
      this.searchPart(
        a + middle * (n >> 2),
        b + middle * ((n >> 1) & 1),
        c + middle * (n & 1),
        middle,
      );
    }
  }

  private partDistance(a: number, b: number, c: number, size: number): number {
    let sum = 0;
    for (let d = 0; d < 3; d++) {
      const from = this.low[d]! + (d === 0 ? a : d === 1 ? b : c) * this.side[d]!;
      const away = Math.max(from - this.y[d]!, 0, this.y[d]! - from - size * this.side[d]!);
      sum += away * away;
    }
    return sum;
  }

  private hullHolds(a: number, b: number, c: number, size: number): boolean {
    const least = [Number.POSITIVE_INFINITY, Number.POSITIVE_INFINITY, Number.POSITIVE_INFINITY];
    const most = [Number.NEGATIVE_INFINITY, Number.NEGATIVE_INFINITY, Number.NEGATIVE_INFINITY];
    for (let n = 0; n < 8; n++) {
      this.setValue(a + size * (n >> 2), b + size * ((n >> 1) & 1), c + size * (n & 1));
      for (let d = 0; d < 3; d++) {
        least[d] = Math.min(least[d]!, this.g[d]!);
        most[d] = Math.max(most[d]!, this.g[d]!);
      }
    }
    return Math.max(...least) <= SLACK && Math.min(...most) >= -SLACK;
  }

  /** The greatest row sum of |I − K J| over the corners of a part. */
  private departure(a: number, b: number, c: number, size: number): number {
    const { J, K } = this;
    let most = 0;
    for (let n = 0; n < 8; n++) {
      this.setSlope(a + size * (n >> 2), b + size * ((n >> 1) & 1), c + size * (n & 1));
      for (let d = 0; d < 3; d++) {
        let total = 0;
        for (let e = 0; e < 3; e++) {
          const entry = K[3 * d]! * J[e]! + K[3 * d + 1]! * J[3 + e]! + K[3 * d + 2]! * J[6 + e]!;
          total += Math.abs((d === e ? 1 : 0) - entry);
        }
        most = Math.max(most, total);
      }
    }
    return most;
  }

  /** Iterate to the root in a part, never leaving it; by Newton where K need not be near. */
  private settle(a: number, b: number, c: number, size: number, newton: boolean): boolean {
    const { place, g, K } = this;
    place[0] = a + 0.5 * size;
    place[1] = b + 0.5 * size;
    place[2] = c + 0.5 * size;
    for (let step = 0; step < 60; step++) {
      this.setValue(place[0], place[1], place[2]);
      if (newton || step % 4 === 3) {
        this.setSlope(place[0], place[1], place[2]);
        if (!this.invert()) {
          break;
        }
      }
      let moved = 0;
      for (let d = 0; d < 3; d++) {
        const from = d === 0 ? a : d === 1 ? b : c;
        const next =
          place[d]! - (K[3 * d]! * g[0]! + K[3 * d + 1]! * g[1]! + K[3 * d + 2]! * g[2]!);
        const held = Math.min(Math.max(next, from), from + size);
        moved = Math.max(moved, Math.abs(held - place[d]!));
        place[d] = held;
      }
      if (moved < 1e-14) {
        break;
      }
    }
    this.setValue(place[0], place[1], place[2]);
    return Math.max(Math.abs(g[0]!), Math.abs(g[1]!), Math.abs(g[2]!)) < ACCEPT;
  }

  private keep(): void {
    let distance = 0;
    for (let d = 0; d < 3; d++) {
      distance += (this.low[d]! + this.place[d]! * this.side[d]! - this.y[d]!) ** 2;
    }
    if (distance < this.best) {
      this.best = distance;
      this.found = true;
      for (let d = 0; d < 3; d++) {
        this.root[d] = this.low[d]! + this.place[d]! * this.side[d]!;
      }
    }
  }

  /** g = f − y at a place in the cell. */
  private setValue(a: number, b: number, c: number): void {
    const v = this.corner;
    for (let d = 0; d < 3; d++) {
      const e00 = v[d]! * (1 - c) + v[3 + d]! * c;
      const e01 = v[6 + d]! * (1 - c) + v[9 + d]! * c;
      const e10 = v[12 + d]! * (1 - c) + v[15 + d]! * c;
      const e11 = v[18 + d]! * (1 - c) + v[21 + d]! * c;
      this.g[d] = (1 - a) * ((1 - b) * e00 + b * e01) + a * ((1 - b) * e10 + b * e11);
    }
  }

  /** J = ∂g/∂(place in the cell), row by row. */
  private setSlope(a: number, b: number, c: number): void {
    const { corner: v, J } = this;
    for (let d = 0; d < 3; d++) {
      const [v0, v1, v2, v3] = [v[d]!, v[3 + d]!, v[6 + d]!, v[9 + d]!];
      const [v4, v5, v6, v7] = [v[12 + d]!, v[15 + d]!, v[18 + d]!, v[21 + d]!];
      const e00 = v0 * (1 - c) + v1 * c;
      const e01 = v2 * (1 - c) + v3 * c;
      const e10 = v4 * (1 - c) + v5 * c;
      const e11 = v6 * (1 - c) + v7 * c;
      J[3 * d] = (1 - b) * (e10 - e00) + b * (e11 - e01);
      J[3 * d + 1] = (1 - a) * (e01 - e00) + a * (e11 - e10);
      J[3 * d + 2] =
        (1 - a) * ((1 - b) * (v1 - v0) + b * (v3 - v2)) + a * ((1 - b) * (v5 - v4) + b * (v7 - v6));
    }
  }

  /** K = J⁻¹; false where J is all but singular. */
  private invert(): boolean {
    const { J, K } = this;
    const [a, b, c, d, e, f, g, h, i] = J as unknown as [
      number,
      number,
      number,
      number,
      number,
      number,
      number,
      number,
      number,
    ];
    K[0] = e * i - f * h;
    K[1] = c * h - b * i;
    K[2] = b * f - c * e;
    K[3] = f * g - d * i;
    K[4] = a * i - c * g;
    K[5] = c * d - a * f;
    K[6] = d * h - e * g;
    K[7] = b * g - a * h;
    K[8] = a * e - b * d;
    const determinant = a * K[0] + b * K[3] + c * K[6];
    let size = 0;
    for (let n = 0; n < 9; n++) {
      size = Math.max(size, Math.abs(J[n]!));
    }
    if (!(Math.abs(determinant) > 1e-12 * size ** 3)) {
      return false;
    }
    for (let n = 0; n < 9; n++) {
      K[n] = K[n]! / determinant;
    }
    return true;
  }
}
