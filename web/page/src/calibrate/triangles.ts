/** Most triangles of a leaf. */
const LEAF = 4;
const DEEPEST = 64;

/**
 * Triangles by place, for the nearest point of any of them: a tree of boxes, halved at the median along
 * its longest side, and the corners in the order in which the tree is gone through. All of it is flat,
 * so that a search allocates nothing and reads memory in order: it is done some ten thousand times
 * for one calibration, and tens of times a frame.
 */
export class Triangles {
  /** Of the last search that found something: the face, the point's squared distance, the point
   * as corner 0 + s (corner 1 − corner 0) + t (corner 2 − corner 0), and its coordinates. */
  face = 0;
  squared = 0;
  s = 0;
  t = 0;
  x = 0;
  y = 0;
  z = 0;

  /** Per node: its box, least then greatest corner. */
  readonly #boxes: Float64Array;
  /** Per node: the first of its triangles, and how many; −1 for a node that has two children. */
  readonly #begins: Int32Array;
  readonly #counts: Int32Array;
  /** Per node with children: the second; the first comes next. */
  readonly #seconds: Int32Array;
  /** Per triangle, in the tree's order: corner 0 and the edges to corners 1 and 2; its face. */
  readonly #corners: Float64Array;
  readonly #faces: Int32Array;
  readonly #waiting = new Int32Array(DEEPEST);
  readonly #distances = new Float64Array(DEEPEST);
  #nodes = 0;

  /**
   * @param positions (n, 3) row by row, m
   * @param faces (m, 3) indices
   */
  constructor(positions: Float32Array, faces: ArrayLike<number>) {
    const count = faces.length / 3;
    const most = 2 * count;
    this.#boxes = new Float64Array(6 * most);
    this.#begins = new Int32Array(most);
    this.#counts = new Int32Array(most);
    this.#seconds = new Int32Array(most);
    this.#corners = new Float64Array(9 * count);
    this.#faces = Int32Array.from({ length: count }, (_, face) => face);
    const middles = new Float64Array(3 * count);
    for (let k = 0; k < faces.length; k++) {
      const at = 3 * Math.floor(k / 3);
      for (let d = 0; d < 3; d++) middles[at + d]! += positions[3 * faces[k]! + d]! / 3;
    }
    this.#divide(0, count, middles, positions, faces);
    for (let place = 0; place < count; place++) {
      const face = 3 * this.#faces[place]!;
      for (let d = 0; d < 3; d++) {
        const origin = positions[3 * faces[face]! + d]!;
        this.#corners[9 * place + d] = origin;
        this.#corners[9 * place + 3 + d] = positions[3 * faces[face + 1]! + d]! - origin;
        this.#corners[9 * place + 6 + d] = positions[3 * faces[face + 2]! + d]! - origin;
      }
    }
  }

  /** Seek the point nearest to (px, py, pz) that is nearer than `within`; whether there is one. */
  find(px: number, py: number, pz: number, within: number): boolean {
    const waiting = this.#waiting;
    const distances = this.#distances;
    let found = false;
    this.squared = within * within;
    waiting[0] = 0;
    distances[0] = this.#away(0, px, py, pz);
    let top = 1;
    while (top > 0) {
      const node = waiting[--top]!;
      if (distances[top]! >= this.squared) continue;
      const count = this.#counts[node]!;
      if (count >= 0) {
        const end = this.#begins[node]! + count;
        for (let place = this.#begins[node]!; place < end; place++) {
          if (this.#foot(place, px, py, pz)) found = true;
        }
        continue;
      }
      const one = node + 1;
      const other = this.#seconds[node]!;
      const toOne = this.#away(one, px, py, pz);
      const toOther = this.#away(other, px, py, pz);
      const oneFirst = toOne <= toOther;
      const farther = oneFirst ? toOther : toOne;
      const nearer = oneFirst ? toOne : toOther;
      if (farther < this.squared) {
        waiting[top] = oneFirst ? other : one;
        distances[top++] = farther;
      }
      if (nearer < this.squared) {
        waiting[top] = oneFirst ? one : other;
        distances[top++] = nearer;
      }
    }
    return found;
  }

  /** Squared distance of a node's box. */
  #away(node: number, px: number, py: number, pz: number): number {
    const boxes = this.#boxes;
    const at = 6 * node;
    const x = Math.max(boxes[at]! - px, 0, px - boxes[at + 3]!);
    const y = Math.max(boxes[at + 1]! - py, 0, py - boxes[at + 4]!);
    const z = Math.max(boxes[at + 2]! - pz, 0, pz - boxes[at + 5]!);
    return x * x + y * y + z * z;
  }

  /**
   * The point of one triangle nearest to p, taken if it is nearer than `squared`: which corner, edge or
   * inside it is on is told by signs of products with the edges (Ericson 2004, 5.1.5).
   */
  #foot(place: number, px: number, py: number, pz: number): boolean {
    const corners = this.#corners;
    const at = 9 * place;
    const ux = corners[at + 3]!;
    const uy = corners[at + 4]!;
    const uz = corners[at + 5]!;
    const vx = corners[at + 6]!;
    const vy = corners[at + 7]!;
    const vz = corners[at + 8]!;
    const wx = px - corners[at]!;
    const wy = py - corners[at + 1]!;
    const wz = pz - corners[at + 2]!;
    const uw = ux * wx + uy * wy + uz * wz;
    const vw = vx * wx + vy * wy + vz * wz;
    let s = 0;
    let t = 0;
    if (uw > 0 || vw > 0) {
      const uu = ux * ux + uy * uy + uz * uz;
      const uv = ux * vx + uy * vy + uz * vz;
      const vv = vx * vx + vy * vy + vz * vz;
      // the same products of p − corner 1 and p − corner 2
      const u1 = uw - uu;
      const v1 = vw - uv;
      const u2 = uw - uv;
      const v2 = vw - vv;
      const a = u1 * v2 - u2 * v1;
      const b = u2 * vw - uw * v2;
      const c = uw * v1 - u1 * vw;
      if (u1 >= 0 && v1 <= u1) s = 1;
      else if (c <= 0 && uw >= 0 && u1 <= 0) s = uw / (uw - u1);
      else if (v2 >= 0 && u2 <= v2) t = 1;
      else if (b <= 0 && vw >= 0 && v2 <= 0) t = vw / (vw - v2);
      else if (a <= 0 && v1 - u1 >= 0 && u2 - v2 >= 0) {
        t = (v1 - u1) / (v1 - u1 + (u2 - v2));
        s = 1 - t;
      } else {
        s = b / (a + b + c);
        t = c / (a + b + c);
      }
    }
    const x = wx - s * ux - t * vx;
    const y = wy - s * uy - t * vy;
    const z = wz - s * uz - t * vz;
    const squared = x * x + y * y + z * z;
    if (!(squared < this.squared)) return false; // a triangle without area gives NaN
    this.face = this.#faces[place]!;
    this.squared = squared;
    this.s = s;
    this.t = t;
    this.x = px - x;
    this.y = py - y;
    this.z = pz - z;
    return true;
  }

  /** Make the node of the triangles from `begin` to `end`, and those below it. */
  #divide(
    begin: number,
    end: number,
    middles: Float64Array,
    positions: Float32Array,
    faces: ArrayLike<number>,
  ): void {
    const node = this.#nodes++;
    const own = this.#faces.subarray(begin, end);
    const box = this.#boxes.subarray(6 * node, 6 * node + 6);
    box.fill(Number.POSITIVE_INFINITY, 0, 3).fill(Number.NEGATIVE_INFINITY, 3);
    for (const face of own) {
      for (let k = 3 * face; k < 3 * face + 3; k++) {
        for (let d = 0; d < 3; d++) {
          const value = positions[3 * faces[k]! + d]!;
          box[d] = Math.min(box[d]!, value);
          box[d + 3] = Math.max(box[d + 3]!, value);
        }
      }
    }
    if (own.length <= LEAF) {
      this.#begins[node] = begin;
      this.#counts[node] = own.length;
      return;
    }
    const sides = [0, 1, 2].map((d) => box[d + 3]! - box[d]!);
    const axis = sides.indexOf(Math.max(...sides));
    own.sort((one, other) => middles[3 * one + axis]! - middles[3 * other + axis]!);
    const half = begin + (own.length >> 1);
    this.#counts[node] = -1;
    this.#divide(begin, half, middles, positions, faces);
    this.#seconds[node] = this.#nodes;
    this.#divide(half, end, middles, positions, faces);
  }
}
