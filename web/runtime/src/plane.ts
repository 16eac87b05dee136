import { searchInverse } from "./inverse.js";
import { checkRigid } from "./rigid.js";
import { checkRows } from "./table.js";
import type { Matrix, Points, Warp, WarpMeta } from "./warp.js";

/** The numbers of a plane table: u at the crossings of lines; see docs/warp-file.md. */
export interface PlaneTable {
  /** Column-major, 3 × 3. */
  readonly T_scene_table: Float64Array;
  /** m, ascending, table frame. */
  readonly xLines: Float64Array;
  readonly yLines: Float64Array;
  /** (nx, ny, 2) m, table axes. */
  readonly values: Float32Array;
  /** Segments of the outer polygon, 4 numbers each, table frame; none where ∂Ω1 is the box. */
  readonly outer: Float64Array;
  readonly mirrorDepth: number | null;
}

/** A warp of the plane: bilinear between the lines of a table. */
export class PlaneWarp implements Warp {
  readonly meta: WarpMeta;
  readonly dimension = 2;
  readonly levelsLoaded = 1;
  readonly levelCount = 1;
  readonly maxDisplacement: number;
  private readonly table: PlaneTable;
  private readonly polygon: Polygon | null;
  /** Rotation table to room (4, row by row), origin (2). */
  private readonly frame = new Float64Array(6);
  /** u (2), then ∂u/∂x (4, row by row), of the last look-up, table axes. */
  private readonly here = new Float64Array(6);

  /** @throws Error where lines do not ascend or a number is not finite. */
  constructor(table: PlaneTable, meta: WarpMeta) {
    for (const [name, lines] of [
      ["x_lines", table.xLines],
      ["y_lines", table.yLines],
    ] as const) {
      if (lines.length < 2 || !lines.every((line, n) => n === 0 || line > lines[n - 1]!)) {
        throw new Error(`The plane table's array '${name}' does not ascend.`);
      }
    }
    let most = 0;
    for (let n = 0; n < table.values.length; n += 2) {
      most = Math.max(most, Math.hypot(table.values[n]!, table.values[n + 1]!));
      if (!Number.isFinite(table.values[n]! + table.values[n + 1]!)) {
        throw new Error("The plane table's array 'values' has NaN or infinite numbers.");
      }
    }
    this.table = table;
    this.meta = meta;
    this.maxDisplacement = most;
    this.polygon = table.outer.length > 0 ? new Polygon(table.outer, table.yLines) : null;
    this.place(Float64Array.of(1, 0, 0, 0, 1, 0, 0, 0, 1));
  }

  get addedErrorMm(): number {
    return this.meta.storageErrorMm;
  }

  displayed(points: Points, out: Points): void {
    checkRows(points, out, 2, 2);
    this.evaluate(points, true, out, null);
  }

  displacement(points: Points, out: Points): void {
    checkRows(points, out, 2, 2);
    this.evaluate(points, false, out, null);
  }

  jacobian(points: Points, out: Points): void {
    checkRows(points, out, 2, 4);
    this.evaluate(points, false, null, out);
  }

  inverse(points: Points, out: Points): number {
    checkRows(points, out, 2, 2);
    const x = Float64Array.from(points);
    const u = new Float64Array(x.length);
    this.evaluate(x, false, u, null);
    let found = 0;
    for (let n = 0; n < x.length; n += 2) {
      let known = Number.isFinite(u[n]!) && Number.isFinite(u[n + 1]!);
      if (known && (u[n] !== 0 || u[n + 1] !== 0)) {
        known = searchInverse(this, x.subarray(n, n + 2), this.maxDisplacement);
      }
      out[n] = known ? x[n]! : Number.NaN;
      out[n + 1] = known ? x[n + 1]! : Number.NaN;
      found += known ? 1 : 0;
    }
    return found;
  }

  place(T_room_scene: Matrix): void {
    checkRigid(T_room_scene, 2);
    const T = T_room_scene;
    const table = this.table.T_scene_table;
    for (let i = 0; i < 2; i++) {
      for (let j = 0; j < 3; j++) {
        const moved = T[i]! * table[3 * j]! + T[3 + i]! * table[3 * j + 1]!;
        this.frame[j === 2 ? 4 + i : 2 * i + j] = moved + (j === 2 ? T[6 + i]! : 0);
      }
    }
  }

  at(T_room_scene: Matrix): PlaneWarp {
    const moved = new PlaneWarp(this.table, this.meta);
    moved.place(T_room_scene);
    return moved;
  }

  private evaluate(x: Points, displayed: boolean, out: Points | null, slopes: Points | null): void {
    const { frame: R, here } = this;
    for (let n = 0; n + 1 < x.length; n += 2) {
      const px = x[n]!;
      const py = x[n + 1]!;
      const dx = px - R[4]!;
      const dy = py - R[5]!;
      this.lookUp(R[0]! * dx + R[2]! * dy, R[1]! * dx + R[3]! * dy);
      if (slopes) {
        for (let i = 0; i < 2; i++) {
          for (let j = 0; j < 2; j++) {
            let sum = i === j ? 1 : 0;
            for (let g = 0; g < 2; g++) {
              for (let h = 0; h < 2; h++) {
                sum += R[2 * i + g]! * here[2 + 2 * g + h]! * R[2 * j + h]!;
              }
            }
            slopes[2 * n + 2 * j + i] = sum;
          }
        }
      }
      if (out) {
        out[n] = R[0]! * here[0]! + R[1]! * here[1]! + (displayed ? px : 0);
        out[n + 1] = R[2]! * here[0]! + R[3]! * here[1]! + (displayed ? py : 0);
      }
    }
  }

  /** u and its slope into `here`, at a place in the table frame. */
  private lookUp(a: number, b: number): void {
    const { here } = this;
    const depth = this.table.mirrorDepth;
    const under = depth !== null && b < 0;
    this.interpolate(a, under ? -b : b);
    if (depth === null || !under) {
      return;
    }
    let fade = Math.max(1 + b / depth, 0);
    if (this.polygon && !this.polygon.encloses(a, b)) {
      fade = 0;
    }
    here[1] = -here[1]!;
    here[2] = here[2]! * fade;
    here[3] = -here[3]! * fade;
    here[4] = -here[4]! * fade;
    here[5] = here[5]! * fade;
    if (fade > 0) {
      here[3] = here[3]! + here[0]! / depth;
      here[5] = here[5]! + here[1]! / depth;
    }
    here[0] = here[0]! * fade;
    here[1] = here[1]! * fade;
  }

  private interpolate(a: number, b: number): void {
    const { xLines, yLines, values } = this.table;
    const { here } = this;
    if (Number.isNaN(a) || Number.isNaN(b)) {
      here.fill(Number.NaN);
      return;
    }
    here.fill(0);
    const inside = a >= xLines[0]! && a <= xLines.at(-1)! && b >= yLines[0]! && b <= yLines.at(-1)!;
    if (!inside || (this.polygon && !this.polygon.encloses(a, b))) {
      return;
    }
    const i = lineBelow(xLines, a);
    const j = lineBelow(yLines, b);
    const h = xLines[i + 1]! - xLines[i]!;
    const k = yLines[j + 1]! - yLines[j]!;
    const s = (a - xLines[i]!) / h;
    const t = (b - yLines[j]!) / k;
    const ny = yLines.length;
    for (let d = 0; d < 2; d++) {
      const lowLow = values[2 * (i * ny + j) + d]!;
      const lowHigh = values[2 * (i * ny + j + 1) + d]!;
      const highLow = values[2 * ((i + 1) * ny + j) + d]!;
      const highHigh = values[2 * ((i + 1) * ny + j + 1) + d]!;
      here[d] = (1 - s) * ((1 - t) * lowLow + t * lowHigh) + s * ((1 - t) * highLow + t * highHigh);
      here[2 + 2 * d] = ((1 - t) * (highLow - lowLow) + t * (highHigh - lowHigh)) / h;
      here[3 + 2 * d] = ((1 - s) * (lowHigh - lowLow) + s * (highHigh - highLow)) / k;
    }
  }
}

/** The last line at or below a coordinate that lies between the first and the last. */
function lineBelow(lines: Float64Array, at: number): number {
  let low = 0;
  let high = lines.length - 1;
  while (high - low > 1) {
    const middle = (low + high) >> 1;
    if (lines[middle]! <= at) {
      low = middle;
    } else {
      high = middle;
    }
  }
  return low;
}

/** Whether closed curves enclose a point, by the crossings of a ray; segments sorted into strips. */
class Polygon {
  private readonly strips: number[][];

  constructor(
    private readonly segments: Float64Array,
    private readonly yLines: Float64Array,
  ) {
    this.strips = Array.from({ length: yLines.length + 1 }, () => []);
    for (let n = 0; n < segments.length; n += 4) {
      const low = this.stripOf(Math.min(segments[n + 1]!, segments[n + 3]!));
      const high = this.stripOf(Math.max(segments[n + 1]!, segments[n + 3]!));
      for (let strip = low; strip <= high; strip++) {
        this.strips[strip]!.push(n);
      }
    }
  }

  encloses(x: number, y: number): boolean {
    const s = this.segments;
    let odd = false;
    for (const n of this.strips[this.stripOf(y)]!) {
      const [ax, ay, bx, by] = [s[n]!, s[n + 1]!, s[n + 2]!, s[n + 3]!];
      if (ay <= y !== by <= y && x < ax + ((y - ay) * (bx - ax)) / (by - ay)) {
        odd = !odd;
      }
    }
    return odd;
  }

  /** 0 below the first line, yLines.length from the last one on. */
  private stripOf(y: number): number {
    const lines = this.yLines;
    if (y < lines[0]!) {
      return 0;
    }
    return y >= lines.at(-1)! ? lines.length : lineBelow(lines, y) + 1;
  }
}
