import { checkRigid } from "../rigid.js";
import type { Matrix, Warp, WarpMeta } from "../warp.js";
import { multiply, multiplyTransposed, rotationVector, turnBy } from "./rotation.js";

/** s: with no pose of the prop so near a frame, the warp is not valid there. */
const LONGEST_WAIT = 0.1;
const KEPT = 8;

export interface CarriedOptions {
  /** Where the scene as solved stands in the room, column-major. */
  readonly T_room_scene?: Matrix;
  /** Whether other props or fixed surfaces are in Ω; where left out, what the warp's scene says. */
  readonly fixedSurroundings?: boolean;
  /** m and rad: how far the prop may go from where it was solved, in that case. */
  readonly allowedShift?: number;
  readonly allowedTurn?: number;
}

/**
 * The warp of a prop whose pose is tracked, x ↦ T f(T⁻¹ x) with no solve, aligned in time with the
 * hand.
 *
 * Where other props or fixed surfaces are in Ω, u was solved for where they stand: carried farther
 * than allowed the warp is not valid, since it would take them along.
 */
export class CarriedWarp {
  /** Placed by `placeAt`; of this object's own. */
  readonly warp: Warp;
  /** Whether the warp holds at the time of the last `placeAt`. */
  valid = false;
  private readonly fixed: boolean;
  private readonly shift: number;
  private readonly turn: number;
  private readonly rest = new Float64Array(16);
  private readonly middle = new Float64Array(3);
  private readonly times = new Float64Array(KEPT).fill(Number.NEGATIVE_INFINITY);
  private readonly poses = Array.from({ length: KEPT }, () => new Float64Array(16));
  /** Where the newest pose is; they go round. */
  private newest = KEPT - 1;
  private readonly placed = new Float64Array(16);
  private readonly A = new Float64Array(9);
  private readonly B = new Float64Array(9);
  private readonly R = new Float64Array(9);
  private readonly vector = new Float64Array(3);

  /** @throws RangeError a matrix is not rigid, an allowance is negative, or the warp is plane. */
  constructor(warp: Warp, options: CarriedOptions = {}) {
    this.shift = options.allowedShift ?? 2e-3;
    this.turn = options.allowedTurn ?? Math.PI / 180;
    if (!(this.shift >= 0 && this.turn >= 0)) {
      throw new RangeError(
        `A shift of ${this.shift} m and a turn of ${this.turn} rad are allowed; numbers ≥ 0 are needed.`,
      );
    }
    if (warp.dimension !== 3) {
      throw new RangeError("A plane warp was to be carried; one in space is needed.");
    }
    this.fixed = options.fixedSurroundings ?? hasSurroundings(warp.meta);
    this.rest.set(options.T_room_scene ?? IDENTITY);
    checkRigid(this.rest, 3);
    this.warp = warp.at(this.rest);
    const box = warp.meta.outerBox;
    for (let d = 0; d < 3; d++) {
      this.middle[d] = box ? 0.5 * (box.low[d]! + box.high[d]!) : 0;
    }
  }

  /**
   * The prop's pose at a time, in s: where the scene as solved has been carried with it. Poses that
   * are not newer than the last one are passed over.
   * @throws RangeError the pose is not rigid.
   */
  addPose(T_room_scene: Matrix, time: number): void {
    checkRigid(T_room_scene, 3);
    if (!(time > this.times[this.newest]!)) {
      return;
    }
    this.newest = (this.newest + 1) % KEPT;
    this.times[this.newest] = time;
    this.poses[this.newest]!.set(T_room_scene);
  }

  /**
   * Place the warp as at `time`, between the poses around it; sets `valid`. Before the first pose
   * and after the last one the nearest is taken.
   */
  placeAt(time: number): void {
    let before = this.newest;
    let after = this.newest;
    for (let back = 0; back < KEPT && this.times[before]! >= time; back++) {
      const older = (before + KEPT - 1) % KEPT;
      after = before;
      if (older === this.newest || this.times[older] === Number.NEGATIVE_INFINITY) {
        break;
      }
      before = older;
    }
    const t0 = this.times[before]!;
    const t1 = this.times[after]!;
    if (t0 === Number.NEGATIVE_INFINITY) {
      this.valid = false;
      return;
    }
    const share = t1 > t0 ? Math.min(Math.max((time - t0) / (t1 - t0), 0), 1) : 0;
    this.setBetween(this.poses[before]!, this.poses[after]!, share);
    this.warp.place(this.placed);
    const away = Math.min(Math.abs(time - t0), Math.abs(time - t1));
    this.valid = away <= LONGEST_WAIT && (!this.fixed || this.near());
  }

  /** Whether the prop is about where it was solved. */
  private near(): boolean {
    const { placed: T, rest, middle, vector } = this;
    this.setDifference(rest, T);
    const turned = Math.hypot(vector[0]!, vector[1]!, vector[2]!);
    let moved = 0;
    for (let d = 0; d < 3; d++) {
      let by = T[12 + d]! - rest[12 + d]!;
      for (let e = 0; e < 3; e++) {
        by += (T[4 * e + d]! - rest[4 * e + d]!) * middle[e]!;
      }
      moved += by * by;
    }
    return Math.sqrt(moved) <= this.shift && turned <= this.turn;
  }

  private setBetween(from: Float64Array, to: Float64Array, share: number): void {
    const { placed, vector, R, A, B } = this;
    this.setDifference(from, to);
    turnBy(share * vector[0]!, share * vector[1]!, share * vector[2]!, R);
    readRotation(from, A);
    multiply(R, A, B);
    for (let d = 0; d < 3; d++) {
      for (let e = 0; e < 3; e++) {
        placed[4 * e + d] = B[3 * d + e]!;
      }
      placed[12 + d] = from[12 + d]! + share * (to[12 + d]! - from[12 + d]!);
    }
    placed[15] = 1;
  }

  /** The rotation vector from one pose to another. */
  private setDifference(from: Float64Array, to: Float64Array): void {
    readRotation(to, this.A);
    readRotation(from, this.B);
    multiplyTransposed(this.A, this.B, this.R);
    rotationVector(this.R, this.vector);
  }
}

/** Whether the scene that a warp was solved for holds more than one prop. */
function hasSurroundings({ propNames, scene }: WarpMeta): boolean {
  return propNames.length > 1 || /^\s*(\[\[\s*fixed\s*\]\]|fixed\s*=)/m.test(scene);
}

function readRotation(T: Float64Array, out: Float64Array): void {
  for (let d = 0; d < 3; d++) {
    for (let e = 0; e < 3; e++) {
      out[3 * d + e] = T[4 * e + d]!;
    }
  }
}

const IDENTITY = [1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1];
