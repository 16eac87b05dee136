import type { Vector3 } from "three";

/** Where the head may be: a ball around where the person was when everything was verified. */
export interface PlayVolume {
  readonly centre: Vector3;
  /** Metres. */
  readonly radius: number;
}

export const SEATED_RADIUS = 0.6;
export const STANDING_RADIUS = 1.0;

/** Whether the head has left the play volume; it must come 10 cm inside again to be back. */
export function isOutside(head: Vector3, volume: PlayVolume, wasOutside: boolean): boolean {
  const radius = wasOutside ? volume.radius - 0.1 : volume.radius;
  return head.distanceTo(volume.centre) > radius;
}

/**
 * Hands up: the gesture that always brings the real room back.
 *
 * Both wrists, or the only tracked one, above the eyes for half a second (one hand: a second). It
 * needs no finger, so it works when tracking is poor, and no one touches a prop on a table so.
 */
export class HandsUp {
  #since: number | null = null;
  #fired = false;

  /**
   * @param eyes height of the eyes, m
   * @param wrists heights of the two wrists, m; NaN where a hand is not tracked
   * @returns true once for each time the hands go up
   */
  update(eyes: number, wrists: readonly [number, number], time: number): boolean {
    const seen = wrists.filter((height) => Number.isFinite(height));
    const isUp = seen.length > 0 && seen.every((height) => height > eyes);
    if (!isUp) {
      this.#since = null;
      this.#fired = false;
      return false;
    }
    this.#since ??= time;
    const held = time - this.#since >= (seen.length === 2 ? 0.5 : 1);
    if (!held || this.#fired) return false;
    this.#fired = true;
    return true;
  }
}

/** Whether a place lies outside a closed outline on the floor (x and z); an empty one has no end. */
export function isBeyondBounds(
  place: { readonly x: number; readonly z: number },
  outline: readonly { readonly x: number; readonly z: number }[],
): boolean {
  if (outline.length < 3) return false;
  let inside = false;
  let before = outline[outline.length - 1]!;
  for (const corner of outline) {
    const spans = corner.z > place.z !== before.z > place.z;
    const crossing =
      ((before.x - corner.x) * (place.z - corner.z)) / (before.z - corner.z) + corner.x;
    if (spans && place.x < crossing) inside = !inside;
    before = corner;
  }
  return !inside;
}

/** Where people touch with two fingers at once: thumb and index fingertip, with hysteresis. */
export class Pinch {
  /** Whether the fingers are closed. */
  closed = false;

  /** @param apart from thumb tip to index tip, m; NaN when not tracked, which opens it.
   * @returns "closed" or "opened" when that has just happened */
  update(apart: number): "closed" | "opened" | null {
    const before = this.closed;
    this.closed = apart < (before ? 0.03 : 0.018);
    return this.closed === before ? null : this.closed ? "closed" : "opened";
  }
}
