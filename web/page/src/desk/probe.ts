import { Box3, Matrix4, Plane, type Ray, Raycaster, Vector3 } from "three";
import type { Warp } from "touchwarp";
import { HandPicture } from "../world/hand_picture.js";
import { INDEX_TIP, pointingPoses, pointingRadii } from "../world/pointing_hand.js";
import { FELT, SEEN, showIn, TOGETHER } from "./layers.js";
import type { PropObject } from "./objects.js";
import type { Pane, Stage } from "./stage.js";

/** What of the probe the panel tells. */
export interface Reading {
  /** |u| at the fingertip, mm. */
  readonly mismatch: number;
  readonly touching: string | null;
}

/** A hand that follows the mouse: over what is felt it is the real one, over what is seen the displayed one. */
export class Probe {
  readonly real = new HandPicture(0xd9a07a);
  readonly displayed = new HandPicture(0xd9a07a);
  readonly ghost = new HandPicture(0x3a4654, 0.22);
  reading: Reading | null = null;
  /** Beyond it no table is touched. */
  readonly reach = new Box3();
  pinned = false;

  readonly realPoses = pointingPoses();
  readonly displayedPoses = pointingPoses();
  readonly radii = pointingRadii;
  #local = pointingPoses();
  #tip = new Vector3();
  #normal = new Vector3(0, 0, 1);
  #touching: string | null = null;
  #known = false;

  constructor(readonly stage: Stage) {
    showIn(this.real, [FELT]);
    showIn(this.displayed, [SEEN, TOGETHER]);
    showIn(this.ghost, [SEEN, TOGETHER]);
    stage.scene.add(this.real, this.displayed, this.ghost);
    this.visible = false;
  }

  set visible(visible: boolean) {
    this.real.visible = this.displayed.visible = this.ghost.visible = visible;
  }

  get visible(): boolean {
    return this.real.visible;
  }

  /** Where the index fingertip's skin really is, and where it is displayed. */
  get tips(): { real: Vector3; displayed: Vector3 } {
    return { real: this.#skin(this.realPoses), displayed: this.#skin(this.displayedPoses) };
  }

  /** Follow the mouse: the fingertip touches what is under it, or stays at its depth in the air. */
  follow(
    pane: Pane,
    ray: Ray,
    props: readonly PropObject[],
    warp: Warp | null,
    tables: readonly Plane[],
  ): void {
    if (this.pinned) return;
    const overSeen = pane.layer !== FELT;
    const hit = touch(ray, props, tables, overSeen, this.reach);
    const place = hit?.place ?? this.#inAir(ray);
    if (place === null) return;
    let normal = hit?.normal ?? this.stage.camera.position.clone().sub(place).normalize();
    let real = place;
    if (overSeen && warp !== null) {
      const out = new Float64Array(3);
      if (warp.inverse(Float64Array.from(place.toArray()), out) === 1) {
        real = new Vector3(out[0], out[1], out[2]);
      }
    }
    if (hit === null) normal = this.#normal.clone().lerp(normal, 0.1).normalize();
    this.#touching = hit?.name ?? null;
    this.#put(real, normal);
    this.update(warp);
  }

  /** Touch a place, from the side of its normal. */
  touch(place: Vector3, normal: Vector3, name: string, warp: Warp | null): void {
    this.#touching = name;
    this.#put(place, normal);
    this.update(warp);
  }

  /** Display the hand anew, with the warp as it now is. */
  update(warp: Warp | null): void {
    if (!this.#known) return;
    display(warp, this.realPoses, this.displayedPoses, this.#tip);
    this.real.place(this.realPoses, this.radii, 16, 12);
    this.ghost.place(this.realPoses, this.radii, 16, 12);
    this.displayed.place(this.displayedPoses, this.radii, 16, 12);
    const { real, displayed } = this.tips;
    this.reading = { mismatch: 1e3 * real.distanceTo(displayed), touching: this.#touching };
  }

  #skin(poses: Float32Array): Vector3 {
    const tip = new Vector3().fromArray(poses, 16 * INDEX_TIP + 12);
    return tip.addScaledVector(this.#normal, -this.radii[INDEX_TIP]!);
  }

  #inAir(ray: Ray): Vector3 | null {
    const facing = this.stage.camera.getWorldDirection(new Vector3()).negate();
    const through = this.#known ? this.#tip : this.stage.orbit.target;
    return ray.intersectPlane(
      new Plane().setFromNormalAndCoplanarPoint(facing, through),
      new Vector3(),
    );
  }

  /** The whole hand, its fingertip's skin at a place: the finger leans to the viewer's left. */
  #put(skin: Vector3, normal: Vector3): void {
    this.#known = true;
    this.#tip.copy(skin);
    this.#normal.copy(normal);
    // from the viewer's right, as a right hand does: so it hides little of what it touches
    const into = new Vector3()
      .setFromMatrixColumn(this.stage.camera.matrixWorld, 0)
      .multiplyScalar(-1);
    into.addScaledVector(this.stage.camera.getWorldDirection(new Vector3()), 0.45);
    into.addScaledVector(normal, -into.dot(normal));
    if (into.lengthSq() < 1e-6) into.set(0, 1, 0).addScaledVector(normal, -normal.y);
    const finger = into.normalize().multiplyScalar(0.72).addScaledVector(normal, -0.69).normalize();
    const back = normal.clone().addScaledVector(finger, -normal.dot(finger)).normalize();
    if (back.z < -0.2) back.negate(); // from below: the palm still looks down
    const side = new Vector3().crossVectors(back, finger.clone().negate());
    const T = new Matrix4().makeBasis(side, back, finger.clone().negate());
    const tip = new Vector3().fromArray(this.#local, 16 * INDEX_TIP + 12).applyMatrix4(T);
    const centre = skin.clone().addScaledVector(normal, this.radii[INDEX_TIP]!);
    T.setPosition(centre.sub(tip));
    const joint = new Matrix4();
    for (let n = 0; n < 25; n++) {
      joint
        .fromArray(this.#local, 16 * n)
        .premultiply(T)
        .toArray(this.realPoses, 16 * n);
    }
  }
}

/** The index finger leads by its skin, and the hand follows as a whole. */
function display(warp: Warp | null, real: Float32Array, out: Float32Array, skin: Vector3): void {
  const move = new Float64Array(3);
  if (warp !== null) warp.displacement(Float64Array.from(skin.toArray()), move);
  out.set(real);
  for (let n = 0; n < 25; n++) {
    for (let d = 0; d < 3; d++) out[16 * n + 12 + d]! += move[d]!;
  }
}

interface Hit {
  readonly place: Vector3;
  readonly normal: Vector3;
  readonly name: string;
  readonly distance: number;
}

function touch(
  ray: Ray,
  props: readonly PropObject[],
  tables: readonly Plane[],
  seen: boolean,
  reach: Box3,
): Hit | null {
  const caster = new Raycaster(ray.origin, ray.direction);
  caster.layers.enableAll();
  const meshes = props.map((object) => (seen ? object.virtual : object.prop));
  let best: Hit | null = null;
  for (const found of caster.intersectObjects(meshes, false).slice(0, 1)) {
    const normal = found.face!.normal.clone().transformDirection(found.object.matrixWorld);
    if (normal.dot(ray.direction) > 0) normal.negate();
    const name = props[meshes.indexOf(found.object as PropObject["prop"])]!.state.name;
    best = { place: found.point, normal, name, distance: found.distance };
  }
  for (const table of tables) {
    const place = ray.intersectPlane(table, new Vector3());
    if (place === null || !reach.containsPoint(place)) continue;
    const distance = place.distanceTo(ray.origin);
    if (distance < (best?.distance ?? Number.POSITIVE_INFINITY)) {
      best = { place, normal: table.normal.clone(), name: "table", distance };
    }
  }
  return best;
}
