import { findProp } from "./find.js";
import { type PackedFinding, type PackedTask, packFinding, unpackContacts } from "./packing.js";
import { ContactSurface } from "./surface.js";
import type { SurfaceGoal } from "./symmetry.js";

/** A registration takes tenths of a second, in which the page must go on drawing: it is done here. */
export interface ToWorker {
  /** The prop, first. */
  readonly prop?: { positions: Float32Array; faces: Uint32Array; virtual: Float32Array };
  readonly task?: PackedTask;
}

let goal: SurfaceGoal | null = null;

self.onmessage = ({ data: { prop, task } }: MessageEvent<ToWorker>) => {
  if (prop) {
    goal = { surface: new ContactSurface(prop.positions, prop.faces), virtual: prop.virtual };
    goal.surface.field; // the grid is made now, so that the first touches need not wait for it
  }
  if (task && goal) {
    const finding = findProp(goal, unpackContacts(task.contacts), task.freedom);
    self.postMessage(packFinding(finding) satisfies PackedFinding);
  }
};
