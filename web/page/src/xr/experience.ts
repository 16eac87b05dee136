import { Matrix4, Vector3 } from "three";
import type { Context } from "../context.js";
import type { SceneState } from "../live/messages.js";
import { persistently } from "../world/surface.js";
import type { AnchoredPose } from "./anchored_pose.js";
import { PlayBounds } from "./bounds.js";
import { Calibrator, type Way } from "./calibrator.js";
import { Carrier } from "./carrier.js";
import { Clicks } from "./clicks.js";
import { depict } from "./depict.js";
import { Displacement } from "./displacement.js";
import { HandInput } from "./hand_input.js";
import type { Choices } from "./preflight.js";
import { Probe } from "./probe.js";
import { PlacedProps, PropModel } from "./prop_model.js";
import { Resolver } from "./resolver.js";
import { Room } from "./room.js";
import { HandsUp, isOutside, SEATED_RADIUS, STANDING_RADIUS } from "./safety.js";
import { advance, begin, fade, isDisplaced, type SessionEvent, worldGoal } from "./session.js";
import { measuredPoses, movedProps, standsOn } from "./several_props.js";
import { Strokes } from "./strokes.js";

/** Seconds in which the virtual room appears, and in which it goes. */
const APPEAR = 1.5;
const VANISH = 0.2;

/** One stay in the headset, from entering to leaving. */
export class Experience {
  session = begin(1);
  readonly room = new Room();
  readonly inputs = [new HandInput(0), new HandInput(1)] as const;
  calibrators: Calibrator[] = [];
  placed = new PlacedProps([]);
  displacement: Displacement;
  /** How much of the virtual world is to be seen, 0 to 1. */
  world = 0;
  notice = "";
  /** What the card shows until the person says that it is understood. */
  warning: readonly string[] = [];
  /** What carries the prop; null where it stays. */
  readonly carrier: Carrier | null;
  #scene = "";
  #handsUp = new HandsUp();
  #strokes = new Strokes();
  #clicks: Clicks;
  readonly resolver: Resolver;
  /** How props are found. */
  way: Way = "rub";
  /** Whether tracked hands are shown beside the displayed ones. */
  showsGhosts = false;
  readonly head = new Vector3();
  #gaze = new Vector3(0, 0, -1);
  #playCentre: Vector3 | null = null;
  #bounds: PlayBounds;
  #last = 0;
  #foundOn: 0 | 1 = 1;
  #loading = false;
  #probe = new Probe();
  #unlisten: () => void;

  constructor(
    readonly context: Context,
    readonly xr: XRSession,
    readonly choices: Choices,
    readonly ended: () => void,
  ) {
    this.carrier = choices.carried ? new Carrier() : null;
    this.displacement = this.#displacement();
    this.resolver = new Resolver(context);
    this.#bounds = new PlayBounds(xr);
    let deleted: string | null = null;
    this.#unlisten = context.recorder.listen((status) => {
      const news = status.deleted !== null && deleted === null;
      if (news)
        this.warning = [`${status.deleted} was deleted on the server: recording has stopped.`];
      deleted = status.deleted;
    });
    xr.addEventListener("end", () => this.#end());
    xr.addEventListener("visibilitychange", () => {
      const kind = xr.visibilityState === "visible" ? "resume" : "pause";
      this.tell({ kind, pause: "hidden" });
    });
    this.#clicks = new Clicks(xr, this.room, () => this.#last);
  }

  /** Draw until the session ends. */
  async start(): Promise<void> {
    const { xr } = this.room.renderer;
    await this.#load();
    await xr.setSession(this.xr);
    xr.getReferenceSpace()!.addEventListener("reset", (event) => this.#originMoved(event));
    this.room.renderer.setAnimationLoop((time, frame) => {
      if (frame) this.#frame(time / 1000, frame);
    });
    this.tell({ kind: "ready" });
  }

  tell(event: SessionEvent): void {
    const before = this.session;
    this.session = advance(before, event);
    const { phase } = this.session;
    if (event.kind === "redo" || event.kind === "missed") this.#restartCalibration();
    if (event.kind === "origin moved") for (const each of this.calibrators) each.verifyAnew();
    if (phase === "resolve" && before.phase !== "resolve") this.#resolve();
    if (phase !== "resolve" && before.phase === "resolve") this.resolver.cancel();
    if (phase === "verify" && before.phase === "calibrate") this.room.trail.clear();
    if (phase === "immersed" && before.phase !== "immersed") {
      this.#playCentre = this.head.clone();
      this.displacement.watch.restart();
    }
    this.context.recorder.note(1e3 * this.#last, `${event.kind}: ${phase}`);
  }

  get calibrator(): Calibrator {
    return this.calibrators[this.session.prop]!;
  }

  /** What holds the scene where it stands: while props are sought, as the present one has it. */
  get anchored(): AnchoredPose | undefined {
    const { phase } = this.session;
    const sought = phase === "calibrate" && this.calibrator?.calibration;
    return (sought ? this.calibrator : this.calibrators[0])?.anchored;
  }

  /** Take over the scene: in the beginning, and whenever its objects are others. */
  async #load(): Promise<void> {
    const before = this.calibrators;
    this.#loading = true;
    const fetch = async () => {
      const { state, tables } = this.context;
      const each = state.props.map((prop) => PropModel.fetch(prop, tables.goal(prop.name)));
      return { state, props: await Promise.all(each) };
    };
    const { state, props } = await (before.length === 0 ? fetch() : persistently(fetch));
    this.#loading = false;
    if (this.session.phase === "ended") {
      for (const prop of props) prop.dispose();
      return;
    }
    this.#scene = objectsOf(state);
    const { pose } = this.placed;
    this.placed = new PlacedProps(props);
    this.placed.pose = pose;
    // A scene that was solved anew stands where its first prop was found.
    const [known] = before;
    this.calibrators = props.map((prop) => this.#calibratorOf(prop));
    for (const each of this.calibrators) if (known) each.adopt(known);
    const kept = new Set(this.calibrators.map(({ anchored }) => anchored));
    for (const { anchored } of before) if (!kept.has(anchored)) anchored.release();
    for (const each of before) {
      each.prop.dispose();
      each.dispose();
    }
    this.room.furnish(props, state);
    this.displacement = this.#displacement();
    if (before.length === 0) this.session = begin(props.length);
  }

  #displacement(): Displacement {
    return new Displacement(this.context, this.placed, this.choices.hand, this.carrier);
  }

  #calibratorOf(prop: PropModel): Calibrator {
    const calibrator = new Calibrator(prop, this.choices.freedom);
    calibrator.way = this.way;
    calibrator.found = () => {
      if (calibrator === this.calibrator) this.#foundPose();
    };
    return calibrator;
  }

  /** The scene is another one than is shown: it may be changed on the desk meanwhile. */
  get #outdated(): boolean {
    return this.session.phase !== "resolve" && objectsOf(this.context.state) !== this.#scene;
  }

  /** Show the scene as it now is, once hands have been eased out of the one before. */
  #keepUp(): void {
    if (this.#loading || !this.#outdated || this.displacement.weight > 0) return;
    const stand = (scene: string) => JSON.stringify(JSON.parse(scene).map((o: unknown[]) => o[0]));
    const moved = stand(objectsOf(this.context.state)) !== stand(this.#scene);
    void this.#load().then(() => {
      if (moved) this.tell({ kind: "redo" });
    });
  }

  #frame(time: number, frame: XRFrame): void {
    const room = this.room.renderer.xr.getReferenceSpace()!;
    const elapsed = Math.min(Math.max(time - this.#last, 0), 0.1);
    this.#last = time;
    const viewer = frame.getViewerPose(room);
    if (viewer) {
      matrix.fromArray(viewer.transform.matrix);
      this.head.setFromMatrixPosition(matrix);
      this.#gaze.set(0, 0, -1).transformDirection(matrix);
      if (this.room.panel.position.lengthSq() === 0) this.recentre();
    }
    for (const { anchored } of this.calibrators) anchored.now(frame, room);
    if (this.anchored) this.placed.pose = this.anchored.pose;
    this.carrier?.read(frame, this.xr, room);
    if (this.carrier?.rest) this.placed.pose = this.carrier.pose;
    for (const input of this.inputs) {
      input.read(frame, this.xr.inputSources, room);
      const found = this.calibrators[0]?.calibration;
      if (found && this.session.phase === "immersed")
        input.mendTips(found.tipOffset, this.#foundOn);
    }
    this.#keepSafe(time);
    this.#mindBounds(time, frame, room);
    this.#followTouches(time);
    if (this.session.phase === "resolve") this.#seeWhetherResolved();
    this.#keepUp();
    this.displacement.update(time, this.inputs, isDisplaced(this.session));
    const goal = worldGoal(this.session);
    this.world = fade(this.world, goal, elapsed, goal === 1 ? APPEAR : VANISH);
    depict(this, time);
    if (this.session.phase === "ended") return; // a button has just ended it
    this.#probe.show(this);
    this.room.renderer.render(this.room.scene, this.room.camera);
  }

  #keepSafe(time: number): void {
    const { session } = this;
    const wrists = this.inputs.map((input) => input.poses[13]!) as [number, number];
    if (this.#handsUp.update(this.head.y, wrists, time))
      this.tell({ kind: "pause", pause: "asked" });
    const unready = this.context.tables.current === null || this.#loading || this.#outdated;
    if (unready !== session.pauses.has("unready")) {
      this.tell({ kind: unready ? "pause" : "resume", pause: "unready" });
    }
    if (!this.#playCentre || session.phase !== "immersed") return;
    const radius = this.choices.standing ? STANDING_RADIUS : SEATED_RADIUS;
    const was = session.pauses.has("outside");
    const is = isOutside(this.head, { centre: this.#playCentre, radius }, was);
    if (is !== was) this.tell({ kind: is ? "pause" : "resume", pause: "outside" });
  }

  /** Warn of props that stand where the person may not see what is in the way. */
  #mindBounds(time: number, frame: XRFrame, room: XRReferenceSpace): void {
    if (!this.#bounds.due(time)) return;
    const { phase } = this.session;
    const asOne = phase === "verify" || phase === "immersed"; // else each as it was found
    const places = new Map<string, Vector3>();
    for (const { prop, anchored, done } of this.calibrators) {
      const pose = asOne ? this.placed.pose : anchored.pose;
      if (done) places.set(prop.state.name, pose.toRoom(prop.surface.centre));
    }
    const outside = this.#bounds.look(time, frame, room, places);
    if (outside.length === 0) return;
    const stand = outside.length > 1 ? "stand" : "stands";
    this.warning = [
      `The ${outside.join(" and the ")} ${stand} outside your play area.`,
      "Look that the way there is clear, or put it elsewhere and poke Redo.",
    ];
  }

  #followTouches(time: number): void {
    const { phase } = this.session;
    if (phase !== "calibrate" && phase !== "verify") {
      this.#strokes.drop();
      return;
    }
    const event = this.#strokes.follow(this.inputs, time);
    if (event?.kind === "sample") {
      this.calibrator.sample(event.sample);
      if (phase === "calibrate") this.room.trail.push(event.sample);
    } else if (event && this.#clicks.was(event.side === 0 ? 1 : 0)) {
      this.calibrator.dropStroke();
      if (phase === "calibrate") this.room.trail.show(this.calibrator.samples());
    } else if (event) {
      this.#foundOn = event.side;
      if (phase === "calibrate") this.calibrator.endStroke();
      else this.#endTouch();
    }
  }

  /** The touches of the present prop have told where it stands, more or less. */
  #foundPose(): void {
    const { calibrator } = this;
    const { calibration } = calibrator;
    if (this.session.phase !== "calibrate" || !calibration) return;
    this.carrier?.hold(calibration.pose);
    if (!calibrator.done) return;
    this.notice = "";
    this.room.trail.clear();
    this.tell({ kind: "calibrated" });
  }

  #endTouch(): void {
    const { calibrator } = this;
    const outcome = calibrator.endTouch(this.placed.pose);
    this.notice =
      outcome === "taken"
        ? ""
        : outcome === "too short"
          ? "Stay a little longer."
          : "Touch another place.";
    const { verification } = calibrator;
    if (!verification) return;
    const figures = `median ${mm(verification.median)}, greatest ${mm(verification.worst)}`;
    this.notice = `Five touches: ${figures}.`;
    if (verification.passed) this.tell({ kind: "verified" });
    else this.tell({ kind: "missed", reason: `The touches miss (${figures}). Please rub again.` });
  }

  /** The device has found itself elsewhere: nothing is displaced until five touches verify again. */
  #originMoved({ transform }: XRReferenceSpaceEvent): void {
    if (transform) {
      const T_before_now = new Matrix4().fromArray(transform.matrix);
      for (const anchored of new Set(this.calibrators.map((each) => each.anchored))) {
        anchored.originMoved(T_before_now);
      }
      this.carrier?.originMoved(T_before_now);
      this.#playCentre?.applyMatrix4(T_before_now.clone().invert());
    }
    this.recentre();
    this.tell({ kind: "origin moved" });
  }

  #restartCalibration(): void {
    for (const calibrator of this.calibrators) calibrator.restart();
    this.#bounds.forget();
    this.room.trail.clear();
    this.#strokes.drop();
  }

  /** Several props: solve for where they really stand. */
  #resolve(): void {
    const { planes } = this.context.state;
    const measured = measuredPoses(
      this.calibrators.map(({ prop, anchored }) => ({
        name: prop.state.name,
        scenePose: prop.state.pose,
        room: anchored.pose,
        onTable: this.choices.freedom === 4 && standsOn(planes, prop.surface.lowest.z),
      })),
    );
    const moved = movedProps(measured);
    if (moved.length === 0) this.tell({ kind: "resolved" });
    else this.resolver.begin(Object.fromEntries(moved.map(({ name, pose }) => [name, pose])));
  }

  #seeWhetherResolved(): void {
    const outcome = this.#loading ? null : this.resolver.take();
    if (outcome?.failure) {
      this.tell({ kind: "unresolved", reason: outcome.failure });
      this.#restartCalibration();
    } else if (outcome) void this.#load().then(() => this.tell({ kind: "resolved" }));
  }

  /** Put the panel and the play volume to where the person is now. */
  recentre(): void {
    this.room.panel.standBefore(this.head, this.#gaze);
    if (this.#playCentre) this.#playCentre.copy(this.head);
  }

  /** Whether the real room can be seen through. */
  get seesRoom(): boolean {
    const mode = this.xr.environmentBlendMode;
    return mode === "alpha-blend" || mode === "additive";
  }

  /** Find props in this way from now on. */
  goBy(way: Way): void {
    this.way = way;
    for (const calibrator of this.calibrators) calibrator.way = way;
  }

  #end(): void {
    this.tell({ kind: "end" });
    this.#unlisten();
    this.resolver.dispose();
    for (const calibrator of this.calibrators) calibrator.dispose();
    this.room.renderer.setAnimationLoop(null);
    this.room.dispose();
    this.#probe.close();
    this.ended();
  }
}

/** What of a scene the headset shows: where each prop stands, and what it appears as. */
function objectsOf({ props }: SceneState): string {
  return JSON.stringify(
    props.map(({ name, pose, surface, goal }) => [[name, pose, surface], goal]),
  );
}

function mm(size: number): string {
  return `${(1000 * size).toFixed(1)} mm`;
}

const matrix = new Matrix4();
