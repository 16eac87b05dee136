import { BRICK, type Bricks, CELLS, LINE, SHEET } from "./bricks.js";
import type { Matrix, Points } from "./warp.js";

/**
 * Reads a table of bricks at points, in double precision.
 *
 * The same arithmetic as the Python library's, in the same order. Under a sliding plane u is that of
 * the mirrored point, its normal component turned, faded out with depth.
 */
export class Lookup {
  readonly bricks: Bricks;
  /** u in table axes is the row of channels times this, (C, 3) row by row. */
  readonly mix: Float64Array;
  /** Rotation table to room (9, row by row), origin (3), root brick's sides (3), mirror depth. */
  private readonly frame = new Float64Array(16);
  private readonly place = new Float64Array(3);
  /** u in table axes, and how much of it is left with depth under a sliding plane. */
  private readonly shift = new Float64Array(4);
  private readonly slope = new Float64Array(9);
  private readonly turned = new Float64Array(9);
  private brick = -1;
  private level = 0;

  constructor(bricks: Bricks, mix: Float64Array) {
    this.bricks = bricks;
    this.mix = mix;
    this.frame.set(bricks.width, 12);
    this.frame[15] = bricks.mirrorDepth;
    this.setPose(IDENTITY);
  }

  /** T takes the scene as the file has it to the room; rigid, column-major, trusted. */
  setPose(T: Matrix): void {
    const table = this.bricks.T_scene_table;
    for (let i = 0; i < 3; i++) {
      for (let j = 0; j < 4; j++) {
        let sum = j === 3 ? T[12 + i]! : 0;
        for (let e = 0; e < 3; e++) {
          sum += T[4 * e + i]! * table[4 * j + e]!;
        }
        this.frame[j === 3 ? 9 + i : 3 * i + j] = sum;
      }
    }
  }

  /** Points of the room to the table frame, or back. */
  toTable(x: Points, out: Float64Array): void {
    const R = this.frame;
    for (let n = 0; n + 2 < x.length; n += 3) {
      const [dx, dy, dz] = [x[n]! - R[9]!, x[n + 1]! - R[10]!, x[n + 2]! - R[11]!];
      for (let d = 0; d < 3; d++) {
        out[n + d] = R[d]! * dx + R[3 + d]! * dy + R[6 + d]! * dz;
      }
    }
  }

  toRoom(p: Float64Array, out: Points): void {
    const R = this.frame;
    for (let n = 0; n + 2 < p.length; n += 3) {
      const [a, b, c] = [p[n]!, p[n + 1]!, p[n + 2]!];
      for (let d = 0; d < 3; d++) {
        out[n + d] = R[3 * d]! * a + R[3 * d + 1]! * b + R[3 * d + 2]! * c + R[9 + d]!;
      }
    }
  }

  /**
   * u, or f where `displayed`, of each row.
   * @param slopes where given, ∂f/∂x too: 9 numbers a row, column-major.
   */
  evaluate(x: Points, displayed: boolean, out: Points | null, slopes: Points | null): void {
    const { slot, values, channels } = this.bricks;
    const { frame: R, mix, place, shift, slope } = this;
    const depth = R[15]!;
    const line = LINE * channels;
    const sheet = SHEET * channels;
    for (let n = 0; n + 2 < x.length; n += 3) {
      const px = x[n]!;
      const py = x[n + 1]!;
      const pz = x[n + 2]!;
      const dx = px - R[9]!;
      const dy = py - R[10]!;
      const dz = pz - R[11]!;
      const tx = R[0]! * dx + R[3]! * dy + R[6]! * dz;
      const ty = R[1]! * dx + R[4]! * dy + R[7]! * dz;
      let tz = R[2]! * dx + R[5]! * dy + R[8]! * dz;
      let fade = 1;
      let turn = 1;
      if (tz < 0 && -tz < depth) {
        tz = -tz;
        fade = 1 - tz / depth;
        turn = -1;
      }
      place[0] = tx;
      place[1] = ty;
      place[2] = tz;
      this.locate();
      let u0 = 0;
      let u1 = 0;
      let u2 = 0;
      const row = this.brick < 0 ? -1 : slot[this.brick]!;
      if (row >= 0) {
        let a = place[0]! * CELLS;
        let b = place[1]! * CELLS;
        let c = place[2]! * CELLS;
        const i = Math.min(Math.trunc(a), CELLS - 1);
        const j = Math.min(Math.trunc(b), CELLS - 1);
        const k = Math.min(Math.trunc(c), CELLS - 1);
        a -= i;
        b -= j;
        c -= k;
        const o = 1 - c;
        const base = (row * BRICK + i * SHEET + j * LINE + k) * channels;
        const w00 = (1 - a) * (1 - b);
        const w01 = (1 - a) * b;
        const w10 = a * (1 - b);
        const w11 = a * b;
        if (slopes) {
          slope.fill(0);
        }
        for (let m = 0; m < channels; m++) {
          const at = base + m;
          const v000 = values[at]!;
          const v001 = values[at + channels]!;
          const v010 = values[at + line]!;
          const v011 = values[at + line + channels]!;
          const v100 = values[at + sheet]!;
          const v101 = values[at + sheet + channels]!;
          const v110 = values[at + sheet + line]!;
          const v111 = values[at + sheet + line + channels]!;
          const e00 = v000 * o + v001 * c;
          const e01 = v010 * o + v011 * c;
          const e10 = v100 * o + v101 * c;
          const e11 = v110 * o + v111 * c;
          const v = w00 * e00 + w01 * e01 + w10 * e10 + w11 * e11;
          u0 += v * mix[3 * m]!;
          u1 += v * mix[3 * m + 1]!;
          u2 += v * mix[3 * m + 2]!;
          if (slopes) {
            const sx = (1 - b) * (e10 - e00) + b * (e11 - e01);
            const sy = (1 - a) * (e01 - e00) + a * (e11 - e10);
            const sz =
              w00 * (v001 - v000) +
              w01 * (v011 - v010) +
              (w10 * (v101 - v100) + w11 * (v111 - v110));
            for (let d = 0; d < 3; d++) {
              slope[3 * d] = slope[3 * d]! + sx * mix[3 * m + d]!;
              slope[3 * d + 1] = slope[3 * d + 1]! + sy * mix[3 * m + d]!;
              slope[3 * d + 2] = slope[3 * d + 2]! + sz * mix[3 * m + d]!;
            }
          }
        }
        u2 *= turn;
      }
      // a brick that leaves all to its children has no values while they are on their way
      const lost = Number.isNaN(px) || Number.isNaN(py) || Number.isNaN(pz);
      const unknown = lost || (this.brick >= 0 && row < 0);
      if (slopes) {
        shift[0] = u0;
        shift[1] = u1;
        shift[2] = u2;
        shift[3] = fade;
        this.writeSlope(slopes, 3 * n, row >= 0, turn);
        if (unknown) {
          slopes.fill(Number.NaN, 3 * n, 3 * n + 9);
        }
      }
      if (out) {
        u0 *= fade;
        u1 *= fade;
        u2 *= fade;
        out[n] = R[0]! * u0 + R[1]! * u1 + R[2]! * u2 + (displayed ? px : 0);
        out[n + 1] = R[3]! * u0 + R[4]! * u1 + R[5]! * u2 + (displayed ? py : 0);
        out[n + 2] = R[6]! * u0 + R[7]! * u1 + R[8]! * u2 + (displayed ? pz : 0);
        if (unknown) {
          out.fill(Number.NaN, n, n + 3);
        }
      }
    }
  }

  /** ∂f/∂x in room axes from `shift` and the slope in the cell, ∂u/∂(place), row by row. */
  private writeSlope(slopes: Points, at: number, inside: boolean, turn: number): void {
    const { frame: R, shift, slope } = this;
    const fade = shift[3]!;
    if (!inside) {
      for (let e = 0; e < 9; e++) {
        slopes[at + e] = e % 4 === 0 ? 1 : 0;
      }
      return;
    }
    const per = CELLS * 2 ** this.level;
    for (let d = 0; d < 3; d++) {
      const sign = d === 2 ? turn : 1;
      for (let e = 0; e < 3; e++) {
        slope[3 * d + e] = slope[3 * d + e]! * ((per / R[12 + e]!) * sign * fade);
      }
    }
    if (turn < 0) {
      const depth = R[15]!;
      slope[2] = shift[0]! / depth - slope[2]!;
      slope[5] = shift[1]! / depth - slope[5]!;
      slope[8] = shift[2]! / depth - slope[8]!;
    }
    const { turned } = this;
    for (let d = 0; d < 3; d++) {
      const r0 = R[3 * d]!;
      const r1 = R[3 * d + 1]!;
      const r2 = R[3 * d + 2]!;
      for (let h = 0; h < 3; h++) {
        turned[3 * d + h] = r0 * slope[h]! + r1 * slope[3 + h]! + r2 * slope[6 + h]!;
      }
    }
    for (let e = 0; e < 3; e++) {
      const r0 = R[3 * e]!;
      const r1 = R[3 * e + 1]!;
      const r2 = R[3 * e + 2]!;
      for (let d = 0; d < 3; d++) {
        const sum = turned[3 * d]! * r0 + turned[3 * d + 1]! * r1 + turned[3 * d + 2]! * r2;
        slopes[at + 3 * e + d] = sum + (d === e ? 1 : 0);
      }
    }
  }

  /**
   * The deepest brick at `place` (m, table frame), its level, and the place in it, 0 to 1. By an
   * array, here and for slopes: numbers handed to a function are allocated one by one.
   */
  private locate(): void {
    const { place } = this;
    const { root, child, rootShape } = this.bricks;
    const nx = rootShape[0]!;
    const ny = rootShape[1]!;
    const nz = rootShape[2]!;
    let a = place[0]! / this.frame[12]!;
    let b = place[1]! / this.frame[13]!;
    let c = place[2]! / this.frame[14]!;
    this.brick = -1;
    this.level = 0;
    if (!(a >= 0 && a <= nx && b >= 0 && b <= ny && c >= 0 && c <= nz)) {
      return;
    }
    let i = Math.min(Math.trunc(a), nx - 1);
    let j = Math.min(Math.trunc(b), ny - 1);
    let k = Math.min(Math.trunc(c), nz - 1);
    let brick = root[(i * ny + j) * nz + k]!;
    if (brick < 0) {
      return;
    }
    a -= i;
    b -= j;
    c -= k;
    for (;;) {
      i = a >= 0.5 ? 1 : 0;
      j = b >= 0.5 ? 1 : 0;
      k = c >= 0.5 ? 1 : 0;
      const deeper = child[8 * brick + 4 * i + 2 * j + k]!;
      if (deeper < 0) {
        break;
      }
      brick = deeper;
      this.level++;
      a = 2 * a - i;
      b = 2 * b - j;
      c = 2 * c - k;
    }
    this.brick = brick;
    place[0] = a;
    place[1] = b;
    place[2] = c;
  }
}

const IDENTITY = [1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1];
