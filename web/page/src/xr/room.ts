import {
  BackSide,
  Box3,
  Color,
  DirectionalLight,
  Group,
  HemisphereLight,
  Mesh,
  MeshBasicMaterial,
  PerspectiveCamera,
  RingGeometry,
  Scene,
  SphereGeometry,
  Vector3,
  WebGLRenderer,
} from "three";
import type { Suggestion } from "../calibrate/nextTouch.js";
import { planeObject } from "../desk/objects.js";
import type { SceneState } from "../live/messages.js";
import { HandPicture } from "../world/hand_picture.js";
import { Panel } from "./panel.js";
import type { PropModel } from "./prop_model.js";

const SKIN = 0xd9a98a;
/** Darker than the backdrop under the headset's lights. */
const WOOD = 0xa88d6c;
const TOUCHING = new Color(0x1f9d8a);

/** Everything that is drawn in the headset. */
export class Room {
  readonly renderer: WebGLRenderer;
  readonly scene = new Scene();
  readonly camera = new PerspectiveCamera(70, 1, 0.02, 30);
  readonly panel = new Panel();
  readonly hands = [new HandPicture(SKIN), new HandPicture(SKIN)] as const;
  /** The tracked hands, if the person wants to see them too. */
  readonly ghosts = [new HandPicture(0x7fb4ff, 0.35), new HandPicture(0x7fb4ff, 0.35)] as const;
  /** In the scene frame; carries props, virtual objects and tables. */
  readonly carried = new Group();
  readonly #tables = new Group();
  readonly #marker: Mesh;
  readonly #backdrop: Mesh<SphereGeometry, MeshBasicMaterial>;

  constructor() {
    this.renderer = new WebGLRenderer({ antialias: true, alpha: true });
    this.renderer.xr.enabled = true;
    this.renderer.xr.setReferenceSpaceType("local-floor");
    this.renderer.setClearColor(0x000000, 0);
    const sky = new HemisphereLight(0xffffff, 0xa89f92, 2.2);
    const sun = new DirectionalLight(0xfff2e0, 1.8);
    sun.position.set(0.6, 2, 0.8);
    this.#backdrop = new Mesh(
      new SphereGeometry(15, 32, 16),
      new MeshBasicMaterial({ color: 0xdfe4e8, side: BackSide, transparent: true, opacity: 0 }),
    );
    this.#backdrop.renderOrder = -10;
    this.#backdrop.material.depthWrite = false;
    this.#marker = new Mesh(
      new RingGeometry(0.007, 0.01, 40),
      new MeshBasicMaterial({ color: 0xffb000, depthTest: false, transparent: true }),
    );
    this.#marker.renderOrder = 4;
    this.carried.matrixAutoUpdate = false;
    this.carried.add(this.#tables, this.#marker);
    this.scene.add(
      sky,
      sun,
      this.#backdrop,
      this.carried,
      this.panel,
      ...this.hands,
      ...this.ghosts,
    );
  }

  /** Put a scene's objects in place of those before. */
  furnish(props: readonly PropModel[], state: SceneState): void {
    for (const prop of props) this.carried.add(prop.ghost, prop.virtualObject);
    const around = new Box3();
    for (const { virtualObject } of props) around.expandByObject(virtualObject);
    this.#tables.clear();
    for (const plane of state.planes) this.#tables.add(planeObject(plane, around));
    this.#tables.traverse((object) => {
      // The desk shows things in layers of its own.
      object.layers.set(0);
      // Group orders come before those of meshes: a table's would put it behind the backdrop.
      object.renderOrder = object instanceof Mesh ? -1 : 0;
      if (object instanceof Mesh) object.material.color.set(WOOD);
    });
  }

  /** How opaque the virtual surroundings are: 0 shows the real room where the device can. */
  set backdrop(opacity: number) {
    this.#backdrop.material.opacity = opacity;
    this.#backdrop.visible = opacity > 0.001;
    this.#tables.visible = opacity > 0.3;
  }

  /** Mark a place of a prop, or none. */
  mark(suggestion: Suggestion | null): void {
    this.#marker.visible = suggestion !== null;
    if (!suggestion) return;
    const { point, normal } = suggestion;
    this.#marker.position.copy(point).addScaledVector(normal, 0.001);
    this.#marker.quaternion.setFromUnitVectors(FORWARD, normal);
  }

  /** Let a hand glow that touches. */
  glow(side: 0 | 1, touches: boolean): void {
    const { emissive } = this.hands[side].material;
    emissive.copy(touches ? TOUCHING : BLACK);
  }

  dispose(): void {
    this.renderer.dispose();
  }
}

const FORWARD = new Vector3(0, 0, 1);
const BLACK = new Color(0x000000);
