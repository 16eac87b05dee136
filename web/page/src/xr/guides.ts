import {
  BufferAttribute,
  BufferGeometry,
  DoubleSide,
  Group,
  Mesh,
  MeshBasicMaterial,
  MeshStandardMaterial,
  Points,
  PointsMaterial,
  RingGeometry,
  Vector3,
} from "three";
import type { Contact, NamedPoint } from "../calibrate/contact.js";
import { geometryOf } from "../world/surface.js";
import type { PropModel } from "./prop_model.js";

const AMBER = 0xffb000;
const FORWARD = new Vector3(0, 0, 1);

/** A ring around a place of a prop, prop frame, that breathes. */
export class Ring extends Mesh<RingGeometry, MeshBasicMaterial> {
  constructor() {
    const look = { color: AMBER, depthTest: false, transparent: true, side: DoubleSide };
    super(new RingGeometry(0.0075, 0.0105, 40), new MeshBasicMaterial(look));
    this.renderOrder = 7;
    this.visible = false;
  }

  mark(place: NamedPoint | null, time: number): void {
    this.visible = place !== null;
    if (place === null) return;
    this.position.copy(place.point).addScaledVector(place.normal, 0.001);
    this.quaternion.setFromUnitVectors(FORWARD, place.normal);
    this.scale.setScalar(1 + 0.15 * Math.sin(5 * time));
  }
}

const MOST_DOTS = 4000;

/** Where the skin has been during calibration, room frame. */
export class Trail extends Points<BufferGeometry, PointsMaterial> {
  #places = new BufferAttribute(new Float32Array(3 * MOST_DOTS), 3);
  #count = 0;

  constructor() {
    const look = { color: 0x1f9d8a, size: 0.0035, transparent: true, opacity: 0.8 };
    super(new BufferGeometry(), new PointsMaterial(look));
    this.geometry.setAttribute("position", this.#places);
    this.frustumCulled = false;
    this.clear();
  }

  /** One more sample: the skin below the fingertip's nail is where the pad is. */
  push({ tip, turn, radius }: Contact): void {
    if (!Number.isFinite(tip.x)) return;
    const pad = new Vector3(0, -radius, 0).applyQuaternion(turn).add(tip);
    pad.toArray(this.#places.array, 3 * (this.#count % MOST_DOTS));
    this.#count++;
    this.geometry.setDrawRange(0, Math.min(this.#count, MOST_DOTS));
    this.#places.needsUpdate = true;
  }

  /** These samples and no others. */
  show(samples: Iterable<Contact>): void {
    this.clear();
    for (const sample of samples) this.push(sample);
  }

  override clear(): this {
    this.#count = 0;
    this.geometry.setDrawRange(0, 0);
    return this;
  }
}

const MODEL_SIZE = 0.13;

/** A small model of the prop beside the panel that shows which place to touch. */
export class Miniature extends Group {
  readonly ring = new Ring();
  #turned = new Group();
  #model: Mesh<BufferGeometry, MeshStandardMaterial> | null = null;
  #prop: PropModel | null = null;

  constructor() {
    super();
    this.#turned.rotateX(-Math.PI / 2); // z up to y up
    this.add(this.#turned);
    this.visible = false;
  }

  /** Show a place of a prop to somebody at `eye`, standing at `where`; nothing without a place. */
  show(
    prop: PropModel,
    place: NamedPoint | null,
    where: Vector3,
    eye: Vector3,
    time: number,
  ): void {
    this.visible = place !== null;
    this.ring.mark(place, time);
    if (place === null) return;
    if (prop !== this.#prop) this.#build(prop);
    this.position.copy(where);
    // the place looks half towards the eye, so that it and its surroundings are seen
    const [dx, dz] = [eye.x - where.x, eye.z - where.z];
    const outward = Math.hypot(place.normal.x, place.normal.y) > 0.2;
    const facing = outward ? Math.atan2(place.normal.x, -place.normal.y) : 0;
    this.rotation.y = Math.atan2(dx, dz) - facing + 0.45;
  }

  #build(prop: PropModel): void {
    this.#model?.removeFromParent();
    this.#model?.geometry.dispose();
    this.#prop = prop;
    const { surface } = prop;
    const look = { color: 0xd9d3c7, roughness: 0.7, side: DoubleSide };
    this.#model = new Mesh(
      geometryOf(surface.positions, new Uint32Array(surface.faces)),
      new MeshStandardMaterial(look),
    );
    this.#turned.clear();
    this.#turned.add(this.#model, this.ring);
    const size = MODEL_SIZE / (2 * surface.reach);
    this.#turned.scale.setScalar(size);
    this.#turned.position.set(0, 0, 0);
    const middle = surface.centre.clone().multiplyScalar(-size);
    this.#turned.position.copy(middle.applyQuaternion(this.#turned.quaternion));
  }
}
