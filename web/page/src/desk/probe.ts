import { Box3, Matrix4, Plane, Quaternion, type Ray, Raycaster, Vector3 } from "three";
import type { Warp } from "touchwarp";
import { DisplayedHand } from "../world/displayed_hand.js";
import { HandPicture } from "../world/hand_picture.js";
import { FollowedPoints, PlacedSurfaces } from "../world/nearest.js";
import { pointingPoses, pointingRadii } from "../world/pointing_hand.js";
import { FELT, SEEN, showIn, TOGETHER } from "./layers.js";
import type { PropObject } from "./objects.js";
import { placed, reach, type Surroundings } from "./reach.js";
import type { Pane, Stage } from "./stage.js";

/** What of the probe the page tells. */
export interface Reading {
  /** |u| at the fingertip, mm; null where there is no warp yet. */
  readonly mismatch: number | null;
  readonly touching: string | null;
}

const SKIN = 0xd9a98a;
/** Seconds in which the hand turns most of the way to how it comes to a new place. */
const TURNING = 0.09;
const TURNED = 0.005;

/**
 * A whole hand that follows the mouse: over what is felt it is the real one, over what is seen the
 * displayed one. Its index fingertip touches; it is displayed as in the headset, on rigid bones.
 */
export class Probe {
  readonly real = new HandPicture(SKIN);
  readonly displayed = new HandPicture(SKIN);
  readonly ghost = new HandPicture(0x5a626c, 0.3);
  reading: Reading | null = null;
  /** Beyond it no table is touched. */
  readonly reach = new Box3();
  /** Whether other hands are shown instead. */
  #away = false;

  readonly realPoses = pointingPoses();
  readonly radii = pointingRadii;
  #hand = new DisplayedHand(new PlacedSurfaces([]), 0);
  #props: readonly PropObject[] = [];
  #tables: readonly Plane[] = [];
  #local = pointingPoses();
  #skin = new Vector3();
  #normal = new Vector3(0, 0, 1);
  #turn: Quaternion | null = null;
  #goal = new Quaternion();
  #eased = 0;
  #touching: string | null = null;

  constructor(readonly stage: Stage) {
    showIn(this.real, [FELT]);
    showIn(this.displayed, [SEEN, TOGETHER]);
    showIn(this.ghost, [SEEN, TOGETHER]);
    stage.scene.add(this.real, this.displayed, this.ghost);
    this.#show(false);
  }

  get visible(): boolean {
    return this.real.visible;
  }

  /** Whether the hand still turns towards how it comes to its place. */
  get turning(): boolean {
    return this.#turn !== null && this.#turn.angleTo(this.#goal) >= TURNED;
  }

  /** The displayed joints, 25 × 16. */
  get displayedPoses(): Float32Array {
    return this.#hand.poses;
  }

  /** How far the displayed fingertips are from where they should be, m. */
  get tipErrors(): Float64Array {
    return this.#hand.tipErrors;
  }

  /** What can be touched. */
  furnish(props: readonly PropObject[], tables: readonly Plane[]): void {
    this.#props = props;
    this.#tables = tables;
    this.#hand = new DisplayedHand(new PlacedSurfaces(props.map((prop) => prop.contact)), 0);
  }

  /** Follow the mouse: the fingertip touches what is under it, or stays at its depth in the air. */
  follow(pane: Pane, ray: Ray, warp: Warp | null): void {
    if (this.#away) return;
    const overSeen = pane.layer !== FELT;
    const hit = this.#hit(ray, overSeen);
    const at = hit?.place ?? this.#inAir(ray);
    if (at === null) return;
    let skin = at;
    if (overSeen && warp !== null) {
      const out = new Float64Array(3);
      if (warp.inverse(Float64Array.from(at.toArray()), out) === 1) {
        skin = new Vector3(out[0], out[1], out[2]);
      }
    }
    let normal = hit?.normal ?? this.#towardsEye(at).lerp(this.#normal, 0.9).normalize();
    if (hit !== null && overSeen && hit.name !== TABLE) normal = this.#normalOfProp(skin, normal);
    this.touch(skin, normal, hit?.name ?? null, warp);
  }

  /** Touch a place (or point at one, where `name` is null), coming from the side of its normal. */
  touch(skin: Vector3, normal: Vector3, name: string | null, warp: Warp | null): void {
    this.#skin.copy(skin);
    this.#normal.copy(normal);
    this.#touching = name;
    const before = this.#turn && new Matrix4().makeRotationFromQuaternion(this.#goal);
    const turn = reach(this.#local, this.radii, skin, normal, this.#surroundings(), before);
    this.#goal.setFromRotationMatrix(turn);
    this.#turn ??= this.#goal.clone();
    this.#show(true);
    this.update(warp);
  }

  /** The hand is there before the mouse is: at the side of the first prop that looks this way. */
  touchFirst(): void {
    const prop = this.#props[0];
    if (prop === undefined || this.visible) return;
    const box = new Box3().setFromObject(prop.prop);
    const aim = box.getCenter(new Vector3()).setZ(0.35 * box.min.z + 0.65 * box.max.z);
    const ray = this.stage.ray(this.stage.felt, { clientX: 0, clientY: 0 });
    ray.origin.copy(this.stage.camera.position);
    ray.direction.copy(aim.sub(ray.origin).normalize());
    this.follow(this.stage.felt, ray, null);
  }

  /** Turn on towards how the hand comes to its place; whether there is still a way to go. */
  ease(time: number, warp: Warp | null): boolean {
    const elapsed = Math.min(Math.max(time - this.#eased, 0), 100) / 1e3;
    this.#eased = time;
    if (this.#away || this.#turn === null || !this.turning) return false;
    this.#turn.slerp(this.#goal, 1 - Math.exp(-elapsed / TURNING));
    this.update(warp);
    return true;
  }

  /** Display the hand anew, with the warp as it now is. */
  update(warp: Warp | null): void {
    if (this.#turn === null || this.#away) return;
    const turn = new Matrix4().makeRotationFromQuaternion(this.#turn);
    const T = placed(this.#local, this.radii, turn, this.#skin, this.#normal);
    const joint = new Matrix4();
    for (let n = 0; n < 25; n++) {
      joint
        .fromArray(this.#local, 16 * n)
        .premultiply(T)
        .toArray(this.realPoses, 16 * n);
    }
    this.#hand.update(warp, this.realPoses, this.radii, 0);
    this.real.place(this.realPoses, this.radii, 16, 12);
    this.ghost.place(this.realPoses, this.radii, 16, 12);
    this.displayed.place(this.displayedPoses, this.radii, 16, 12);
    const index = this.#touching === null ? 0 : 1 << 1;
    for (const hand of [this.real, this.displayed]) hand.touch(index);
    this.reading = { mismatch: this.#mismatch(warp), touching: this.#touching };
  }

  /** Take the hand away, and bring it back. */
  set away(away: boolean) {
    this.#away = away;
    this.#show(!away && this.#turn !== null);
    this.reading = null;
  }

  #mismatch(warp: Warp | null): number | null {
    if (warp === null) return null;
    const u = new Float64Array(3);
    warp.displacement(Float64Array.from(this.#skin.toArray()), u);
    return 1e3 * Math.hypot(...u);
  }

  #show(visible: boolean): void {
    this.real.visible = this.displayed.visible = this.ghost.visible = visible;
  }

  #surroundings(): Surroundings {
    const { camera } = this.stage;
    return {
      surfaces: this.#props.map((prop) => prop.contact),
      tables: this.#tables,
      right: new Vector3().setFromMatrixColumn(camera.matrixWorld, 0),
      ahead: camera.getWorldDirection(new Vector3()),
    };
  }

  #towardsEye(place: Vector3): Vector3 {
    return this.stage.camera.position.clone().sub(place).normalize();
  }

  #inAir(ray: Ray): Vector3 | null {
    const facing = this.stage.camera.getWorldDirection(new Vector3()).negate();
    const through = this.#turn === null ? this.stage.orbit.target : this.#skin;
    const plane = new Plane().setFromNormalAndCoplanarPoint(facing, through);
    return ray.intersectPlane(plane, new Vector3());
  }

  /** The prop's own normal at a place that was found from the virtual side. */
  #normalOfProp(place: Vector3, otherwise: Vector3): Vector3 {
    const surfaces = this.#props.map((prop) => prop.contact);
    const { gradient } = new FollowedPoints(surfaces, 1).find(0, place);
    return gradient.dot(otherwise) < 0 ? otherwise : gradient;
  }

  #hit(ray: Ray, seen: boolean): Hit | null {
    const caster = new Raycaster(ray.origin, ray.direction);
    caster.layers.enableAll();
    const meshes = this.#props.map((object) => (seen ? object.virtual : object.prop));
    let best: Hit | null = null;
    for (const found of caster.intersectObjects(meshes, false).slice(0, 1)) {
      const normal = found.face!.normal.clone().transformDirection(found.object.matrixWorld);
      if (normal.dot(ray.direction) > 0) normal.negate();
      const name = this.#props[meshes.indexOf(found.object as PropObject["prop"])]!.state.name;
      best = { place: found.point, normal, name, distance: found.distance };
    }
    for (const table of this.#tables) {
      const place = ray.intersectPlane(table, new Vector3());
      if (place === null || !this.reach.containsPoint(place)) continue;
      const distance = place.distanceTo(ray.origin);
      if (distance < (best?.distance ?? Number.POSITIVE_INFINITY)) {
        best = { place, normal: table.normal.clone(), name: TABLE, distance };
      }
    }
    return best;
  }
}

const TABLE = "table";

interface Hit {
  readonly place: Vector3;
  readonly normal: Vector3;
  readonly name: string;
  readonly distance: number;
}
