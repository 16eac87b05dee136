import { Vector3 } from "three";
import { calibrate } from "./assess.js";
import { type Contact, HEADSET_HANDS } from "./contact.js";
import { nextTouch } from "./nextTouch.js";
import type { Finding } from "./packing.js";
import type { Freedom } from "./pose.js";
import type { Task } from "./register.js";
import { doubtIsHarmless, type SurfaceGoal } from "./symmetry.js";

const UP = new Vector3(0, 1, 0);

/** Where a prop stands in the headset's room, how well that is known, and what to touch next. */
export function findProp(
  goal: SurfaceGoal,
  contacts: readonly Contact[],
  freedom: Freedom,
): Finding {
  const task: Task = {
    surface: goal.surface,
    contacts,
    freedom,
    up: UP,
    tracking: HEADSET_HANDS,
  };
  const calibration = calibrate(task);
  if (calibration === null) return { calibration, suggestion: null, harmless: false };
  return {
    calibration,
    suggestion: nextTouch(task, calibration),
    harmless: calibration.doubts.length === 0 || doubtIsHarmless(goal, calibration),
  };
}
