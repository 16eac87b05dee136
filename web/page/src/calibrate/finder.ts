import type { Contact } from "./contact.js";
import { type Finding, type PackedFinding, packContacts, unpackFinding } from "./packing.js";
import type { Freedom } from "./pose.js";
import type { SurfaceGoal } from "./symmetry.js";
import type { ToWorker } from "./worker.js";

/** Finds one prop, in a thread of its own. */
export class Finder {
  #worker: Worker;
  #answer: ((finding: Finding) => void) | null = null;
  #next: (() => void) | null = null;

  constructor({ surface, virtual }: SurfaceGoal) {
    this.#worker = new Worker(new URL("./worker.ts", import.meta.url), { type: "module" });
    this.#worker.onmessage = ({ data }: MessageEvent<PackedFinding>) => {
      const answer = this.#answer;
      this.#answer = null;
      answer?.(unpackFinding(data));
      const next = this.#next;
      this.#next = null;
      next?.();
    };
    const { positions, faces } = surface;
    this.#send({ prop: { positions, faces: new Uint32Array(faces), virtual } });
  }

  /** Whether a registration is going on. */
  get busy(): boolean {
    return this.#answer !== null;
  }

  /** Tells what the touches say; of several asked for meanwhile only the last is looked at. */
  find(contacts: readonly Contact[], freedom: Freedom, answer: (finding: Finding) => void): void {
    const ask = () => {
      this.#answer = answer;
      this.#send({ task: { contacts: packContacts(contacts), freedom } });
    };
    if (this.busy) this.#next = ask;
    else ask();
  }

  /** What is going on is not wanted any more. */
  forget(): void {
    if (this.busy) this.#answer = () => {};
    this.#next = null;
  }

  dispose(): void {
    this.#worker.terminate();
  }

  #send(message: ToWorker): void {
    this.#worker.postMessage(message);
  }
}
