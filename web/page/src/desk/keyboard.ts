import type { Mouse, Pointer } from "./mouse.js";
import type { Stage } from "./stage.js";

const TURN = Math.PI / 36;
const NEARER = 1.08;
/** Pixels. */
const STEP = 8;

/** The view turned, and the hand moved, without a mouse; see the stage's label for the keys. */
export function listenToKeys(stage: Stage, mouse: Mouse): void {
  const middle = (): Pointer => {
    const pane = stage.split ? stage.felt : stage.seen;
    const box = pane.element.getBoundingClientRect();
    return { pane, clientX: box.left + box.width / 2, clientY: box.top + box.height / 2 };
  };
  stage.element.tabIndex = 0;
  stage.element.addEventListener("keydown", (event) => {
    const way = WAYS[event.key];
    if (way && event.shiftKey) {
      const { pane, clientX, clientY } = mouse.last ?? middle();
      mouse.put({ pane, clientX: clientX + STEP * way[0], clientY: clientY + STEP * way[1] });
    } else if (way) {
      stage.orbit.rotateLeft(-TURN * way[0]);
      stage.orbit.rotateUp(-TURN * way[1]);
    } else if (event.key === "+" || event.key === "=") stage.nearer(1 / NEARER);
    else if (event.key === "-") stage.nearer(NEARER);
    else if (event.key === "0") stage.home();
    else return;
    event.preventDefault();
    stage.draw();
  });
}

const WAYS: Readonly<Record<string, readonly [number, number]>> = {
  ArrowLeft: [-1, 0],
  ArrowRight: [1, 0],
  ArrowUp: [0, -1],
  ArrowDown: [0, 1],
};
