import type { Object3D } from "three";

/** Which panes show an object: what is felt, what is seen, or both laid over each other. */
export const FELT = 1;
export const SEEN = 2;
export const TOGETHER = 3;
export const ALL = [FELT, SEEN, TOGETHER] as const;

/** Show an object, with all below it, in these panes only. */
export function showIn(object: Object3D, panes: readonly number[]): void {
  object.traverse((part) => {
    part.layers.disableAll();
    for (const pane of panes) part.layers.enable(pane);
  });
}
