import type { Ray } from "three";
import type { Slice } from "./slice.js";
import type { Pane, Stage } from "./stage.js";

/** A place on the screen, in one of the panes. */
export interface Pointer {
  readonly pane: Pane;
  readonly clientX: number;
  readonly clientY: number;
}

/** Where the mouse is, for the probe; it drags the slice where it has its knob. */
export class Mouse {
  /** Where it was last, or where keys have moved it. */
  last: Pointer | null = null;
  /** Called when the slice was dragged. */
  sliced: () => void = () => {};
  #fresh: Pointer | null = null;
  #dragging = false;

  constructor(
    readonly stage: Stage,
    readonly slice: Slice,
  ) {
    for (const pane of [stage.felt, stage.seen]) this.#listen(pane);
    stage.element.addEventListener("pointerup", () => this.#release());
    stage.element.addEventListener("pointercancel", () => this.#release());
  }

  /** Where it has come since the last call; null if it has not moved. */
  take(): Pointer | null {
    const fresh = this.#fresh;
    this.#fresh = null;
    return fresh;
  }

  put(pointer: Pointer): void {
    this.last = this.#fresh = pointer;
    this.stage.draw();
  }

  #listen(pane: Pane): void {
    const { element } = pane;
    const ray = (event: PointerEvent): Ray => this.stage.ray(pane, event);
    element.addEventListener("pointermove", (event) => {
      if (this.#dragging) {
        this.slice.drag(ray(event));
        this.sliced();
      } else if (event.buttons === 0) {
        const overKnob = this.slice.hit(ray(event));
        element.classList.toggle("knob", overKnob);
        // the hand does not come after the knob, which it would hide
        if (!overKnob) this.put({ pane, clientX: event.clientX, clientY: event.clientY });
      }
      this.stage.draw();
    });
    element.addEventListener("pointerdown", (event) => {
      if (!this.slice.hit(ray(event))) return;
      this.#dragging = true;
      this.stage.orbit.enabled = false;
      element.setPointerCapture(event.pointerId);
    });
  }

  #release(): void {
    if (this.#dragging) this.stage.orbit.enabled = true;
    this.#dragging = false;
  }
}
