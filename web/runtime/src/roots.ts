/**
 * The nearest real position that a table shows at a point: branch and bound over its bricks.
 *
 * Over a brick f = x + u stays in the hull of its values at the nodes. Bricks whose hull leaves the
 * displayed position out hold no root, nor need bricks farther away than a root already found be
 * opened. What remains are cells, see `CellRoots`. Nothing is left to chance.
 */

import { BRICK, type Bricks, CELLS, LINE, SHEET } from "./bricks.js";
import { CellRoots, distanceToBox, SLACK } from "./cell_roots.js";

const HALF = CELLS / 2;

export class RootSearch {
  /** How many levels of the table it knows. */
  readonly levels: number;
  /** The greatest |u|, m. */
  readonly reach: number;
  private readonly bricks: Bricks;
  /** The three components of u, table axes. */
  private readonly values: Float32Array;
  /** Least and greatest f over each brick, and over each octant that it decides itself. */
  private readonly hull: Float64Array;
  private readonly octantHull: Float64Array;
  private readonly cells = new CellRoots();
  private readonly side = new Float64Array(3);
  private readonly low = new Float64Array(3);
  private readonly query = new Float64Array(3);

  constructor(bricks: Bricks, mix: Float64Array) {
    this.bricks = bricks;
    this.levels = bricks.levelsLoaded;
    const rows = this.levels > 0 ? bricks.rowsOf(this.levels - 1) : 0;
    this.values = components(bricks, mix, rows);
    this.reach = greatest(this.values);
    this.hull = new Float64Array(6 * bricks.slot.length);
    this.octantHull = new Float64Array(48 * bricks.slot.length);
    for (const brick of bricks.root) {
      if (brick >= 0) {
        this.bound(brick);
      }
    }
  }

  /** Write the root nearest to y over y (m, table frame); false, and y untouched, without one. */
  nearest(y: Float64Array): boolean {
    this.query.set(y);
    const { rootShape, width, root } = this.bricks;
    const best = (this.reach * (1 + 1e-9) + 1e-9) ** 2;
    this.cells.begin(this.query, best);
    const span = Math.sqrt(best);
    const candidates: { brick: number; away: number }[] = [];
    const from = [0, 1, 2].map((d) => Math.trunc(Math.max(y[d]! - span, 0) / width[d]!));
    const to = [0, 1, 2].map((d) =>
      Math.min(Math.trunc((y[d]! + span) / width[d]!), rootShape[d]! - 1),
    );
    for (let i = from[0]!; i <= to[0]!; i++) {
      for (let j = from[1]!; j <= to[1]!; j++) {
        for (let k = from[2]!; k <= to[2]!; k++) {
          const brick = root[(i * rootShape[1]! + j) * rootShape[2]! + k]!;
          if (brick >= 0) {
            candidates.push({ brick, away: this.away(i, j, k, 1) });
          }
        }
      }
    }
    candidates.sort((a, b) => a.away - b.away);
    for (const { brick, away } of candidates) {
      if (away < this.cells.best) {
        this.visit(brick);
      }
    }
    if (this.cells.found) {
      y.set(this.cells.root);
    }
    return this.cells.found;
  }

  private visit(brick: number): void {
    if (!this.holds(this.hull, 6 * brick)) {
      return;
    }
    const { child, level, position } = this.bricks;
    const part = 0.5 ** (level[brick]! + 1);
    const octants = [0, 1, 2, 3, 4, 5, 6, 7].map((octant) => ({
      octant,
      away: this.away(
        2 * position[3 * brick]! + (octant >> 2),
        2 * position[3 * brick + 1]! + ((octant >> 1) & 1),
        2 * position[3 * brick + 2]! + (octant & 1),
        part,
      ),
    }));
    octants.sort((a, b) => a.away - b.away);
    for (const { octant, away } of octants) {
      if (away >= this.cells.best) {
        return;
      }
      const deeper = child[8 * brick + octant]!;
      if (deeper >= 0) {
        this.visit(deeper);
      } else if (this.holds(this.octantHull, 48 * brick + 6 * octant)) {
        this.visitCells(brick, octant);
      }
    }
  }

  private visitCells(brick: number, octant: number): void {
    const { level, position, width, slot } = this.bricks;
    const { side, low, query } = this;
    for (let d = 0; d < 3; d++) {
      side[d] = (0.5 ** level[brick]! * width[d]!) / CELLS;
    }
    const a0 = HALF * (octant >> 2);
    const b0 = HALF * ((octant >> 1) & 1);
    const c0 = HALF * (octant & 1);
    for (let a = a0; a < a0 + HALF; a++) {
      for (let b = b0; b < b0 + HALF; b++) {
        for (let c = c0; c < c0 + HALF; c++) {
          low[0] = (position[3 * brick]! * CELLS + a) * side[0]!;
          low[1] = (position[3 * brick + 1]! * CELLS + b) * side[1]!;
          low[2] = (position[3 * brick + 2]! * CELLS + c) * side[2]!;
          if (distanceToBox(query, low, side) < this.cells.best) {
            const at = slot[brick]! * BRICK + a * SHEET + b * LINE + c;
            this.cells.search(this.values, 3 * at, low, side);
          }
        }
      }
    }
  }

  /** Squared distance from the query to a box: place and part of a root brick's width. */
  private away(i: number, j: number, k: number, part: number): number {
    const { side, low } = this;
    const { width } = this.bricks;
    side.set([part * width[0]!, part * width[1]!, part * width[2]!]);
    low.set([i * side[0]!, j * side[1]!, k * side[2]!]);
    return distanceToBox(this.query, low, side);
  }

  private holds(hulls: Float64Array, at: number): boolean {
    const y = this.query;
    for (let d = 0; d < 3; d++) {
      if (y[d]! < hulls[at + d]! || y[d]! > hulls[at + 3 + d]!) {
        return false;
      }
    }
    return true;
  }

  /** Bounds of f over a brick, after those of its children. */
  private bound(brick: number): void {
    const { child, level, position, width, slot } = this.bricks;
    const { hull, octantHull, values } = this;
    const at = 6 * brick;
    hull.fill(Number.POSITIVE_INFINITY, at, at + 3).fill(Number.NEGATIVE_INFINITY, at + 3, at + 6);
    const scale = 0.5 ** level[brick]! / CELLS;
    for (let octant = 0; octant < 8; octant++) {
      const deeper = child[8 * brick + octant]!;
      const to = 48 * brick + 6 * octant;
      if (deeper >= 0) {
        this.bound(deeper);
        octantHull.set(hull.subarray(6 * deeper, 6 * deeper + 6), to);
      } else if (slot[brick]! >= 0) {
        for (let d = 0; d < 3; d++) {
          let least = Number.POSITIVE_INFINITY;
          let most = Number.NEGATIVE_INFINITY;
          for (let n = 0; n < 125; n++) {
            const i = HALF * (octant >> 2) + Math.trunc(n / 25);
            const j = HALF * ((octant >> 1) & 1) + (Math.trunc(n / 5) % 5);
            const k = HALF * (octant & 1) + (n % 5);
            const step = d === 0 ? i : d === 1 ? j : k;
            const x = (position[3 * brick + d]! * CELLS + step) * scale * width[d]!;
            const f = x + values[3 * (slot[brick]! * BRICK + i * SHEET + j * LINE + k) + d]!;
            least = Math.min(least, f);
            most = Math.max(most, f);
          }
          octantHull[to + d] = least - SLACK;
          octantHull[to + 3 + d] = most + SLACK;
        }
      } else {
        // its children are on their way: nothing is known there
        octantHull.fill(Number.POSITIVE_INFINITY, to, to + 3);
        octantHull.fill(Number.NEGATIVE_INFINITY, to + 3, to + 6);
      }
      for (let d = 0; d < 3; d++) {
        hull[at + d] = Math.min(hull[at + d]!, octantHull[to + d]!);
        hull[at + 3 + d] = Math.max(hull[at + 3 + d]!, octantHull[to + 3 + d]!);
      }
    }
  }
}

/** The channels summed up to the three components of u; the table itself where it has them. */
function components(bricks: Bricks, mix: Float64Array, rows: number): Float32Array {
  const { values, channels } = bricks;
  const nodes = rows * BRICK;
  const plain = channels === 3 && mix.every((value, n) => value === (n % 4 === 0 ? 1 : 0));
  if (plain) {
    return values.subarray(0, 3 * nodes);
  }
  const out = new Float32Array(3 * nodes);
  for (let n = 0; n < nodes; n++) {
    let [a, b, c] = [0, 0, 0];
    for (let m = 0; m < channels; m++) {
      const v = values[n * channels + m]!;
      a += v * mix[3 * m]!;
      b += v * mix[3 * m + 1]!;
      c += v * mix[3 * m + 2]!;
    }
    out[3 * n] = a;
    out[3 * n + 1] = b;
    out[3 * n + 2] = c;
  }
  return out;
}

function greatest(values: Float32Array): number {
  let most = 0;
  for (let n = 0; n + 2 < values.length; n += 3) {
    most = Math.max(most, values[n]! ** 2 + values[n + 1]! ** 2 + values[n + 2]! ** 2);
  }
  return Math.sqrt(most);
}
