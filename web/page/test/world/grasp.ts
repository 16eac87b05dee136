import { Matrix4, Vector3 } from "three";
import { seeded } from "../calibrate/rubbing.js";

/** m, right hand, palm down, fingers along −z, in the wrist's frame: knuckles, bones after them. */
const KNUCKLES = [
  [-0.025, 0, -0.095],
  [-0.004, 0.002, -0.1],
  [0.016, 0, -0.093],
  [0.034, -0.004, -0.083],
] as const;
const BONES = [
  [0.044, 0.034, 0.026],
  [0.042, 0.025, 0.022],
  [0.047, 0.029, 0.023],
  [0.043, 0.027, 0.023],
  [0.034, 0.02, 0.02],
] as const;
const TIPS = [4, 9, 14, 19, 24];

const RATE = 90;

/** A grasp at 90 frames a second: to a ball about the origin, around it, and back. */
export function* grasp(seconds = 3): Generator<{ time: number; poses: Float32Array }> {
  const random = seeded(11);
  const kept = Math.exp(-1 / (0.05 * RATE));
  const noise = new Array<number>(6).fill(0);
  for (let frame = 0; frame < seconds * RATE; frame++) {
    const time = frame / RATE;
    const near = 0.5 - 0.5 * Math.cos((2 * Math.PI * time) / seconds);
    // of tracking, 0.3 mm and 3 mrad, lasting 50 ms
    for (let n = 0; n < 6; n++) {
      const drive = Math.sqrt(12 * (1 - kept * kept)) * (random() - 0.5);
      noise[n] = kept * noise[n]! + (n < 3 ? 3e-4 : 3e-3) * drive;
    }
    const hand = jointsOf(
      (finger) => 0.15 + 0.45 * near + 0.1 * Math.sin(3 * time + finger),
      (finger) => 0.1 * Math.sin(time + finger),
    );
    const tips = TIPS.reduce(
      (sum, tip) => sum.add(new Vector3().setFromMatrixPosition(hand[tip]!)),
      new Vector3(),
    ).divideScalar(5);
    const back = new Vector3(-Math.sin(0.7 * time), 0.3, 1 - 0.2 * time).normalize();
    const right = new Vector3(0.1, 1, 0.2).cross(back).normalize();
    const wrist = new Matrix4().makeBasis(right, back.clone().cross(right), back);
    wrist.multiply(new Matrix4().makeRotationZ(0.5 * Math.sin(time)));
    wrist.setPosition(back.multiplyScalar(0.23 - 0.21 * near).sub(tips.applyMatrix4(wrist)));
    wrist.multiply(new Matrix4().makeTranslation(noise[0]!, noise[1]!, noise[2]!));
    wrist.multiply(new Matrix4().makeRotationX(noise[3]!));
    wrist.multiply(new Matrix4().makeRotationY(noise[4]!));
    wrist.multiply(new Matrix4().makeRotationZ(noise[5]!));
    const poses = new Float32Array(16 * 25);
    hand.forEach((joint, n) => {
      joint.premultiply(wrist).toArray(poses, 16 * n);
    });
    yield { time, poses };
  }
}

/** T_wrist_joint of all 25, by flexion of each finger's joints and spread at its base, rad. */
function jointsOf(bend: (finger: number) => number, spread: (finger: number) => number) {
  const joints = [new Matrix4()];
  for (let finger = 0; finger < 5; finger++) {
    const base = new Matrix4();
    const knuckle = KNUCKLES[finger - 1];
    if (knuckle === undefined) {
      base.makeRotationX(-0.3).multiply(new Matrix4().makeRotationZ(-0.9));
      base.multiply(new Matrix4().makeRotationY(spread(0)));
      base.multiply(new Matrix4().makeRotationX(-bend(0)));
      base.setPosition(-0.022, -0.012, -0.03);
    } else {
      joints.push(new Matrix4().makeTranslation(0.4 * knuckle[0], 0, -0.03)); // metacarpal
      base.makeRotationX(-bend(finger));
      base.multiply(new Matrix4().makeRotationY(spread(finger)));
      base.setPosition(knuckle[0], knuckle[1], knuckle[2]);
    }
    joints.push(base);
    let at = base;
    BONES[finger]!.forEach((length, n) => {
      const turn = new Matrix4().makeRotationX(n < 2 ? -bend(finger) : 0);
      at = at.clone().multiply(turn.setPosition(0, 0, -length));
      joints.push(at);
    });
  }
  return joints;
}
