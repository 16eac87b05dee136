import type { NearestSurface } from "./contact.js";
import { FINGERS, type Finger, TIP_RADIUS } from "./skeleton.js";

/** How a hand is displayed; see docs/hands.md. */
export interface HandOptions {
  /**
   * `fingertips` brings all five to their warped places, by inverse kinematics; `rigid` moves the
   * hand as a whole, as `leader` asks; `points` warps every joint by itself, which stretches bones.
   */
  readonly mode?: "fingertips" | "rigid" | "points";
  readonly leader?: Finger;
  /** Or turned by the rotation part of ∂f: of the palm, or in `rigid` at the leading fingertip. */
  readonly orientation?: "as_tracked" | "turned";
  /** What of a fingertip is warped; `skin` is the point nearest to the prop and needs `surface`. */
  readonly contact?: "centre" | "pad" | "skin";
  readonly surface?: NearestSurface | null;
  /** m, where the device gives none. */
  readonly tipRadius?: number;
  /**
   * (5, 3) m from each fingertip's centre to its pad, in the tip's frame; straight out of the palm's
   * side by the radius when left out.
   */
  readonly padOffsets?: ArrayLike<number> | null;
  /** How the five fingers share a miss that cannot be helped; the greater, the less. Read at each
   * frame, so an array may be changed between frames. */
  readonly weights?: ArrayLike<number>;
  /** s from no displacement to all of it. */
  readonly onset?: number;
}

const DEFAULTS = {
  mode: "fingertips",
  leader: "index",
  orientation: "as_tracked",
  contact: "centre",
  surface: null,
  tipRadius: TIP_RADIUS,
  padOffsets: null,
  weights: [1, 1, 1, 1, 1],
  onset: 0.5,
} as const satisfies HandOptions;

const MODES = ["fingertips", "rigid", "points"];
const ORIENTATIONS = ["as_tracked", "turned"];
const CONTACTS = ["centre", "pad", "skin"];

/**
 * Options with those left out filled in.
 * @throws RangeError a word is unknown, a number out of range, or `skin` has no surface.
 */
export function completed(given: HandOptions): Required<HandOptions> {
  const options: Required<HandOptions> = { ...DEFAULTS, ...given };
  const words: readonly (readonly [string, string, readonly string[]])[] = [
    ["mode", options.mode, MODES],
    ["leader", options.leader, FINGERS],
    ["orientation", options.orientation, ORIENTATIONS],
    ["contact", options.contact, CONTACTS],
  ];
  for (const [name, word, known] of words) {
    if (!known.includes(word)) {
      throw new RangeError(
        `The hand's ${name} is '${word}'; one of ${known.join(", ")} is needed.`,
      );
    }
  }
  if (options.contact === "skin" && !options.surface) {
    throw new RangeError(
      "contact: 'skin' needs to know where the props are: give `surface`, or take 'pad'.",
    );
  }
  if (!(options.tipRadius > 0 && options.tipRadius < 0.05)) {
    throw new RangeError(`The tip radius is ${options.tipRadius} m; 0 to 0.05 is needed.`);
  }
  const weights = Array.from(options.weights);
  if (weights.length !== 5 || !weights.every((w) => w > 0 && w < Number.POSITIVE_INFINITY)) {
    throw new RangeError(`The weights are ${weights}; five numbers > 0 are needed.`);
  }
  if (options.padOffsets && options.padOffsets.length !== 15) {
    throw new RangeError(
      `The pad offsets have ${options.padOffsets.length} numbers; 5 × 3 are needed.`,
    );
  }
  return options;
}
