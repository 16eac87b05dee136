import { Matrix4, Quaternion, Vector3 } from "three";
import type { Contact } from "../calibrate/contact.js";
import { TIPS } from "../world/displayed_hand.js";
import { Pinch } from "./safety.js";

/** Calls of WebXR's hand input module that TypeScript's definitions lack; not all devices have them. */
interface HandFrame {
  fillPoses?(spaces: readonly XRSpace[], base: XRSpace, poses: Float32Array): boolean;
  fillJointRadii?(spaces: readonly XRJointSpace[], radii: Float32Array): boolean;
}

export const JOINT_COUNT = 25;
export const INDEX_TIP = 9;

/** One hand as the headset tracks it, read anew at each frame; reference space. */
export class HandInput {
  /** 25 × 16 numbers, a column-major matrix a joint; NaN where not tracked. */
  readonly poses = new Float32Array(16 * JOINT_COUNT).fill(Number.NaN);
  readonly radii = new Float32Array(JOINT_COUNT).fill(Number.NaN);
  readonly pinch = new Pinch();
  pinched: "closed" | "opened" | null = null;
  #hand: XRHand | null = null;
  #spaces: XRJointSpace[] = [];

  constructor(readonly side: 0 | 1) {}

  get tracked(): boolean {
    return Number.isFinite(this.poses[12]!);
  }

  /** Read the joints of this side's hand, if the headset has one. */
  read(frame: XRFrame & HandFrame, sources: XRInputSourceArray, room: XRReferenceSpace): void {
    const handedness = this.side === 0 ? "left" : "right";
    let hand: XRHand | null = null;
    for (const source of sources) {
      if (source.handedness === handedness && source.hand) hand = source.hand;
    }
    if (hand !== this.#hand) {
      this.#hand = hand;
      this.#spaces = hand ? [...hand.values()] : [];
    }
    if (!hand || this.#spaces.length !== JOINT_COUNT) {
      this.poses.fill(Number.NaN);
    } else if (frame.fillPoses?.(this.#spaces, room, this.poses)) {
      frame.fillJointRadii?.(this.#spaces, this.radii);
    } else {
      this.#readOneByOne(frame, room);
    }
    this.pinched = this.pinch.update(this.#pinchWidth());
  }

  /** `fillPoses` is all or nothing: a joint that is lost must not lose the others. */
  #readOneByOne(frame: XRFrame, room: XRReferenceSpace): void {
    this.#spaces.forEach((space, joint) => {
      const pose = frame.getJointPose?.(space, room);
      if (pose) this.poses.set(pose.transform.matrix, 16 * joint);
      else this.poses.fill(Number.NaN, 16 * joint, 16 * joint + 16);
      this.radii[joint] = pose?.radius ?? Number.NaN;
    });
  }

  /** Shift the fingertips by what calibration has found them to be off, in their own frames. */
  mendTips(offset: Vector3, foundOnSide: 0 | 1): void {
    // What is off to the thumb's side in one hand is so in the other, too, which is its mirror.
    const mirror = foundOnSide === this.side ? 1 : -1;
    const [x, y, z] = [mirror * offset.x, offset.y, offset.z];
    for (const tip of TIPS) {
      const o = 16 * tip;
      for (let k = 0; k < 3; k++) {
        this.poses[o + 12 + k]! -=
          this.poses[o + k]! * x + this.poses[o + 4 + k]! * y + this.poses[o + 8 + k]! * z;
      }
    }
  }

  joint(joint: number, out: Vector3): Vector3 {
    return out.fromArray(this.poses, 16 * joint + 12);
  }

  radius(joint: number): number {
    const radius = this.radii[joint]!;
    return Number.isFinite(radius) && radius > 0 ? radius : 0.008;
  }

  /** The index fingertip as a sample of a touch. */
  sample(time: number): Contact {
    matrix.fromArray(this.poses, 16 * INDEX_TIP);
    return {
      tip: this.joint(INDEX_TIP, new Vector3()),
      turn: new Quaternion().setFromRotationMatrix(matrix),
      radius: this.radius(INDEX_TIP),
      time,
    };
  }

  #pinchWidth(): number {
    return this.joint(TIPS[0], thumb).distanceTo(this.joint(INDEX_TIP, index));
  }
}

const matrix = new Matrix4();
const thumb = new Vector3();
const index = new Vector3();
