import type { Contact } from "../calibrate/contact.js";
import type { HandInput } from "./hand_input.js";

/** What has happened to a stroke in a frame. */
export type StrokeEvent =
  | { readonly kind: "sample"; readonly sample: Contact }
  | { readonly kind: "end"; readonly side: 0 | 1 }
  | null;

/** Strokes: one hand pinches and holds while the other's index fingertip is on the prop. */
export class Strokes {
  /** Whose fingertip is on the prop; null between strokes. */
  touching: 0 | 1 | null = null;

  follow(inputs: readonly [HandInput, HandInput], time: number): StrokeEvent {
    if (this.touching === null) {
      const pinching = inputs.find(({ pinch }) => pinch.closed);
      if (!pinching || !inputs[1 - pinching.side]!.tracked) return null;
      this.touching = pinching.side === 0 ? 1 : 0;
    }
    const side = this.touching;
    if (inputs[1 - side]!.pinch.closed)
      return { kind: "sample", sample: inputs[side]!.sample(time) };
    this.touching = null;
    return { kind: "end", side };
  }

  /** A stroke under way does not count. */
  drop(): void {
    this.touching = null;
  }
}
