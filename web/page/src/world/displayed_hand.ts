import { type CarriedWarp, type HandOptions, HandRetargeter, type Warp } from "touchwarp";
import { FollowedRows, type PlacedSurfaces } from "./nearest.js";

const JOINTS = 25;
/** Fingertips in WebXR's order of joints, thumb first. */
export const TIPS = [4, 9, 14, 19, 24] as const;

/**
 * From here on, m from its skin to the prop, a fingertip that comes near counts more, up to this many
 * times when it touches; farther away its centre is displayed for itself.
 */
const NEAR = 0.03;
const FIRST = 100;
const USUAL_RADIUS = 0.008;
/** The index finger leads a hand that is displayed as one piece. */
const LEADER = 1;

/**
 * One whole hand as it is displayed, on the desk and in the headset: bones stay rigid, the skin that
 * touches is what is warped, and a fingertip near a prop comes before others in what a rigid-boned
 * hand cannot meet.
 */
export class DisplayedHand {
  /** 25 × 16 numbers, column-major matrices. */
  readonly poses = new Float32Array(16 * JOINTS).fill(Number.NaN);
  /** (5) m: how far the skin of each tracked fingertip is from the prop, negative inside; NaN if lost. */
  readonly gaps = new Float64Array(5).fill(Number.NaN);
  /** (5, 3) the way out of the prop there. */
  readonly normals = new Float64Array(15);
  readonly #surface: FollowedRows;
  readonly #weights = new Float64Array(5).fill(1); // read by the retargeter at each frame
  readonly #retargeter: HandRetargeter;
  readonly #tips = new Float64Array(15);
  readonly #nearest = new Float64Array(15);

  /**
   * @param onset s from no displacement to all of it.
   * @param mode whether all fingertips touch what they should, or one leads a rigid hand.
   */
  constructor(
    placed: PlacedSurfaces,
    onset?: number,
    readonly mode: NonNullable<HandOptions["mode"]> = "fingertips",
  ) {
    this.#surface = new FollowedRows(placed, 5);
    const eased = onset === undefined ? {} : { onset };
    this.#retargeter = new HandRetargeter({
      mode,
      contact: "skin",
      surface: {
        // it asks of the fingertips what has just been looked up to weigh them
        nearest: (_, nearest, normals) => {
          nearest.set(this.#nearest);
          normals.set(this.normals);
        },
      },
      weights: this.#weights,
      ...eased,
    });
  }

  /** The share of the displacement that is shown, 0 to 1. */
  get weight(): number {
    return this.#retargeter.weight;
  }

  /** Whether all of it is, so that to touch the prop is to touch the virtual object. */
  get mayClaimContact(): boolean {
    return this.#retargeter.mayClaimContact;
  }

  /** Whether a finger that touches the prop is displayed on the virtual object. */
  claims(finger: number): boolean {
    return this.mayClaimContact && (this.mode !== "rigid" || finger === LEADER);
  }

  /** (5) m: how far each displayed fingertip is from where it should be. */
  get tipErrors(): Float64Array {
    return this.#retargeter.tipErrors;
  }

  set active(active: boolean) {
    this.#retargeter.active = active;
  }

  /** The same warp, known better. */
  replace(warp: Warp | CarriedWarp): void {
    this.#retargeter.replace(warp);
  }

  /** One frame; arguments as of `HandRetargeter.update`. */
  update(
    warp: Warp | CarriedWarp | null,
    poses: Float32Array,
    radii: Float32Array,
    time: number,
  ): void {
    this.#weigh(poses, radii);
    this.#retargeter.update(warp, poses, radii, time, this.poses);
  }

  /** Fingers near the prop come first, the more the nearer, so that what touches is exact. */
  #weigh(poses: Float32Array, radii: Float32Array): void {
    const [tips, nearest, normals] = [this.#tips, this.#nearest, this.normals];
    let range = 0;
    for (let finger = 0; finger < 5; finger++) {
      for (let d = 0; d < 3; d++) tips[3 * finger + d] = poses[16 * TIPS[finger]! + 12 + d]!;
      range = Math.max(range, NEAR + radiusOf(radii, finger));
    }
    this.#surface.range = range;
    this.#surface.nearest(tips, nearest, normals);
    for (let finger = 0; finger < 5; finger++) {
      let square = 0;
      let side = 0;
      for (let d = 3 * finger; d < 3 * finger + 3; d++) {
        const away = tips[d]! - nearest[d]!;
        square += away * away;
        side += away * normals[d]!;
      }
      const distance = side < 0 ? -Math.sqrt(square) : Math.sqrt(square);
      const gap = distance - radiusOf(radii, finger);
      const nearness = Math.abs(gap) < NEAR ? 1 - Math.abs(gap) / NEAR : 0; // 0 if lost
      this.gaps[finger] = gap;
      this.#weights[finger] = 1 + (FIRST - 1) * nearness ** 2;
    }
  }
}

function radiusOf(radii: Float32Array, finger: number): number {
  const told = radii[TIPS[finger]!]!;
  return told > 0 ? told : USUAL_RADIUS;
}
