import type { Warp } from "../warp.js";
import { CarriedWarp } from "./carried.js";
import { slopeOf, TouchPoints, writeStencil } from "./contact.js";
import { Onset } from "./onset.js";
import { completed, type HandOptions } from "./options.js";
import { multiply, rotate, rotationVector, setIdentity, turnBy, turnOf } from "./rotation.js";
import { BASES, FINGERS, JOINT_COUNT, TIPS } from "./skeleton.js";
import { HandSolver } from "./solver.js";
import { TrackedHand } from "./tracked.js";

/** m: half the widths over which ∂f is averaged, since it jumps between cells and f does not. */
const STENCIL = 5e-3;
const PALM_STENCIL = 2e-2;

// rows of the points that are looked up at each frame, after the five fingertips
const TOUCH = 5;
const PALM = 10;
const TURN = 11;
const SKIN = 17;
const ROWS = 47;

/**
 * Displays one hand: bones keep their lengths, fingertips touch where they should.
 *
 * What one frame leaves to the next is the onset's weight alone; the rest depends on this frame only.
 */
export class HandRetargeter {
  /** Ease the displacement out while false. */
  active = true;
  private readonly options: Required<HandOptions>;
  private readonly leader: number;
  private readonly onset: Onset;
  private readonly hand = new TrackedHand();
  private readonly solver = new HandSolver();
  private readonly touch = new TouchPoints();
  private source: Warp | CarriedWarp | null = null;
  private warp: Warp | null = null;
  private readonly points = new Float64Array(3 * ROWS);
  private readonly shown = new Float64Array(3 * ROWS);
  // views made once, for lookups of fewer rows
  private readonly views = new Map(
    [TURN, SKIN, ROWS].map((rows) => [
      rows,
      [this.points.subarray(0, 3 * rows), this.shown.subarray(0, 3 * rows)] as const,
    ]),
  );
  private readonly joints = new Float64Array(3 * JOINT_COUNT);
  private readonly goal = new Float64Array(15);
  private readonly slope = new Float64Array(9);
  private readonly turn = new Float64Array(9);
  private readonly vector = new Float64Array(3);
  private readonly rotation = new Float64Array(9);
  private readonly product = new Float64Array(9);
  private readonly palm = new Float64Array(12);

  /** @throws RangeError a word is unknown, a number out of range, or `skin` has no surface. */
  constructor(options: HandOptions = {}) {
    this.options = completed(options);
    this.leader = FINGERS.indexOf(this.options.leader);
    this.onset = new Onset(this.options.onset);
  }

  /** The share of the displacement that is shown now, 0 to 1. */
  get weight(): number {
    return this.onset.weight;
  }

  /** Whether all of it is shown, so that to touch the prop is to touch the virtual object. */
  get mayClaimContact(): boolean {
    return this.onset.weight === 1;
  }

  /**
   * (5) m, how far each displayed fingertip (its centre or pad) is from where it should be; NaN for
   * a finger that is not tracked, and in `points`.
   */
  get tipErrors(): Float64Array {
    return this.solver.misses;
  }

  /** (5, 4) rad, by how much each joint differs from the tracked one. */
  get angles(): Float64Array {
    return this.solver.q;
  }

  /**
   * Take another warp for the one in use, at once and without easing: for one that displays the same
   * and is only known better, as the solved warp after an instant one.
   */
  replace(warp: Warp | CarriedWarp): void {
    if (this.source) {
      this.source = warp;
    }
  }

  /**
   * One frame.
   * @param warp f; null, or another than last time, eases the old one out first. One that goes with
   * a prop is given as the `CarriedWarp`.
   * @param poses 25 × 16 numbers as `XRFrame.fillPoses` gives them, or 26 × 16 with OpenXR's palm
   * before them; NaN where not tracked.
   * @param radii 25 (26) numbers as `XRFrame.fillJointRadii` gives them; NaN or null where unknown.
   * @param time s, of the frame (its predicted display time).
   * @param displayed as `poses`, written; may be `poses`. All NaN where the wrist or a knuckle (in
   * `rigid`, the leading finger) is lost; else NaN for the joints of a finger of which one is.
   * @throws RangeError an array has a wrong length, or the warp is plane.
   */
  update(
    warp: Warp | CarriedWarp | null,
    poses: Float32Array | Float64Array,
    radii: ArrayLike<number> | null,
    time: number,
    displayed: Float32Array | Float64Array,
  ): void {
    const first = poses.length / 16 - JOINT_COUNT;
    if ((first !== 0 && first !== 1) || displayed.length !== poses.length) {
      throw new RangeError(
        `The poses have ${poses.length} numbers and there is room for ${displayed.length}; 16 for each of 25 or 26 joints are needed.`,
      );
    }
    const { hand, options, solver } = this;
    hand.read(poses, radii, first, options.tipRadius);
    const lost = !hand.palmKnown || (options.mode === "rigid" && !hand.present[this.leader]);
    const weight = this.ease(warp, time, lost);
    if (lost) {
      displayed.fill(Number.NaN);
      solver.misses.fill(Number.NaN);
      return;
    }
    if (first === 1) {
      this.readPalm(poses);
    }
    hand.prepare(solver);
    this.setEffectors();
    this.lookUp(weight);
    if (options.mode === "points") {
      this.movePoints(weight, displayed, first);
    } else if (options.mode === "rigid") {
      this.moveRigidly(displayed, first);
    } else {
      this.moveFingers(displayed, first);
    }
    for (let i = 0; i < 5; i++) {
      if (!hand.present[i]) {
        const from = 16 * (first + BASES[i]!);
        displayed.fill(Number.NaN, from, from + 64);
      }
    }
    for (let j = 0; j < JOINT_COUNT; j++) {
      if (!hand.known[j]) {
        displayed.fill(Number.NaN, 16 * (first + j), 16 * (first + j + 1));
      }
    }
  }

  private ease(warp: Warp | CarriedWarp | null, time: number, lost: boolean): number {
    const { onset } = this;
    if (onset.weight === 0 || onset.duration === 0) {
      this.source = warp;
    }
    let wanted = this.active && warp !== null && warp === this.source && !lost;
    if (this.source instanceof CarriedWarp) {
      this.source.placeAt(time);
      wanted = wanted && this.source.valid;
      this.warp = this.source.warp;
    } else {
      this.warp = this.source;
    }
    if (this.warp && this.warp.dimension !== 3) {
      throw new RangeError("The warp is plane; one in space is needed to displace a hand.");
    }
    const weight = onset.advance(time, wanted);
    return this.warp ? weight : 0;
  }

  /** The points of the fingers that should be somewhere, the palm's middle, the weights. */
  private setEffectors(): void {
    const { hand, options, solver, points } = this;
    for (let i = 0; i < 5; i++) {
      const at = 12 * i + 9;
      if (options.contact === "pad") {
        const R = 9 * TIPS[i]!;
        for (let d = 0; d < 3; d++) {
          let offset = -hand.radii[i]! * hand.rotations[R + 3 * d + 1]!;
          if (options.padOffsets) {
            offset = 0;
            for (let e = 0; e < 3; e++) {
              offset += hand.rotations[R + 3 * d + e]! * options.padOffsets[3 * i + e]!;
            }
          }
          solver.chain[at + d] = solver.chain[at + d]! + offset;
        }
      }
      for (let d = 0; d < 3; d++) {
        points[3 * i + d] = solver.chain[at + d]!;
      }
      solver.weight[i] = hand.present[i] ? options.weights[i]! : 0;
    }
    for (let d = 0; d < 3; d++) {
      let sum = 0;
      for (let i = 1; i < 5; i++) {
        sum += hand.positions[3 * BASES[i]! + d]!;
      }
      points[3 * PALM + d] = sum / 4;
    }
  }

  /** Goals of the fingertips, and the palm's own shift and turn, all by their share. */
  private lookUp(weight: number): void {
    const { options, points, shown, goal, solver, hand, touch } = this;
    const skin = options.contact === "skin" && options.surface !== null;
    const turned = options.orientation === "turned";
    setIdentity(this.turn);
    if (this.warp && weight > 0) {
      if (turned) {
        writeStencil(points, options.mode === "rigid" ? this.leader : PALM, PALM_STENCIL, TURN);
      }
      if (skin) {
        touch.find(options.surface!, hand.radii, points, TOUCH);
        for (let n = 0; n < 5; n++) {
          writeStencil(points, TOUCH + n, STENCIL, SKIN + 6 * n);
        }
      }
      const [from, to] = this.views.get(skin ? ROWS : turned ? SKIN : TURN)!;
      this.warp.displayed(from, to);
      for (let n = 0; n < 15; n++) {
        goal[n] = shown[n]!;
      }
      for (let n = 0; skin && n < 5; n++) {
        slopeOf(shown, SKIN + 6 * n, STENCIL, this.slope);
        touch.place(n, shown, TOUCH + n, this.slope, hand.radii[n]!, goal);
      }
      if (turned) {
        slopeOf(shown, TURN, PALM_STENCIL, this.slope);
        turnOf(this.slope, this.turn);
        rotationVector(this.turn, this.vector);
        const { vector } = this;
        turnBy(weight * vector[0]!, weight * vector[1]!, weight * vector[2]!, this.turn);
      }
    }
    for (let n = 0; n < 15; n++) {
      const from = points[n]!;
      solver.target[n] = this.warp && weight > 0 ? from + weight * (goal[n]! - from) : from;
    }
    for (let d = 0; d < 3; d++) {
      const at = 3 * PALM + d;
      const by = this.warp && weight > 0 ? weight * (shown[at]! - points[at]!) : 0;
      solver.shift[d] = by;
      solver.centre[d] = points[at]!;
    }
    for (let i = 0; i < 5; i++) {
      const sum = solver.target[3 * i]! + solver.target[3 * i + 1]! + solver.target[3 * i + 2]!;
      if (!Number.isFinite(sum)) {
        solver.weight[i] = 0;
      }
    }
    solver.turn.set(this.turn);
  }

  private movePoints(weight: number, displayed: Float32Array | Float64Array, first: number): void {
    const { hand, joints, solver } = this;
    solver.q.fill(0);
    solver.misses.fill(Number.NaN);
    joints.fill(0);
    if (this.warp && weight > 0) {
      this.warp.displacement(hand.positions, joints);
    }
    setIdentity(solver.palmTurn);
    solver.palmShift.fill(0);
    for (let j = 0; j < JOINT_COUNT; j++) {
      for (let d = 0; d < 3; d++) {
        joints[3 * j + d] = hand.positions[3 * j + d]! + weight * joints[3 * j + d]!;
      }
      this.write(displayed, first + j, hand.rotations, 9 * j, this.turn, joints, 3 * j);
    }
    if (first === 1) {
      const at = this.vector;
      for (let d = 0; d < 3; d++) {
        at[d] = this.palm[9 + d]!;
      }
      this.warp?.displacement(at, at);
      for (let d = 0; d < 3; d++) {
        at[d] = this.palm[9 + d]! + (this.warp && weight > 0 ? weight * at[d]! : 0);
      }
      this.write(displayed, 0, this.palm, 0, this.turn, at, 0);
    }
  }

  private moveRigidly(displayed: Float32Array | Float64Array, first: number): void {
    const { solver, hand, points, leader } = this;
    solver.q.fill(0);
    solver.palmTurn.set(this.turn);
    for (let d = 0; d < 3; d++) {
      solver.centre[d] = points[3 * leader + d]!;
      solver.palmShift[d] = solver.target[3 * leader + d]! - points[3 * leader + d]!;
    }
    this.writePalm(displayed, first);
    for (let i = 0; i < 5; i++) {
      this.carry(points, 3 * i, this.vector);
      const miss = Math.hypot(
        solver.target[3 * i]! - this.vector[0]!,
        solver.target[3 * i + 1]! - this.vector[1]!,
        solver.target[3 * i + 2]! - this.vector[2]!,
      );
      solver.misses[i] = hand.present[i] ? miss : Number.NaN;
    }
  }

  private moveFingers(displayed: Float32Array | Float64Array, first: number): void {
    const { solver, hand } = this;
    if (!Number.isFinite(solver.shift[0]! + solver.shift[1]! + solver.shift[2]!)) {
      solver.shift.fill(0);
    }
    solver.solve();
    this.writePalm(displayed, first);
    for (let i = 0; i < 5; i++) {
      if (hand.present[i]) {
        // the displayed fingertip is the joint's centre, also where its pad was placed
        const tip = 3 * TIPS[i]!;
        for (let d = 0; d < 3; d++) {
          solver.chain[12 * i + 9 + d] = hand.positions[tip + d]!;
        }
        solver.place(i);
        for (let n = 0; n < 4; n++) {
          const j = BASES[i]! + n;
          const T = solver.turns[Math.min(n, 2)]!;
          this.write(displayed, first + j, hand.rotations, 9 * j, T, solver.joints, 3 * n);
        }
      }
    }
  }

  /** All joints as they go with the palm. */
  private writePalm(displayed: Float32Array | Float64Array, first: number): void {
    const { hand, solver, vector } = this;
    for (let j = 0; j < JOINT_COUNT; j++) {
      this.carry(hand.positions, 3 * j, vector);
      this.write(displayed, first + j, hand.rotations, 9 * j, solver.palmTurn, vector, 0);
    }
    if (first === 1) {
      this.carry(this.palm, 9, vector);
      this.write(displayed, 0, this.palm, 0, solver.palmTurn, vector, 0);
    }
  }

  /** A point as it goes with the palm. */
  private carry(points: Float64Array, at: number, out: Float64Array): void {
    const { centre, palmShift, palmTurn } = this.solver;
    for (let d = 0; d < 3; d++) {
      this.joints[d] = points[at + d]! - centre[d]!;
    }
    rotate(palmTurn, this.joints, 0, out, 0);
    for (let d = 0; d < 3; d++) {
      out[d] = out[d]! + centre[d]! + palmShift[d]!;
    }
  }

  /** One displayed pose: a tracked rotation turned by T, and a position. */
  private write(
    displayed: Float32Array | Float64Array,
    joint: number,
    rotations: Float64Array,
    at: number,
    T: Float64Array,
    positions: Float64Array,
    from: number,
  ): void {
    const { rotation, product } = this;
    for (let n = 0; n < 9; n++) {
      rotation[n] = rotations[at + n]!;
    }
    multiply(T, rotation, product);
    const to = 16 * joint;
    for (let e = 0; e < 3; e++) {
      for (let d = 0; d < 3; d++) {
        displayed[to + 4 * e + d] = product[3 * d + e]!;
      }
      displayed[to + 4 * e + 3] = 0;
      displayed[to + 12 + e] = positions[from + e]!;
    }
    displayed[to + 15] = 1;
  }

  /** OpenXR's palm, which goes with the others of the palm. */
  private readPalm(poses: Float32Array | Float64Array): void {
    for (let e = 0; e < 3; e++) {
      for (let d = 0; d < 3; d++) {
        this.palm[3 * d + e] = poses[4 * e + d]!;
      }
      this.palm[9 + e] = poses[12 + e]!;
    }
  }
}
