import type { Experience } from "./experience.js";

/**
 * For experiments and tests: with `?probe` in the page's address, `window.touchwarpProbe` holds what
 * is tracked, displayed and decided at each frame. Without it, nothing is told.
 */
export class Probe {
  #wanted = new URLSearchParams(location.search).has("probe");

  show(experience: Experience): void {
    if (!this.#wanted) return;
    window.touchwarpProbe = experience;
  }

  close(): void {
    window.touchwarpProbe = undefined;
  }
}

declare global {
  interface Window {
    touchwarpProbe?: Experience | undefined;
  }
}
