import { Box3, Color, Group, Mesh, MeshBasicMaterial, Plane, SphereGeometry, Vector3 } from "three";
import type { Context } from "../context.js";
import type { CheckLine, FromServer, Placement, Progress, Task } from "../live/messages.js";
import { colourVertices, evaluate, FIELDS, type FieldName, type Scale, scaleOf } from "./fields.js";
import { Gizmo, goalOf } from "./gizmo.js";
import { ALL, showIn } from "./layers.js";
import { boxAround, PropObject, planeObject } from "./objects.js";
import { renderPanel } from "./panel.js";
import { Probe } from "./probe.js";
import { mountRecording } from "./recording.js";
import { Slice } from "./slice.js";
import { type Pane, Stage } from "./stage.js";

const PLAIN = new Color(0xcfc8bd);

/** Desk mode: everything by mouse. */
export async function mountDesk(context: Context): Promise<Desk> {
  const desk = new Desk(context);
  await desk.load();
  return desk;
}

export class Desk {
  readonly stage: Stage;
  readonly probe: Probe;
  #context: Context;
  #panel = document.querySelector<HTMLElement>("#panel")!;
  #props: PropObject[] = [];
  #planes: Plane[] = [];
  #tables = new Group();
  #gizmo: Gizmo;
  #slice = new Slice();
  #marker = marker();
  #field: FieldName = "mismatch";
  #scale: Scale = { low: 0, high: 1 };
  #chosen: CheckLine | null = null;
  #progress = new Map<Task, Progress>();
  #failures = new Map<Task, string>();
  #note = "";
  #weightShare: number | null = null;
  #painted = "";
  #loading = false;
  #connected = true;
  #mouse: { pane: Pane; clientX: number; clientY: number } | null = null;
  #drawnVersion = -1;
  #panelAsked = false;
  #placements = new Map<string, Placement>();

  constructor(context: Context) {
    this.#context = context;
    const element = document.querySelector<HTMLElement>("#stage")!;
    this.stage = new Stage(element, document.querySelector<HTMLCanvasElement>("#desk")!);
    this.probe = new Probe(this.stage);
    this.#gizmo = new Gizmo(this.stage);
    this.stage.scene.add(this.#slice, this.#marker, this.#tables);
    this.stage.beforeFrame = () => this.#beforeFrame();
    this.stage.afterFrame = () => this.#afterFrame();
    this.#gizmo.changed = (prop, placement, ended) => this.#drag(prop, placement, ended);
    context.listen((message) => this.#hear(message));
    context.tables.listen(() => {
      this.stage.draw();
      this.#askPanel();
    });
    context.connection?.listenStatus((open) => {
      this.#connected = open;
      this.#askPanel();
    });
    this.#listenToMouse();
    mountRecording(context, this);
  }

  /** Fetch what is drawn and show it. */
  async load(): Promise<void> {
    const { state } = this.#context;
    this.#loading = true;
    document.querySelector("#scene-name")!.textContent = state.name;
    const props = await Promise.all(state.props.map((prop) => PropObject.fetch(prop)));
    for (const prop of this.#props) prop.dispose();
    this.#props = props;
    for (const prop of props) this.stage.scene.add(...prop.objects);
    const around = boxAround(props);
    this.#planes = state.planes.map((plane) =>
      new Plane().setFromNormalAndCoplanarPoint(
        new Vector3(...plane.normal),
        new Vector3(...plane.point),
      ),
    );
    this.#tables.clear();
    for (const plane of state.planes) this.#tables.add(planeObject(plane, around));
    const [low, high] = state.outer_box;
    this.probe.reach.set(new Vector3(...low), new Vector3(...high)).expandByScalar(1e-4);
    this.#slice.box = this.#sliceBox(around);
    for (const prop of props) {
      if (prop.state.placement) this.#placements.set(prop.state.name, prop.state.placement);
    }
    this.#gizmo.attach(props.find((prop) => prop.state.placement !== null) ?? null);
    this.stage.frame(around);
    this.#touchFirst();
    this.#askPanel();
    // later another mode may have the screen, and gives it back itself
    if (document.body.dataset.ready === undefined) this.stage.paused = false;
    this.#loading = false;
    if (this.#context.state !== state) this.#takeOver();
  }

  #hear(message: FromServer): void {
    if (message.kind === "progress") {
      this.#progress.set(message.task, message);
      this.#failures.delete(message.task);
    } else if (message.kind === "failed") {
      this.#progress.delete(message.task);
      this.#failures.set(message.task, message.reason);
    } else if (message.kind === "saved") {
      this.#say(`Saved to ${message.path}.`);
    } else if (message.kind === "refused") {
      this.#say(message.reason);
    } else if (message.kind === "state") {
      this.#takeOver();
    }
    this.#askPanel();
  }

  /** A new state: other goals, a new warp, a new certificate. */
  #takeOver(): void {
    if (this.#loading) return; // what is loaded now is looked at again when it is there
    const { state } = this.#context;
    if (state.warp_current) this.#progress.delete("solve");
    if (state.bases !== null) this.#progress.delete("bases");
    if (state.certificate !== null) this.#progress.delete("check");
    const same =
      state.props.length === this.#props.length &&
      state.props.every((prop, i) => prop.surface === this.#props[i]!.state.surface);
    if (!same) {
      void this.load();
      return;
    }
    state.props.forEach((prop, i) => {
      const object = this.#props[i]!;
      object.state = prop;
      if (this.#gizmo.dragging) return;
      if (prop.placement !== null) this.#placements.set(prop.name, prop.placement);
      const goal = this.#context.tables.goal(prop.name);
      if (goal !== undefined) object.moveVirtual(goal);
      if (object === this.#gizmo.prop) this.#gizmo.attach(object);
    });
    this.stage.draw();
  }

  #drag(prop: PropObject, placement: Placement, ended: boolean): void {
    const goal = goalOf(prop.state.pivot, placement);
    this.#placements.set(prop.state.name, placement);
    prop.moveVirtual(goal);
    this.#context.tables.setGoal(prop.state.name, goal);
    if (ended && this.#context.state.solvable) {
      this.#context.connection?.send({
        kind: "change_scene",
        goals: { [prop.state.name]: placement },
      });
    }
    this.#chosen = null;
    this.#marker.visible = false;
  }

  /** The first picture is on the screen: tests and measurements wait for that. */
  #afterFrame(): void {
    if (document.body.dataset.ready === undefined && this.#props.length > 0) {
      document.body.dataset.ready = "true";
      performance.mark("first-picture");
    }
  }

  #beforeFrame(): void {
    const { tables } = this.#context;
    const warp = tables.current;
    if (this.#mouse !== null && !this.#gizmo.dragging) {
      const ray = this.stage.ray(this.#mouse.pane, this.#mouse);
      this.probe.follow(this.#mouse.pane, ray, this.#props, warp, this.#planes);
      this.#mouse = null;
      this.#tellReading();
    }
    if (tables.version === this.#drawnVersion && this.#painted === this.#field) return;
    this.#drawnVersion = tables.version;
    this.#paint();
    this.#slice.update(warp);
    this.probe.update(warp);
    this.#tellReading();
  }

  #paint(): void {
    const { tables, state } = this.#context;
    const warp = tables.current;
    const field = FIELDS.find((f) => f.name === this.#field);
    this.#painted = this.#field;
    if (field === undefined || warp === null) {
      for (const prop of this.#props) prop.paint(PLAIN);
      return;
    }
    const values = this.#props.map((prop) =>
      evaluate(field.name, prop.surface, prop.normals, tables.goal(prop.state.name), warp),
    );
    const scale = scaleOf(field.name, values, state.tolerance_mm);
    this.#props.forEach((prop, i) => {
      colourVertices(field, scale, values[i]!, prop.colours);
      prop.paint(null);
    });
    if (scale.low !== this.#scale.low || scale.high !== this.#scale.high) this.#askPanel();
    this.#scale = scale;
  }

  #listenToMouse(): void {
    const { element } = this.stage;
    let dragging = false;
    for (const pane of [this.stage.felt, this.stage.seen]) {
      pane.element.addEventListener("pointermove", (event) => {
        const ray = this.stage.ray(pane, event);
        if (dragging) {
          this.#slice.drag(ray);
          this.#slice.update(this.#context.tables.current);
          this.#askPanel();
        } else if (event.buttons === 0) {
          this.#mouse = { pane, clientX: event.clientX, clientY: event.clientY };
          pane.element.classList.toggle("knob", this.#slice.hit(ray));
        }
        this.stage.draw();
      });
      pane.element.addEventListener("pointerdown", (event) => {
        if (this.#slice.hit(this.stage.ray(pane, event))) {
          dragging = true;
          this.stage.orbit.enabled = false;
          pane.element.setPointerCapture(event.pointerId);
        }
      });
    }
    element.addEventListener("pointerup", () => {
      if (dragging) this.stage.orbit.enabled = true;
      dragging = false;
    });
  }

  /** The hand is there before the mouse is: at the first prop's side that looks this way. */
  #touchFirst(): void {
    const prop = this.#props[0];
    if (prop === undefined || this.probe.visible) return;
    this.probe.visible = true;
    const box = new Box3().setFromObject(prop.prop);
    const centre = box.getCenter(new Vector3());
    const eye = this.stage.camera.position.clone();
    const pane = this.stage.felt;
    const screen = centre.clone().setZ(0.35 * box.min.z + 0.65 * box.max.z);
    const ray = this.stage.ray(pane, { clientX: 0, clientY: 0 });
    ray.origin.copy(eye);
    ray.direction.copy(screen.sub(eye).normalize());
    this.probe.follow(pane, ray, this.#props, this.#context.tables.current, this.#planes);
  }

  #tellReading(): void {
    const place = document.querySelector<HTMLElement>("#reading")!;
    const { reading } = this.probe;
    place.hidden = reading === null;
    if (reading === null) return;
    const what = reading.touching === null ? "in the air" : `touching the ${reading.touching}`;
    place.textContent = `${what} · displayed ${reading.mismatch.toFixed(1)} mm away`;
  }

  #showCheck(line: CheckLine): void {
    this.#chosen = this.#chosen === line ? null : line;
    this.#marker.visible = this.#chosen !== null;
    if (this.#chosen?.where) {
      const place = new Vector3(...this.#chosen.where);
      this.#marker.position.copy(place);
      const size = boxAround(this.#props).getSize(new Vector3()).length();
      this.#marker.scale.setScalar(0.018 * size);
      this.stage.flyTo(place, 1.6 * size);
    }
    this.#askPanel();
  }

  /** The slice moves through the surroundings of the objects, above the table. */
  #sliceBox(around: Box3): Box3 {
    const [low, high] = this.#context.state.outer_box;
    const size = around.getSize(new Vector3());
    const box = around.clone().expandByVector(size.multiplyScalar(0.45));
    box.intersect(new Box3(new Vector3(...low), new Vector3(...high)));
    for (const plane of this.#planes) {
      if (plane.normal.z > 0.999) box.min.z = Math.max(box.min.z, -plane.constant + 1e-4);
    }
    return box;
  }

  #say(note: string): void {
    this.#note = note;
    setTimeout(() => {
      if (this.#note === note) this.#note = "";
      this.#askPanel();
    }, 8000);
  }

  #askPanel(): void {
    if (this.#panelAsked) return;
    this.#panelAsked = true;
    requestAnimationFrame(() => {
      this.#panelAsked = false;
      this.#renderPanel();
    });
  }

  #renderPanel(): void {
    const slice = this.#slice;
    const prop = this.#gizmo.prop?.state.name ?? null;
    const refresh = () => {
      this.#drawnVersion = -1;
      this.stage.draw();
      this.#askPanel();
    };
    renderPanel(
      this.#panel,
      this.#context,
      {
        field: this.#field,
        scale: this.#scale,
        split: this.stage.split,
        sliceMode: slice.mode,
        sliceAxis: slice.axis,
        sliceShare: slice.share,
        slicePlace: slice.place,
        gizmoMode: this.#gizmo.mode,
        prop,
        placement: prop === null ? null : (this.#placements.get(prop) ?? null),
        pinned: this.probe.pinned,
        reading: this.probe.reading,
        progress: this.#progress,
        failures: this.#failures,
        note: this.#note,
        chosen: this.#chosen,
        weightShare: this.#weightShare,
        connected: this.#connected,
      },
      {
        field: (name) => {
          this.#field = name;
          refresh();
        },
        split: (split) => {
          this.stage.split = split;
          refresh();
        },
        slice: ({ mode, axis, share }) => {
          slice.mode = mode ?? slice.mode;
          slice.axis = axis ?? slice.axis;
          slice.share = share ?? slice.share;
          refresh();
        },
        gizmo: (mode) => {
          this.#gizmo.mode = mode;
          refresh();
        },
        choose: (name) => {
          this.#gizmo.attach(this.#props.find((p) => p.state.name === name) ?? null);
          refresh();
        },
        place: (placement) => {
          this.#gizmo.set(placement, true);
          refresh();
        },
        weightTold: (share) => {
          this.#weightShare = share;
          this.#askPanel();
        },
        weight: (value) => {
          this.#weightShare = null;
          this.#context.connection?.send({ kind: "change_scene", mismatch_weight: value });
        },
        save: () => {
          this.#context.connection?.send({ kind: "save_scene" });
        },
        check: (line) => this.#showCheck(line),
      },
    );
  }
}

function marker(): Mesh {
  const material = new MeshBasicMaterial({
    color: 0xe0218a,
    transparent: true,
    opacity: 0.85,
    depthTest: false,
  });
  const mesh = new Mesh(new SphereGeometry(1, 24, 16), material);
  mesh.renderOrder = 10;
  mesh.visible = false;
  showIn(mesh, ALL);
  return mesh;
}
