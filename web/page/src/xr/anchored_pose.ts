import { Matrix4 } from "three";
import { Pose } from "../calibrate/pose.js";

/** T_room_scene, held by an anchor of the device where it has them, so that it follows its map. */
export class AnchoredPose {
  #pose: Pose;
  #anchor: XRAnchor | null = null;
  /** Whether an anchor is still to be asked for, which only a frame can do. */
  #unheld = false;
  #count = 0;

  /** @param pose to begin with, which nothing holds. */
  constructor(pose = new Pose()) {
    this.#pose = pose;
  }

  /** Whether an anchor of the device holds the pose. */
  get held(): boolean {
    return this.#anchor !== null;
  }

  /** The pose as of the last frame. */
  get pose(): Pose {
    return this.#pose;
  }

  /** Take a newly found pose. */
  set(pose: Pose): void {
    this.#pose = pose;
    this.release();
    this.#unheld = true;
  }

  /** The pose at this frame. */
  now(frame: XRFrame, room: XRReferenceSpace): Pose {
    if (this.#unheld) this.#hold(frame, room);
    if (this.#anchor && frame.trackedAnchors?.has(this.#anchor) === false) this.#anchor = null;
    const pose = this.#anchor && frame.getPose(this.#anchor.anchorSpace, room);
    if (pose) this.#pose = Pose.of(new Matrix4().fromArray(pose.transform.matrix));
    return this.#pose;
  }

  /** The room's origin is elsewhere now: at `T_before_now` as seen from where it was. */
  originMoved(T_before_now: Matrix4): void {
    if (this.#anchor) return; // the device has moved it already
    const T = T_before_now.clone().invert().multiply(this.#pose.matrix());
    this.#pose = Pose.of(T);
  }

  #hold(frame: XRFrame, room: XRReferenceSpace): void {
    this.#unheld = false;
    const count = this.#count;
    if (!frame.createAnchor) return;
    const { place, turn } = this.#pose;
    const [{ x, y, z }, w] = [turn, turn.w];
    const where = new XRRigidTransform({ x: place.x, y: place.y, z: place.z }, { x, y, z, w });
    frame.createAnchor(where, room)?.then(
      (anchor) => {
        if (count !== this.#count) return anchor.delete();
        this.#anchor = anchor;
      },
      () => {}, // A device that cannot anchor here keeps the pose in its reference space.
    );
  }

  /** Hold it no more. */
  release(): void {
    this.#count++;
    this.#anchor?.delete();
    this.#anchor = null;
  }
}
