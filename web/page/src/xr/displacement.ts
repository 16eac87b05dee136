import { Matrix4, Vector3 } from "three";
import { HandRetargeter, type Warp } from "touchwarp";
import type { Context } from "../context.js";
import { ContactWatch } from "./contact_watch.js";
import { type HandInput, TIPS } from "./hand_input.js";
import type { PlacedProps } from "./prop_model.js";

/** From here on, m, a fingertip that comes near counts more, up to this many times when it touches. */
const NEAR = 0.03;
const FIRST = 100;

/** Both hands through the same f, with what comes of it: contacts, and rows of a recording. */
export class Displacement {
  /** 25 × 16 numbers a hand, left first. */
  readonly displayed = [new Float32Array(400), new Float32Array(400)] as const;
  /** Which fingertips of each hand are on a prop, bit by bit. */
  readonly touching: [number, number] = [0, 0];
  readonly watch = new ContactWatch();
  /** How the five fingers share what no hand can meet; read by the retargeters at each frame. */
  readonly #weights = [new Float64Array(5).fill(1), new Float64Array(5).fill(1)] as const;
  readonly #retargeters: readonly HandRetargeter[];
  #warp: Warp | null = null;
  #source: Warp | null = null;

  constructor(
    readonly context: Context,
    readonly placed: PlacedProps,
  ) {
    this.#retargeters = this.#weights.map(
      (weights) => new HandRetargeter({ contact: "skin", surface: placed, weights }),
    );
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
      this.#weigh(input);
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

  /** Fingers near the prop come first, the more the nearer, so that what touches is exact. */
  #weigh(input: HandInput): void {
    TIPS.forEach((joint, finger) => {
      input.joint(joint, tip);
      const known = Number.isFinite(tip.x) && this.placed.props.length > 0;
      const away = known ? Math.abs(this.placed.felt(tip).distance - input.radius(joint)) : NEAR;
      const nearness = Math.max(0, 1 - away / NEAR);
      this.#weights[input.side][finger] = 1 + (FIRST - 1) * nearness ** 2;
    });
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
const tip = new Vector3();
