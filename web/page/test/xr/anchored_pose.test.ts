import { Matrix4, Quaternion, Vector3 } from "three";
import { describe, expect, it } from "vitest";
import { Pose } from "../../src/calibrate/pose.js";
import { AnchoredPose } from "../../src/xr/anchored_pose.js";

Object.assign(globalThis, {
  XRRigidTransform: class {
    constructor(
      readonly position: object,
      readonly orientation: object,
    ) {}
  },
});

const room = {} as XRReferenceSpace;
const found = new Pose(
  new Quaternion().setFromAxisAngle(new Vector3(0, 1, 0), 0.4),
  new Vector3(0.1, 0.8, -0.3),
);

/** A device that moves its anchors to wherever `where` says. */
class Device {
  where = found.matrix(new Matrix4());
  anchors = new Set<object>();
  asked = 0;
  sees = true;
  frame(anchors = true): XRFrame {
    const createAnchor = () => {
      this.asked++;
      const anchor = { anchorSpace: {}, delete: () => this.anchors.delete(anchor) };
      this.anchors.add(anchor);
      return Promise.resolve(anchor);
    };
    const getPose = () => (this.sees ? { transform: { matrix: this.where.toArray() } } : null);
    return {
      ...(anchors ? { createAnchor, trackedAnchors: this.anchors } : {}),
      getPose,
    } as unknown as XRFrame;
  }
}

const settle = () => new Promise((resolve) => setTimeout(resolve));
const far = (one: Pose, other: Pose) =>
  one.place.distanceTo(other.place) + one.turn.angleTo(other.turn);

describe("a pose", () => {
  it("is held by an anchor, and goes where the device moves it", async () => {
    const device = new Device();
    const anchored = new AnchoredPose();
    anchored.set(found);
    expect(far(anchored.now(device.frame(), room), found)).toBeLessThan(1e-7);
    await settle();
    expect(anchored.held).toBe(true);
    device.where.premultiply(new Matrix4().makeTranslation(0, 0, 0.02));
    expect(anchored.now(device.frame(), room).place.z).toBeCloseTo(-0.28, 6);
    device.sees = false; // the last one is kept
    expect(anchored.now(device.frame(), room).place.z).toBeCloseTo(-0.28, 6);
    expect(device.asked).toBe(1);
  });

  it("that is found anew gets an anchor of its own, and the old one goes", async () => {
    const device = new Device();
    const anchored = new AnchoredPose();
    for (let k = 0; k < 3; k++) {
      anchored.set(found);
      anchored.now(device.frame(), room);
      await settle();
    }
    expect([device.asked, device.anchors.size]).toEqual([3, 1]);
  });

  it("whose anchor comes too late is not moved by it", async () => {
    const device = new Device();
    const anchored = new AnchoredPose();
    anchored.set(found);
    anchored.now(device.frame(), room);
    anchored.set(found.moved(new Vector3(), new Vector3(), new Vector3(1, 0, 0)));
    await settle();
    expect([anchored.held, device.anchors.size]).toEqual([false, 0]);
  });

  it("stays when the device gives up its anchor", async () => {
    const device = new Device();
    const anchored = new AnchoredPose();
    anchored.set(found);
    anchored.now(device.frame(), room);
    await settle();
    device.anchors.clear();
    device.where.setPosition(9, 9, 9);
    expect(far(anchored.now(device.frame(), room), found)).toBeLessThan(1e-7);
    expect(anchored.held).toBe(false);
  });

  it("without an anchor goes along when the room's origin moves", async () => {
    const device = new Device();
    const anchored = new AnchoredPose();
    anchored.set(found);
    anchored.now(device.frame(false), room);
    await settle();
    const T_before_now = new Matrix4().makeRotationY(0.7).setPosition(0.3, 0, -0.2);
    anchored.originMoved(T_before_now);
    const now = anchored.now(device.frame(false), room);
    // seen from where the origin was, the prop has not moved
    const before = now.toRoom(new Vector3(0.02, 0.03, 0.04)).applyMatrix4(T_before_now);
    expect(before.distanceTo(found.toRoom(new Vector3(0.02, 0.03, 0.04)))).toBeLessThan(1e-7);
  });
});
