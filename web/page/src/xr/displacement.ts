import { Matrix4 } from "three";
import { CarriedWarp, type Warp } from "touchwarp";
import type { Pose } from "../calibrate/pose.js";
import type { Context } from "../context.js";
import { DisplayedHand } from "../world/displayed_hand.js";
import type { Carrier } from "./carrier.js";
import { ContactWatch } from "./contact_watch.js";
import type { HandInput } from "./hand_input.js";
import type { Choices } from "./preflight.js";
import type { PlacedProps } from "./prop_model.js";

/** Both hands through the same f, with what comes of it: contacts, and rows of a recording. */
export class Displacement {
  /** Left first. */
  readonly hands: readonly [DisplayedHand, DisplayedHand];
  /** Which fingertips of each hand are on a prop, bit by bit. */
  readonly touching: [number, number] = [0, 0];
  readonly watch = new ContactWatch();
  #warp: Warp | CarriedWarp | null = null;
  #source: Warp | null = null;
  /** Where the carried warp in use was solved. */
  #rest: Pose | null = null;
  #generation = -1;

  constructor(
    readonly context: Context,
    readonly placed: PlacedProps,
    hand: Choices["hand"],
    /** Null where props stay where they are. */
    readonly carrier: Carrier | null = null,
  ) {
    const displayed = () => new DisplayedHand(placed, undefined, hand);
    this.hands = [displayed(), displayed()];
  }

  /** Whether the warp holds where the prop is now: it may have been carried too far, or be lost. */
  get holds(): boolean {
    return !(this.#warp instanceof CarriedWarp) || this.#warp.valid;
  }

  /** 25 × 16 numbers a hand, left first. */
  get displayed(): readonly [Float32Array, Float32Array] {
    return [this.hands[0].poses, this.hands[1].poses];
  }

  /** The share of the displacement that both hands are shown with. */
  get weight(): number {
    return Math.min(this.handWeight(0), this.handWeight(1));
  }

  /** The fingertips of a hand that touch what is seen, bit by bit. */
  claimed(side: 0 | 1): number {
    const hand = this.hands[side];
    let bits = 0;
    for (let finger = 0; finger < 5; finger++) {
      if (hand.claims(finger)) bits |= this.touching[side] & (1 << finger);
    }
    return bits;
  }

  handWeight(side: 0 | 1): number {
    return this.hands[side].weight;
  }

  /** One frame of both hands. */
  update(time: number, inputs: readonly HandInput[], wanted: boolean): void {
    const warp = this.#placedWarp(time);
    const { recorder, tables } = this.context;
    const T_room_scene = matrix.elements;
    for (const input of inputs) {
      const { side, poses, radii } = input;
      const hand = this.hands[side];
      hand.active = wanted;
      hand.update(warp, poses, radii, time);
      const f = warp instanceof CarriedWarp ? warp.warp : warp;
      const touching = this.watch.update(time, input, hand, this.placed, f);
      this.touching[side] = touching;
      for (const contact of this.watch.fresh) {
        recorder.note(1e3 * time, `contact ${JSON.stringify(contact)}`);
      }
      if (recorder.recording && input.tracked) {
        const identity = tables.file?.identity ?? "";
        const at = 1e3 * time;
        const { poses: shown, weight } = hand;
        recorder.frame(at, side, weight, touching, poses, shown, radii, T_room_scene, identity);
      }
    }
  }

  /** The warp in use, where the props stand; a copy, since the desk has the same in its own frame. */
  #placedWarp(time: number): Warp | CarriedWarp | null {
    const { tables } = this.context;
    const T_room_scene = this.placed.pose.matrix(matrix).elements;
    const rest = this.carrier?.rest ?? null;
    const sameRest = rest === this.#rest;
    if (tables.current !== this.#source || tables.generation !== this.#generation || !sameRest) {
      const same = tables.generation === this.#generation && sameRest;
      this.#source = tables.current;
      this.#generation = tables.generation;
      this.#rest = rest;
      this.#warp = this.#source && this.#placedAnew(this.#source, T_room_scene);
      // What is displayed stays the same: no need to ease it out and in.
      if (same && this.#warp) for (const hand of this.hands) hand.replace(this.#warp);
    }
    if (!(this.#warp instanceof CarriedWarp)) this.#warp?.place(T_room_scene);
    else if (this.carrier!.tracked) this.#warp.addPose(T_room_scene, time);
    return this.#warp;
  }

  #placedAnew(source: Warp, T_room_scene: number[]): Warp | CarriedWarp {
    if (this.carrier === null) return source.at(T_room_scene);
    const rest = this.#rest?.matrix(new Matrix4()).elements ?? T_room_scene;
    return new CarriedWarp(source, { T_room_scene: rest });
  }
}

const matrix = new Matrix4();
