import { Vector3 } from "three";
import type { Calibration } from "../calibrate/assess.js";
import {
  type Contact,
  type NamedPoint,
  namedTouch,
  type Stroke,
  trimStrokes,
} from "../calibrate/contact.js";
import { Finder } from "../calibrate/finder.js";
import type { Suggestion } from "../calibrate/nextTouch.js";
import { placesToTouch } from "../calibrate/places.js";
import type { Freedom, Pose } from "../calibrate/pose.js";
import { isFresh, VERIFY_TOUCHES, type Verification, verify } from "../calibrate/verify.js";
import { AnchoredPose } from "./anchored_pose.js";
import type { PropModel } from "./prop_model.js";

/** A stroke that stays within this is a touch of one place, m. */
const ONE_PLACE = 0.012;
/** Samples of a stroke that tells anything. */
const LEAST_SAMPLES = 8;
const NAMED_PLACES = 12;

/** How a person finds a prop: rubs all over it, or touches the places that are shown. */
export type Way = "rub" | "places";

/** Collects the touches of one prop until it is known where it stands. */
export class Calibrator {
  calibration: Calibration | null = null;
  /** T_room_scene as this prop's touches have it, held where the prop stands. */
  anchored = new AnchoredPose();
  /** Where to touch next; null before there is a first guess. */
  suggestion: Suggestion | null = null;
  /** Whether the pose can be used. */
  done = false;
  way: Way = "rub";
  readonly touches: Contact[] = [];
  verification: Verification | null = null;
  /** Called when the touches have told something. */
  found: () => void = () => {};
  #finder: Finder;
  #places: readonly NamedPoint[];
  #strokes: Stroke[] = [];
  #stroke: Contact[] = [];

  constructor(
    readonly prop: PropModel,
    readonly freedom: Freedom,
  ) {
    this.#finder = new Finder(prop);
    this.#places = placesToTouch(prop.surface, NAMED_PLACES);
  }

  /** Whether what the last touches tell is being worked out. */
  get busy(): boolean {
    return this.#finder.busy;
  }

  /** Samples of the stroke under way. */
  get strokeLength(): number {
    return this.#stroke.length;
  }

  get strokes(): number {
    return this.#strokes.length;
  }

  /** The samples of all strokes, for the picture. */
  *samples(): Iterable<Contact> {
    for (const stroke of this.#strokes) yield* stroke;
    yield* this.#stroke;
  }

  /** The place that a finger which stays is taken to touch; null where none is shown. */
  get place(): NamedPoint | null {
    if (this.suggestion) return this.suggestion;
    return this.way === "places" ? (this.#places[this.#strokes.length] ?? null) : null;
  }

  sample(contact: Contact): void {
    this.#stroke.push(contact);
  }

  /** The stroke under way was none. */
  dropStroke(): void {
    this.#stroke = [];
  }

  /** The finger has left the prop: take the stroke in; `found` is called when it has told all.
   * @returns whether it was long enough */
  endStroke(): boolean {
    const stroke = this.#takeStroke();
    if (stroke.length < LEAST_SAMPLES) return false;
    this.#strokes.push(this.#asNamed(stroke) ?? stroke);
    this.#finder.find(trimStrokes(this.#strokes), this.freedom, (finding) => {
      this.calibration = finding.calibration;
      if (finding.calibration) this.anchored.set(finding.calibration.pose);
      this.suggestion = finding.suggestion;
      this.done = finding.calibration !== null && finding.harmless;
      this.found();
    });
    return true;
  }

  /** The finger has left the prop: take the stroke as one touch that verifies the scene's pose. */
  endTouch(pose: Pose): "taken" | "too near another" | "too short" {
    const touch = middleOf(this.#takeStroke());
    if (!touch) return "too short";
    if (!isFresh(this.touches, touch)) return "too near another";
    this.touches.push(touch);
    const { tipOffset } = this.calibration!;
    this.verification = verify(this.prop.surface, pose, tipOffset, this.touches);
    return "taken";
  }

  get touchesLeft(): number {
    return VERIFY_TOUCHES - this.touches.length;
  }

  /** Take over what another has found, whose scene this one is of. */
  adopt({ calibration, anchored }: Calibrator): void {
    if (calibration === null) return;
    this.calibration = calibration;
    this.anchored = anchored;
    this.done = true;
  }

  /** Forget the touches that verified. */
  verifyAnew(): void {
    this.touches.length = 0;
    this.verification = null;
  }

  /** Forget all touches. */
  restart(): void {
    this.verifyAnew();
    this.anchored.release();
    this.anchored = new AnchoredPose(this.anchored.pose); // one of its own, if it was adopted
    this.#finder.forget();
    this.#strokes = [];
    this.#stroke = [];
    this.calibration = this.suggestion = null;
    this.done = false;
  }

  dispose(): void {
    this.#finder.dispose();
  }

  #takeStroke(): Contact[] {
    const stroke = this.#stroke;
    this.#stroke = [];
    return stroke;
  }

  /** A finger that stayed in one place while one was shown has touched that place. */
  #asNamed(stroke: Stroke): Stroke | null {
    const { place } = this;
    const touch = middleOf(stroke);
    if (!place || !touch) return null;
    const stays = stroke.every(
      ({ tip }) => !Number.isFinite(tip.x) || tip.distanceTo(touch.tip) < ONE_PLACE,
    );
    if (!stays) return null;
    return [{ ...touch, named: { point: place.point, normal: place.normal } }];
  }
}

function middleOf(stroke: Stroke): Contact | null {
  if (stroke.length < LEAST_SAMPLES) return null;
  // The first samples lag behind the pinch that began the stroke.
  const settled = stroke.slice(Math.floor(stroke.length / 3));
  const middle = namedTouch(settled, { point: new Vector3(), normal: new Vector3() });
  return middle && { tip: middle.tip, turn: middle.turn, radius: middle.radius, time: middle.time };
}
