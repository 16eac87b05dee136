import { Matrix4, type Vector3 } from "three";
import { Pose } from "../calibrate/pose.js";

/** What TypeScript's definitions lack: sources that are tracked but point at nothing. */
interface Tracking {
  readonly inputSources: Iterable<XRInputSource>;
  readonly trackedSources?: Iterable<XRInputSource>;
}

/** How far the prop is from where the scene was solved. */
export interface Carried {
  /** Of the prop's middle, m. */
  readonly shift: number;
  /** rad */
  readonly turn: number;
}

/** A tracked controller that is fixed to the prop, so that the prop may be carried. */
export class Carrier {
  /** Whether the controller is seen at this frame. */
  tracked = false;
  /** Where the prop was found, and the rest of the scene stands; null until then. */
  rest: Pose | null = null;
  /** T_room_scene, carried along with the prop: as it was last seen. */
  pose = new Pose();
  #T_room_grip = new Matrix4();
  #T_grip_scene: Matrix4 | null = null;

  /** Where the controller is at this frame, and the prop with it. */
  read(frame: XRFrame, tracking: Tracking, room: XRReferenceSpace): void {
    const grip = gripOf(tracking);
    const pose = grip && frame.getPose(grip, room);
    this.tracked = !!pose && !pose.emulatedPosition;
    if (!pose || !this.tracked) return;
    this.#T_room_grip.fromArray(pose.transform.matrix);
    if (!this.rest) return;
    // the prop stands still while it is found: where the controller is seen first is where it was
    this.#T_grip_scene ??= this.#T_room_grip.clone().invert().multiply(this.rest.matrix());
    this.pose = Pose.of(this.#T_room_grip.clone().multiply(this.#T_grip_scene));
  }

  /** The prop has been found, standing still. */
  hold(found: Pose): void {
    this.rest = this.pose = found;
    this.#T_grip_scene = null;
  }

  /** The room's origin is elsewhere now: at `T_before_now` as seen from where it was. */
  originMoved(T_before_now: Matrix4): void {
    if (this.rest) this.rest = Pose.of(T_before_now.clone().invert().multiply(this.rest.matrix()));
  }

  /** @param middle of the prop, scene frame. */
  away(middle: Vector3): Carried {
    const { rest, pose } = this;
    if (!rest) return { shift: 0, turn: 0 };
    const shift = pose.toRoom(middle).distanceTo(rest.toRoom(middle));
    return { shift, turn: pose.turn.angleTo(rest.turn) };
  }
}

/** The first controller there is. */
function gripOf({ inputSources, trackedSources = [] }: Tracking): XRSpace | null {
  for (const { hand, gripSpace } of [...trackedSources, ...inputSources]) {
    if (!hand && gripSpace) return gripSpace;
  }
  return null;
}
