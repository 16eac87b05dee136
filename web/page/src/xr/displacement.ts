import { Matrix4 } from "three";
import type { Warp } from "touchwarp";
import type { Context } from "../context.js";
import { DisplayedHand } from "../world/displayed_hand.js";
import { ContactWatch } from "./contact_watch.js";
import type { HandInput } from "./hand_input.js";
import type { PlacedProps } from "./prop_model.js";

/** Both hands through the same f, with what comes of it: contacts, and rows of a recording. */
export class Displacement {
  /** Left first. */
  readonly hands: readonly [DisplayedHand, DisplayedHand];
  /** Which fingertips of each hand are on a prop, bit by bit. */
  readonly touching: [number, number] = [0, 0];
  readonly watch = new ContactWatch();
  #warp: Warp | null = null;
  #source: Warp | null = null;
  #generation = -1;

  constructor(
    readonly context: Context,
    readonly placed: PlacedProps,
  ) {
    this.hands = [new DisplayedHand(placed), new DisplayedHand(placed)];
  }

  /** 25 × 16 numbers a hand, left first. */
  get displayed(): readonly [Float32Array, Float32Array] {
    return [this.hands[0].poses, this.hands[1].poses];
  }

  /** The share of the displacement that both hands are shown with. */
  get weight(): number {
    return Math.min(this.handWeight(0), this.handWeight(1));
  }

  handWeight(side: 0 | 1): number {
    return this.hands[side].weight;
  }

  /** One frame of both hands. */
  update(time: number, inputs: readonly HandInput[], wanted: boolean): void {
    const warp = this.#placedWarp();
    const { recorder, tables } = this.context;
    const T_room_scene = matrix.elements;
    for (const input of inputs) {
      const { side, poses, radii } = input;
      const hand = this.hands[side];
      hand.active = wanted;
      hand.update(warp, poses, radii, time);
      const touching = this.watch.update(time, input, hand, this.placed, warp);
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
  #placedWarp(): Warp | null {
    const { tables } = this.context;
    const T_room_scene = this.placed.pose.matrix(matrix).elements;
    if (tables.current !== this.#source || tables.generation !== this.#generation) {
      const same = tables.generation === this.#generation;
      this.#source = tables.current;
      this.#generation = tables.generation;
      this.#warp = this.#source?.at(T_room_scene) ?? null;
      // What is displayed stays the same: no need to ease it out and in.
      if (same && this.#warp) for (const hand of this.hands) hand.replace(this.#warp);
    }
    this.#warp?.place(T_room_scene);
    return this.#warp;
  }
}

const matrix = new Matrix4();
