import type { Vector3 } from "three";
import type { Contact } from "./contact.js";
import type { Pose } from "./pose.js";
import { type ContactSurface, SurfaceFoot } from "./surface.js";

/** How many fresh touches verify a calibration, and how far apart they have to be, m. */
export const VERIFY_TOUCHES = 5;
const APART = 0.015;

/** What fresh touches say of a calibrated pose, m. */
export interface Verification {
  readonly gaps: readonly number[];
  readonly median: number;
  readonly worst: number;
  readonly passed: boolean;
}

/** Greatest gaps of a calibration that is used, m. */
export interface VerifyLimits {
  readonly median: number;
  readonly worst: number;
}

export const VERIFY_LIMITS: VerifyLimits = { median: 0.006, worst: 0.015 };

/** Gap between the skin of a fingertip and the prop, m; negative when the skin is inside. */
export function gapOf(
  surface: ContactSurface,
  pose: Pose,
  tipOffset: Vector3,
  touch: Contact,
): number {
  const tip = tipOffset.clone().applyQuaternion(touch.turn).negate().add(touch.tip);
  return surface.nearest(pose.toProp(tip), new SurfaceFoot()).distance - touch.radius;
}

/** Whether a touch is at another place than those before it. */
export function isFresh(touches: readonly Contact[], touch: Contact): boolean {
  return touches.every(({ tip }) => tip.distanceTo(touch.tip) > APART);
}

/** The verdict of the touches; null until there are enough. */
export function verify(
  surface: ContactSurface,
  pose: Pose,
  tipOffset: Vector3,
  touches: readonly Contact[],
  limits = VERIFY_LIMITS,
): Verification | null {
  if (touches.length < VERIFY_TOUCHES) return null;
  const gaps = touches.map((touch) => gapOf(surface, pose, tipOffset, touch));
  const sizes = gaps.map(Math.abs).sort((one, other) => one - other);
  const median = sizes[sizes.length >> 1]!;
  const worst = sizes[sizes.length - 1]!;
  return { gaps, median, worst, passed: median <= limits.median && worst <= limits.worst };
}
