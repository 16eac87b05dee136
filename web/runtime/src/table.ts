import type { Bricks } from "./bricks.js";
import { searchInverse } from "./inverse.js";
import { Lookup } from "./lookup.js";
import { addedError } from "./meta.js";
import { checkRigid } from "./rigid.js";
import { RootSearch } from "./roots.js";
import type { Matrix, Points, Warp, WarpMeta } from "./warp.js";

/** The components of u as the three channels. */
export const PLAIN = Float64Array.of(1, 0, 0, 0, 1, 0, 0, 0, 1);

/** A warp that is read from a table of bricks by trilinear interpolation. */
export class TableWarp implements Warp {
  readonly meta: WarpMeta;
  readonly dimension = 3;
  protected readonly lookup: Lookup;
  private search: RootSearch | null = null;

  constructor(bricks: Bricks, meta: WarpMeta, mix: Float64Array = PLAIN) {
    this.meta = meta;
    this.lookup = new Lookup(bricks, mix);
  }

  get levelsLoaded(): number {
    return this.lookup.bricks.levelsLoaded;
  }

  get levelCount(): number {
    return this.lookup.bricks.levelCount;
  }

  get addedErrorMm(): number {
    return addedError(this.meta, this.levelsLoaded, this.levelCount);
  }

  get maxDisplacement(): number {
    return this.roots().reach;
  }

  displayed(points: Points, out: Points): void {
    checkRows(points, out, 3, 3);
    this.lookup.evaluate(points, true, out, null);
  }

  displacement(points: Points, out: Points): void {
    checkRows(points, out, 3, 3);
    this.lookup.evaluate(points, false, out, null);
  }

  jacobian(points: Points, out: Points): void {
    checkRows(points, out, 3, 9);
    this.lookup.evaluate(points, false, null, out);
  }

  /**
   * As told in `Warp`: exhaustive, but for positions under a sliding plane, which are searched from
   * many starts; no real hand can be there.
   */
  inverse(points: Points, out: Points): number {
    checkRows(points, out, 3, 3);
    const roots = this.roots();
    const x = Float64Array.from(points);
    const u = new Float64Array(x.length);
    const table = new Float64Array(x.length);
    this.lookup.evaluate(x, false, u, null);
    this.lookup.toTable(x, table);
    let found = 0;
    for (let n = 0; n < x.length; n += 3) {
      const point = x.subarray(n, n + 3);
      let known =
        Number.isFinite(u[n]!) && Number.isFinite(u[n + 1]!) && Number.isFinite(u[n + 2]!);
      if (known && (u[n] !== 0 || u[n + 1] !== 0 || u[n + 2] !== 0)) {
        if (table[n + 2]! < 0) {
          known = searchInverse(this, point, roots.reach);
        } else {
          const place = table.subarray(n, n + 3);
          known = roots.nearest(place);
          this.lookup.toRoom(place, point);
        }
      }
      for (let d = 0; d < 3; d++) {
        out[n + d] = known ? point[d]! : Number.NaN;
      }
      found += known ? 1 : 0;
    }
    return found;
  }

  place(T_room_scene: Matrix): void {
    checkRigid(T_room_scene, 3);
    this.lookup.setPose(T_room_scene);
  }

  at(T_room_scene: Matrix): TableWarp {
    const moved = new TableWarp(this.lookup.bricks, this.meta, this.lookup.mix);
    moved.place(T_room_scene);
    return moved;
  }

  /** The search for roots in the levels loaded; goals that change make it anew. */
  private roots(): RootSearch {
    if (this.search === null || this.search.levels !== this.levelsLoaded) {
      this.search = new RootSearch(this.lookup.bricks, this.lookup.mix);
    }
    return this.search;
  }

  /** Forget what was worked out from the mix. */
  protected mixChanged(): void {
    this.search = null;
  }
}

/** @throws RangeError where `points` is not rows of d numbers, or `out` is too short. */
export function checkRows(points: Points, out: Points, d: number, perRow: number): void {
  if (points.length % d !== 0) {
    throw new RangeError(
      `Points have ${points.length} numbers; rows of ${d} are needed: metres in the room's frame.`,
    );
  }
  const needed = (points.length / d) * perRow;
  if (out.length < needed) {
    throw new RangeError(`The array to write has ${out.length} numbers; ${needed} are needed.`);
  }
}
