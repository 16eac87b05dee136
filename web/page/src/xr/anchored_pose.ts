import { Matrix4, Quaternion, Vector3 } from "three";
import { Pose } from "../calibrate/pose.js";

/** T_room_scene, held by an anchor of the device where it has them, so that it follows its map. */
export class AnchoredPose {
  #pose = new Pose();
  #anchor: XRAnchor | null = null;
  #count = 0;

  /** Take a newly found pose; without a frame it keeps no anchor. */
  set(pose: Pose, frame?: XRFrame, room?: XRReferenceSpace): void {
    this.#pose = pose;
    this.#anchor?.delete();
    this.#anchor = null;
    const count = ++this.#count;
    if (!frame?.createAnchor || !room) return;
    const { x, y, z } = pose.place;
    const turn = pose.turn;
    const where = new XRRigidTransform({ x, y, z }, { x: turn.x, y: turn.y, z: turn.z, w: turn.w });
    frame.createAnchor(where, room)?.then(
      (anchor) => {
        if (count !== this.#count) return anchor.delete();
        this.#anchor = anchor;
      },
      () => {}, // A device without anchors keeps the pose in its reference space.
    );
  }

  /** The pose at this frame. */
  now(frame: XRFrame, room: XRReferenceSpace): Pose {
    if (!this.#anchor) return this.#pose;
    const pose = frame.getPose(this.#anchor.anchorSpace, room);
    if (!pose) return this.#pose;
    const matrix = new Matrix4().fromArray(pose.transform.matrix);
    const [place, turn, size] = [new Vector3(), new Quaternion(), new Vector3()];
    matrix.decompose(place, turn, size);
    this.#pose = new Pose(turn, place);
    return this.#pose;
  }
}
