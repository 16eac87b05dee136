import { Box3, Color, Group, Plane, Sphere, Vector3 } from "three";
import type { Context } from "../context.js";
import type { FromServer, Placement, Progress, Task } from "../live/messages.js";
import { persistently } from "../world/surface.js";
import { colourVertices, evaluate, FIELDS, type FieldName, type Scale, scaleOf } from "./fields.js";
import { Gizmo, goalOf, middleOf } from "./gizmo.js";
import { listenToKeys } from "./keyboard.js";
import { Marker } from "./marker.js";
import { Mouse } from "./mouse.js";
import { boxAround, PropObject, planeObject } from "./objects.js";
import { renderPanel } from "./panel.js";
import { Probe } from "./probe.js";
import { mountRecording } from "./recording.js";
import { Slice } from "./slice.js";
import { Stage } from "./stage.js";
import { type Note, renderWork } from "./work.js";

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
  #marker: Marker;
  #mouse: Mouse;
  #field: FieldName = "mismatch";
  /** Of the colours shown; null before there is a warp. */
  #scale: Scale | null = null;
  #progress = new Map<Task, Progress>();
  #failures = new Map<Task, string>();
  #note: Note | null = null;
  /** While something is dragged to where it cannot stay. */
  #warning: Note | null = null;
  #outer = new Box3();
  #weightShare: number | null = null;
  #painted = "";
  #loading = false;
  #connected = true;
  #drawnVersion = -1;
  #timed = false;
  #panelAsked = false;
  #placements = new Map<string, Placement>();

  constructor(context: Context) {
    this.#context = context;
    const element = document.querySelector<HTMLElement>("#stage")!;
    this.stage = new Stage(element, document.querySelector<HTMLCanvasElement>("#desk")!);
    this.probe = new Probe(this.stage);
    this.#gizmo = new Gizmo(this.stage);
    this.#marker = new Marker(this.stage);
    this.#mouse = new Mouse(this.stage, this.#slice);
    this.stage.scene.add(this.#slice, this.#marker, this.#tables);
    this.stage.beforeFrame = (time) => this.#beforeFrame(time);
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
    this.#mouse.sliced = () => {
      this.#drawSlice();
      this.#askPanel();
    };
    listenToKeys(this.stage, this.#mouse);
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
    const outer = this.#outer.set(new Vector3(...low), new Vector3(...high));
    this.probe.reach.copy(outer).expandByScalar(1e-4);
    this.probe.furnish(props, this.#planes);
    this.#slice.surround(around, outer, this.#planes);
    for (const prop of props) {
      if (prop.state.placement) this.#placements.set(prop.state.name, prop.state.placement);
    }
    this.#gizmo.attach(props.find((prop) => prop.state.placement !== null) ?? null);
    this.stage.frame(
      around,
      props.flatMap(({ state: { pivot, placement } }) =>
        placement ? [middleOf(pivot, placement)] : [],
      ),
      Math.min(...props.map((prop) => boxAround([prop]).getBoundingSphere(new Sphere()).radius)),
    );
    this.probe.touchFirst();
    this.#tellReading();
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
      this.#say({ text: `Saved to ${message.path}.`, isTrouble: false });
    } else if (message.kind === "refused") {
      this.#say({ text: message.reason, isTrouble: true });
      if (message.about === "change_scene") this.#takeBack();
    } else if (message.kind === "state") {
      this.#takeOver();
    }
    if (message.kind === "state" || message.kind === "changed") this.#settle();
    this.#askPanel();
  }

  /** Once the server has all that was moved, what it tells is shown: others may have moved it on. */
  #settle(): void {
    const { changes, state, tables } = this.#context;
    if (tables.moved && state.solvable && !changes.pending) this.#takeBack();
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
      void persistently(() => this.load());
      return;
    }
    const { tables } = this.#context;
    state.props.forEach((prop, i) => {
      const object = this.#props[i]!;
      object.state = prop;
      if (this.#gizmo.dragging) return;
      // what was moved since the server told this is on its way there, and stays
      if (!tables.shows(prop)) return;
      if (prop.placement !== null) this.#placements.set(prop.name, prop.placement);
      const goal = tables.goal(prop.name);
      if (goal !== undefined) object.moveVirtual(goal);
      if (object === this.#gizmo.prop) this.#gizmo.attach(object);
    });
    this.stage.draw();
  }

  /** What was moved goes to where the server has it; what is held is asked for when it is let go. */
  #takeBack(): void {
    if (this.#gizmo.dragging) return;
    const { state, tables } = this.#context;
    tables.restore(state);
    this.#takeOver();
  }

  #drag(prop: PropObject, placement: Placement, ended: boolean): void {
    const goal = goalOf(prop.state.pivot, placement);
    this.#placements.set(prop.state.name, placement);
    prop.moveVirtual(goal);
    this.#warnOutside(ended ? null : prop);
    this.#context.tables.setGoal(prop.state.name, goal);
    if (ended && this.#context.state.solvable) {
      this.#context.changes.ask({ goals: { [prop.state.name]: placement } });
    }
    this.#marker.hide();
  }

  /** ∂Ω1 that is given does not follow: what reaches beyond it is refused once it is let go of. */
  #warnOutside(dragged: PropObject | null): void {
    const beyond = this.#context.state.outer_fixed ? (dragged?.beyond(this.#outer) ?? 0) : 0;
    this.#warning =
      beyond > 0
        ? {
            text: `The virtual object reaches ${(1e3 * beyond).toFixed(0)} mm beyond the outer
              boundary, where nothing can be solved.`,
            isTrouble: true,
          }
        : null;
    this.#askPanel();
  }

  /** The first picture is on the screen: tests and measurements wait for that. */
  #afterFrame(): void {
    if (document.body.dataset.ready === undefined && this.#props.length > 0) {
      document.body.dataset.ready = "true";
      performance.mark("first-picture");
    }
    if (this.#timed || this.#props.length === 0) return;
    const warp = this.#context.tables.current;
    if (warp !== null && document.body.dataset.displaced === undefined) {
      document.body.dataset.displaced = "true";
      performance.mark("first-displaced");
    }
    if (warp !== null && warp.levelsLoaded === warp.levelCount) {
      performance.mark("whole-warp");
      this.#timed = true;
    }
  }

  #beforeFrame(time: number): void {
    const { tables } = this.#context;
    const warp = tables.current;
    const mouse = this.#gizmo.dragging ? null : this.#mouse.take();
    if (mouse !== null) this.probe.follow(mouse.pane, this.stage.ray(mouse.pane, mouse), warp);
    if (this.probe.ease(time, warp)) this.stage.draw();
    if (mouse !== null) this.#tellReading();
    if (tables.version === this.#drawnVersion && this.#painted === this.#field) return;
    this.#drawnVersion = tables.version;
    this.#paint();
    this.#drawSlice();
    this.probe.update(warp);
    this.#tellReading();
  }

  #drawSlice(): void {
    const most = Math.max(0, ...this.#props.map((prop) => prop.greatestShift()));
    this.#slice.update(this.#context.tables.current, most);
  }

  #paint(): void {
    const { tables, state } = this.#context;
    const warp = tables.current;
    const field = FIELDS.find((f) => f.name === this.#field);
    this.#painted = this.#field;
    if (field === undefined || warp === null) {
      if (this.#scale !== null) this.#askPanel();
      this.#scale = null;
      for (const prop of this.#props) prop.paint(PLAIN);
      return;
    }
    const values = this.#props.map((prop) =>
      evaluate(field.name, prop.surface, prop.normals, tables.goal(prop.state.name), warp),
    );
    const scale = scaleOf(field.name, values, state.tolerance_mm, state.marks);
    this.#props.forEach((prop, i) => {
      colourVertices(field, scale, values[i]!, prop.colours);
      prop.paint(null);
    });
    if (scale.low !== this.#scale?.low || scale.high !== this.#scale.high) this.#askPanel();
    this.#scale = scale;
  }

  /** The probing hand makes room for a recording's. */
  set away(away: boolean) {
    this.probe.away = away;
    if (!away) this.probe.update(this.#context.tables.current);
    this.#tellReading();
    this.stage.draw();
  }

  #tellReading(): void {
    const place = document.querySelector<HTMLElement>("#reading")!;
    const { reading } = this.probe;
    place.hidden = reading === null;
    if (reading === null) return;
    const what = reading.touching === null ? "in the air" : `touching the ${reading.touching}`;
    const { mismatch } = reading;
    place.textContent =
      mismatch === null
        ? `${what} · no warp yet`
        : `${what} · displayed ${mismatch.toFixed(1)} mm away`;
  }

  #say(note: Note): void {
    this.#note = note;
    setTimeout(() => {
      if (this.#note === note) this.#note = null;
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
    renderWork(this.#context, {
      progress: this.#progress,
      failures: this.#failures,
      note: this.#warning ?? this.#note,
      connected: this.#connected,
    });
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
        chosen: this.#marker.line,
        weightShare: this.#weightShare,
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
        home: () => this.stage.home(),
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
          this.#renderPanel(); // before the server can answer: what it refuses is written over
          refresh();
        },
        weightTold: (share) => {
          this.#weightShare = share;
          this.#renderPanel();
        },
        weight: (value) => {
          this.#weightShare = null;
          this.#context.changes.ask({ mismatch_weight: value });
          this.#askPanel();
        },
        save: () => this.#context.changes.save(),
        check: (line) => {
          const about = this.#props.filter((prop) => prop.state.name === line.subject);
          const box = boxAround(about.length > 0 ? about : this.#props);
          this.#marker.toggle(line, box.getSize(new Vector3()).length());
          this.#askPanel();
        },
      },
    );
  }
}
