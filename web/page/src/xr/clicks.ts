import { Matrix4, Ray, Vector3 } from "three";
import type { Button } from "./panel.js";
import type { Room } from "./room.js";

/** A pinch that lasts longer holds something, s. */
export const LONGEST_CLICK = 0.7;

/**
 * Pinches that press a button of the card from afar.
 *
 * One that closes on a button and opens on the same, soon after, is a click. Any other holds a stroke
 * or a thing, and presses nothing, wherever the hand happens to point when it opens.
 */
export class Clicks {
  /** What each hand pointed at as it last closed. */
  #closed = new Map<XRHandedness, { readonly label: string | undefined; time: number }>();

  /** @param now the present frame's time, s */
  constructor(
    xr: XRSession,
    readonly room: Room,
    readonly now: () => number,
  ) {
    xr.addEventListener("selectstart", (event) => {
      const label = this.#aim(event)?.label;
      this.#closed.set(event.inputSource.handedness, { label, time: now() });
    });
    xr.addEventListener("select", (event) => this.#opened(event));
  }

  /** Whether a pinch of this side's hand that has just opened was aimed at a button: no stroke. */
  was(side: 0 | 1): boolean {
    const closed = this.#closed.get(side === 0 ? "left" : "right");
    return closed?.label !== undefined && this.now() - closed.time <= LONGEST_CLICK;
  }

  #opened(event: XRInputSourceEvent): void {
    const closed = this.#closed.get(event.inputSource.handedness);
    const button = this.#aim(event);
    if (!closed || !button || button.label !== closed.label) return;
    if (this.now() - closed.time > LONGEST_CLICK) return;
    closed.time = this.now(); // the joints may be seen to part a little later than the device says
    button.press();
  }

  #aim({ frame, inputSource }: XRInputSourceEvent): Button | null {
    const space = this.room.renderer.xr.getReferenceSpace();
    const pose = space && frame.getPose(inputSource.targetRaySpace, space);
    if (!pose) return null;
    matrix.fromArray(pose.transform.matrix);
    const origin = new Vector3().setFromMatrixPosition(matrix);
    const ahead = new Vector3(0, 0, -1).transformDirection(matrix);
    return this.room.panel.pointedAt(new Ray(origin, ahead));
  }
}

const matrix = new Matrix4();
