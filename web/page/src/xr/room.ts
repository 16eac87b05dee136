import { Box3, Group, PCFShadowMap, PerspectiveCamera, Scene, Vector3, WebGLRenderer } from "three";
import type { SceneState } from "../live/messages.js";
import { HandPicture } from "../world/hand_picture.js";
import { Miniature, Ring, Trail } from "./guides.js";
import { Panel } from "./panel.js";
import type { PropModel } from "./prop_model.js";
import { boardOf, Surroundings } from "./surroundings.js";

const SKIN = 0xd9a98a;

/** Everything that is drawn in the headset. */
export class Room {
  readonly renderer: WebGLRenderer;
  readonly scene = new Scene();
  readonly camera = new PerspectiveCamera(70, 1, 0.02, 30);
  readonly surroundings = new Surroundings();
  readonly panel = new Panel();
  readonly ring = new Ring();
  readonly trail = new Trail();
  readonly miniature = new Miniature();
  readonly hands = [new HandPicture(SKIN), new HandPicture(SKIN)] as const;
  /** The tracked hands, if the person wants to see them too. */
  readonly ghosts = [new HandPicture(0x7fb4ff, 0.35), new HandPicture(0x7fb4ff, 0.35)] as const;
  /** In the scene frame; carries props, virtual objects and tables. */
  readonly carried = new Group();
  readonly tables = new Group();
  readonly #objects = new Group();

  constructor() {
    this.renderer = new WebGLRenderer({ antialias: true, alpha: true });
    this.renderer.xr.enabled = true;
    this.renderer.xr.setReferenceSpaceType("local-floor");
    this.renderer.setClearColor(0x000000, 0);
    this.renderer.shadowMap.enabled = true;
    this.renderer.shadowMap.type = PCFShadowMap;
    this.carried.matrixAutoUpdate = this.tables.matrixAutoUpdate = false;
    this.carried.add(this.#objects, this.tables, this.ring);
    this.scene.add(
      this.surroundings,
      this.carried,
      this.trail,
      this.miniature,
      this.panel,
      ...this.hands,
      ...this.ghosts,
    );
  }

  /** Put a scene's objects in place of those before. */
  furnish(props: readonly PropModel[], state: SceneState): void {
    this.#objects.clear();
    for (const prop of props) this.#objects.add(prop.ghost, prop.virtualObject);
    const around = new Box3();
    for (const { virtualObject } of props) {
      virtualObject.geometry.computeBoundingBox();
      around.union(virtualObject.geometry.boundingBox!);
    }
    this.tables.clear();
    const middle = around.getCenter(new Vector3());
    for (const plane of state.planes) this.tables.add(boardOf(plane, middle));
  }

  dispose(): void {
    this.panel.dispose();
    this.renderer.dispose();
    this.renderer.forceContextLoss(); // browsers keep few contexts, and the desk needs its own
  }
}
