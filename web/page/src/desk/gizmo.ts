import { Box3, Euler, MathUtils, Matrix4, Mesh, Object3D, Quaternion, Vector3 } from "three";
import { TransformControls } from "three/examples/jsm/controls/TransformControls.js";
import type { Placement } from "../live/messages.js";
import { SEEN, showIn, TOGETHER } from "./layers.js";
import type { PropObject } from "./objects.js";
import type { Stage } from "./stage.js";

export type GizmoMode = "translate" | "rotate" | "scale";

const LEAST_SCALE = 0.05;
const SIZE = 0.7;
/** How far the handles reach, as a share of half the view's height: 0.6 of three's own unit. */
export const HANDLES_REACH = 0.6 * SIZE * (1.9 / 4);

/** Moves, turns and scales one virtual object about its goal's pivot. */
export class Gizmo {
  readonly controls: TransformControls;
  prop: PropObject | null = null;
  /** Called while dragging, at display rate, and once at its end. */
  changed: (prop: PropObject, placement: Placement, ended: boolean) => void = () => {};
  /** pivot + translation, R and S: three's own order T·R·S is the goal's. */
  #object = new Object3D();

  constructor(readonly stage: Stage) {
    this.controls = new TransformControls(stage.camera, stage.seen.element);
    this.controls.setSize(SIZE);
    this.controls.setColors(0xd4301c, 0x2e8b57, 0x6a4fb0, 0xe08a1e);
    dropBackwardArrows(this.controls.getHelper());
    stage.scene.add(this.#object);
    const helper = this.controls.getHelper();
    showIn(helper, [SEEN, TOGETHER]);
    stage.scene.add(helper);
    this.controls.getRaycaster().layers.enableAll();
    this.controls.addEventListener("change", () => stage.draw());
    this.controls.addEventListener("dragging-changed", (event) => {
      stage.orbit.enabled = !event.value;
      if (!event.value) this.#tell(true);
    });
    this.controls.addEventListener("objectChange", () => this.#tell(false));
  }

  get dragging(): boolean {
    return this.controls.dragging;
  }

  get mode(): GizmoMode {
    return this.controls.mode as GizmoMode;
  }

  set mode(mode: GizmoMode) {
    this.controls.setMode(mode);
    this.stage.draw();
  }

  /** Attach to a prop's virtual object; null, or one whose goal is not written so, detaches. */
  attach(prop: PropObject | null): void {
    const placement = prop?.state.placement ?? null;
    this.prop = placement === null ? null : prop;
    if (this.prop === null || placement === null) {
      this.controls.detach();
    } else {
      place(this.#object, this.prop.state.pivot, placement);
      this.controls.attach(this.#object);
    }
    this.stage.draw();
  }

  /** Put the virtual object somewhere, as typed or taken back. */
  set(placement: Placement, ended: boolean): void {
    if (this.prop === null) return;
    place(this.#object, this.prop.state.pivot, placement);
    if (ended) this.#tell(true);
  }

  #tell(ended: boolean): void {
    if (this.prop === null) return;
    const { scale } = this.#object;
    for (const axis of ["x", "y", "z"] as const) {
      scale[axis] = Math.max(LEAST_SCALE, scale[axis]);
    }
    this.changed(this.prop, placementOf(this.#object, this.prop.state.pivot), ended);
  }
}

/** The arrows that look against an axis only crowd the view: the others are dragged either way. */
function dropBackwardArrows(helper: Object3D): void {
  const backward: Object3D[] = [];
  helper.traverse((part) => {
    if (!(part instanceof Mesh) || !["X", "Y", "Z"].includes(part.name)) return;
    const middle = new Box3().setFromBufferAttribute(part.geometry.attributes.position);
    const { x, y, z } = middle.getCenter(new Vector3());
    if (Math.min(x, y, z) < -0.25) backward.push(part);
  });
  for (const part of backward) part.removeFromParent();
}

/** R = Rz·Ry·Rx, which three calls the order ZYX. */
function place(object: Object3D, pivot: readonly number[], placement: Placement): void {
  const [x, y, z] = placement.rotation_deg.map(MathUtils.degToRad) as [number, number, number];
  object.quaternion.setFromEuler(new Euler(x, y, z, "ZYX"));
  object.scale.set(...placement.scale);
  object.position.copy(middleOf(pivot, placement));
  object.updateMatrixWorld();
}

/** Where the gizmo stands: the pivot, moved along. */
export function middleOf(pivot: readonly number[], placement: Placement): Vector3 {
  return new Vector3().fromArray(pivot).add(new Vector3(...placement.translation));
}

function placementOf(object: Object3D, pivot: readonly number[]): Placement {
  const turn = new Euler().setFromQuaternion(object.quaternion, "ZYX");
  const from = new Vector3(pivot[0], pivot[1], pivot[2]);
  const move = object.position.clone().sub(from);
  return {
    scale: object.scale.toArray().map((v) => rounded(v, 4)) as [number, number, number],
    rotation_deg: [turn.x, turn.y, turn.z].map((v) => rounded(MathUtils.radToDeg(v), 3)) as [
      number,
      number,
      number,
    ],
    translation: move.toArray().map((v) => rounded(v, 5)) as [number, number, number],
  };
}

/** The goal of a placement as a matrix: pivot + translation + R·S·(x − pivot). */
export function goalOf(pivot: readonly number[], placement: Placement): Float64Array {
  const object = new Object3D();
  place(object, pivot, placement);
  const back = new Matrix4().makeTranslation(-pivot[0]!, -pivot[1]!, -pivot[2]!);
  const M = new Matrix4().compose(
    object.position,
    new Quaternion().copy(object.quaternion),
    object.scale,
  );
  return Float64Array.from(M.multiply(back).elements);
}

function rounded(value: number, digits: number): number {
  return Number(value.toFixed(digits)) + 0;
}
