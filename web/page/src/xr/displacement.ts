import { Matrix4 } from "three";
import { HandRetargeter, type Warp } from "touchwarp";
import type { Context } from "../context.js";
import { ContactWatch } from "./contact_watch.js";
import type { HandInput } from "./hand_input.js";
import type { PlacedProps } from "./prop_model.js";

/** Both hands through the same f, with what comes of it: contacts, and rows of a recording. */
export class Displacement {
  /** 25 × 16 numbers a hand, left first. */
  readonly displayed = [new Float32Array(400), new Float32Array(400)] as const;
  /** Which fingertips of each hand are on a prop, bit by bit. */
  readonly touching: [number, number] = [0, 0];
  readonly watch = new ContactWatch();
  #retargeters: readonly HandRetargeter[];
  #warp: Warp | null = null;
  #source: Warp | null = null;

  constructor(
    readonly context: Context,
    readonly placed: PlacedProps,
  ) {
    this.#retargeters = [0, 1].map(() => new HandRetargeter({ contact: "skin", surface: placed }));
  }

  /** The share of the displacement that both hands are shown with. */
  get weight(): number {
    return Math.min(this.handWeight(0), this.handWeight(1));
  }

  handWeight(side: 0 | 1): number {
    return this.#retargeters[side]!.weight;
  }

  mayClaimContact(side: 0 | 1): boolean {
    return this.#retargeters[side]!.mayClaimContact;
  }

  /** One frame of both hands. */
  update(time: number, inputs: readonly HandInput[], wanted: boolean): void {
    const warp = this.#placedWarp();
    const { recorder, tables } = this.context;
    for (const input of inputs) {
      const { side, poses, radii } = input;
      const retargeter = this.#retargeters[side]!;
      const shown = this.displayed[side];
      retargeter.active = wanted;
      retargeter.update(warp, poses, radii, time, shown);
      const touching = this.watch.update(time, input, shown, this.placed, warp, retargeter);
      this.touching[side] = touching;
      for (const contact of this.watch.fresh) {
        recorder.note(time, `contact ${JSON.stringify(contact)}`);
      }
      if (recorder.recording && input.tracked) {
        const identity = tables.file?.identity ?? "";
        recorder.frame(time, side, retargeter.weight, touching, poses, shown, radii, identity);
      }
    }
  }

  /** The warp in use, where the props stand; a copy, since the desk has the same in its own frame. */
  #placedWarp(): Warp | null {
    const { tables } = this.context;
    const T_room_scene = this.placed.pose.matrix(matrix).elements;
    if (tables.current !== this.#source) {
      this.#source = tables.current;
      this.#warp = this.#source?.at(T_room_scene) ?? null;
    }
    this.#warp?.place(T_room_scene);
    return this.#warp;
  }
}

const matrix = new Matrix4();
