import { Vector3 } from "three";
import type { Contact } from "./contact.js";
import type { Fit, Task } from "./register.js";
import { SurfaceFoot } from "./surface.js";

/**
 * The contacts, their skin as far from the tip's centre as noise makes it seem on average.
 *
 * Noise to the side of a curved surface leads away from it whichever way it goes: with p noisy by σ
 * on each axis, E d(p) = d + ½ σ² ∇²d to second order. On a rim of 4 mm, 3 mm of noise are taken for
 * a fifth of a millimetre of distance, always upwards, which no number of touches would average away.
 * The mean is taken over the six places ±√3 σ beside p (as a third-degree cubature has it), so that
 * it is right at edges, too.
 */
export function swollen({ surface, contacts }: Task, { pose, tipOffset, scale }: Fit): Contact[] {
  const step = Math.sqrt(3) * scale;
  return contacts.map((contact) => {
    tip.copy(tipOffset).applyQuaternion(contact.turn).negate().add(contact.tip);
    pose.toProp(tip, tip);
    const distance = surface.nearest(tip, foot).distance;
    let sum = 0;
    for (let axis = 0; axis < 3; axis++) {
      for (const way of [step, -step]) {
        beside.copy(tip).setComponent(axis, tip.getComponent(axis) + way);
        sum += surface.nearest(beside, foot).distance - distance;
      }
    }
    return { ...contact, radius: contact.radius + sum / 6 };
  });
}

const tip = new Vector3();
const beside = new Vector3();
const foot = new SurfaceFoot();
