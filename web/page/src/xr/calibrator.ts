import { Vector3 } from "three";
import { type Calibration, calibrate } from "../calibrate/assess.js";
import {
  type Contact,
  HEADSET_HANDS,
  type NamedPoint,
  namedTouch,
  type Stroke,
  trimStrokes,
} from "../calibrate/contact.js";
import { nextTouch, type Suggestion } from "../calibrate/nextTouch.js";
import type { Freedom } from "../calibrate/pose.js";
import type { Task } from "../calibrate/register.js";
import { doubtIsHarmless } from "../calibrate/symmetry.js";
import { isFresh, VERIFY_TOUCHES, type Verification, verify } from "../calibrate/verify.js";
import type { PropModel } from "./prop_model.js";

const UP = new Vector3(0, 1, 0);
/** A stroke that stays within this is a touch of one place, m. */
const ONE_PLACE = 0.012;

/** Collects the touches of one prop until it is known where it stands. */
export class Calibrator {
  calibration: Calibration | null = null;
  /** Where to touch next; null before there is a first guess. */
  suggestion: Suggestion | null = null;
  readonly touches: Contact[] = [];
  verification: Verification | null = null;
  #strokes: Stroke[] = [];
  #stroke: Contact[] = [];

  constructor(
    readonly prop: PropModel,
    readonly freedom: Freedom,
  ) {}

  /** Whether the pose can be used. */
  get done(): boolean {
    const { calibration, prop } = this;
    if (!calibration) return false;
    return calibration.doubts.length === 0 || doubtIsHarmless(prop, calibration);
  }

  /** Samples of the stroke under way. */
  get strokeLength(): number {
    return this.#stroke.length;
  }

  sample(contact: Contact): void {
    this.#stroke.push(contact);
  }

  /** The finger has left the prop: take the stroke in and say anew where the prop stands. */
  endStroke(): void {
    const stroke = this.#takeStroke();
    if (stroke.length < 8) return;
    this.#strokes.push(this.#asNamed(stroke) ?? stroke);
    const task: Task = {
      surface: this.prop.surface,
      contacts: trimStrokes(this.#strokes),
      freedom: this.freedom,
      up: UP,
      tracking: HEADSET_HANDS,
    };
    this.calibration = calibrate(task);
    this.suggestion = this.calibration && nextTouch(task, this.calibration);
  }

  /** The finger has left the prop: take the stroke as one touch that verifies. */
  endTouch(): "taken" | "too near another" | "too short" {
    const touch = middleOf(this.#takeStroke());
    if (!touch) return "too short";
    if (!isFresh(this.touches, touch)) return "too near another";
    this.touches.push(touch);
    const { pose, tipOffset } = this.calibration!;
    this.verification = verify(this.prop.surface, pose, tipOffset, this.touches);
    return "taken";
  }

  get touchesLeft(): number {
    return VERIFY_TOUCHES - this.touches.length;
  }

  /** Forget the touches that verified. */
  verifyAnew(): void {
    this.touches.length = 0;
    this.verification = null;
  }

  /** Forget all touches. */
  restart(): void {
    this.verifyAnew();
    this.#strokes = [];
    this.#stroke = [];
    this.calibration = this.suggestion = null;
  }

  #takeStroke(): Contact[] {
    const stroke = this.#stroke;
    this.#stroke = [];
    return stroke;
  }

  /** A finger that stayed in one place while one was suggested has touched that place. */
  #asNamed(stroke: Stroke): Stroke | null {
    const { suggestion, calibration } = this;
    const touch = middleOf(stroke);
    if (!suggestion || !calibration || !touch) return null;
    const stays = stroke.every(
      ({ tip }) => !Number.isFinite(tip.x) || tip.distanceTo(touch.tip) < ONE_PLACE,
    );
    if (!stays) return null;
    const named: NamedPoint = { point: suggestion.point, normal: suggestion.normal };
    return [{ ...touch, named }];
  }
}

function middleOf(stroke: Stroke): Contact | null {
  if (stroke.length < 8) return null;
  // The first samples lag behind the pinch that began the stroke.
  const settled = stroke.slice(Math.floor(stroke.length / 3));
  const middle = namedTouch(settled, { point: new Vector3(), normal: new Vector3() });
  return middle && { tip: middle.tip, turn: middle.turn, radius: middle.radius, time: middle.time };
}
