import { Matrix4, Ray, Vector3 } from "three";
import type { Context } from "../context.js";
import { AnchoredPose } from "./anchored_pose.js";
import { Calibrator } from "./calibrator.js";
import { Displacement } from "./displacement.js";
import { HandInput } from "./hand_input.js";
import type { Choices } from "./preflight.js";
import { Probe } from "./probe.js";
import { PlacedProps, PropModel } from "./prop_model.js";
import { Room } from "./room.js";
import { HandsUp, isBeyondBounds, isOutside, SEATED_RADIUS, STANDING_RADIUS } from "./safety.js";
import { advance, backdropGoal, begin, fade, isDisplaced, type SessionEvent } from "./session.js";
import { measuredPoses, movedProps } from "./several_props.js";
import { instruct } from "./words.js";

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
  backdrop = 0;
  notice = "";
  #anchored = new AnchoredPose();
  #handsUp = new HandsUp();
  #head = new Vector3();
  #gaze = new Vector3(0, 0, -1);
  #playCentre: Vector3 | null = null;
  #bounds: DOMPointReadOnly[] = [];
  #last = 0;
  #touchingSide: 0 | 1 | null = null;
  #foundOn: 0 | 1 = 1;
  #showGhosts = false;
  #solving = false;
  #unlisten: () => void;
  #probe = new Probe();

  constructor(
    readonly context: Context,
    readonly xr: XRSession,
    readonly choices: Choices,
    readonly ended: () => void,
  ) {
    this.displacement = new Displacement(context, this.placed);
    this.#unlisten = context.listen((message) => {
      // What else the server does (bases, a certificate) is nothing to a person in the headset.
      if (message.kind === "progress" && this.#solving)
        this.notice = `${message.step} ${pct(message.done)}`;
      if (message.kind === "failed" && this.#solving) this.#resolved(message.reason);
      if (message.kind === "state" && message.warp_current && this.#solving) {
        void this.#load().then(() => this.#resolved(null));
      }
    });
    xr.addEventListener("end", () => this.#end());
    xr.addEventListener("visibilitychange", () => {
      const kind = xr.visibilityState === "visible" ? "resume" : "pause";
      this.tell({ kind, pause: "hidden" });
    });
    xr.addEventListener("select", (event) => this.#select(event));
  }

  /** Draw until the session ends. */
  async start(): Promise<void> {
    const { xr } = this.room.renderer;
    await this.#load();
    await xr.setSession(this.xr);
    xr.getReferenceSpace()!.addEventListener("reset", () => this.tell({ kind: "origin moved" }));
    this.room.renderer.setAnimationLoop((time, frame) => {
      if (frame) this.#frame(time / 1000, frame);
    });
    void this.#findBounds();
    this.tell({ kind: "ready" });
  }

  tell(event: SessionEvent): void {
    const before = this.session;
    this.session = advance(before, event);
    if (event.kind === "redo" || event.kind === "missed") this.#restartCalibration();
    if (event.kind === "origin moved" || event.kind === "verified") this.#verifyAnew(event);
    if (this.session.phase === "resolve" && before.phase !== "resolve") this.#resolve();
    if (this.session.phase === "immersed" && before.phase !== "immersed") {
      this.#playCentre = this.#head.clone();
      this.displacement.watch.restart();
    }
    this.context.recorder.note(this.#last, `${event.kind}: ${this.session.phase}`);
  }

  get calibrator(): Calibrator {
    return this.calibrators[this.session.prop]!;
  }

  async #load(): Promise<void> {
    const { state } = this.context;
    const props = await Promise.all(state.props.map((prop) => PropModel.fetch(prop)));
    for (const { prop } of this.calibrators) prop.dispose();
    const { pose } = this.placed;
    this.placed = new PlacedProps(props);
    this.placed.pose = pose;
    const before = this.calibrators;
    this.calibrators = props.map((prop) => new Calibrator(prop, this.choices.freedom));
    // Of a scene that was solved anew, the first prop's calibration still says where it all stands.
    this.calibrators.forEach((each, k) => {
      each.calibration = before[k] ? before[0]!.calibration : null;
    });
    this.room.furnish(props, state);
    this.displacement = new Displacement(this.context, this.placed);
    if (before.length === 0) this.session = begin(props.length);
  }

  #frame(time: number, frame: XRFrame): void {
    const room = this.room.renderer.xr.getReferenceSpace()!;
    const elapsed = Math.min(Math.max(time - this.#last, 0), 0.1);
    this.#last = time;
    const viewer = frame.getViewerPose(room);
    if (viewer) {
      matrix.fromArray(viewer.transform.matrix);
      this.#head.setFromMatrixPosition(matrix);
      this.#gaze.set(0, 0, -1).transformDirection(matrix);
      if (this.room.panel.position.lengthSq() === 0) this.recentre();
    }
    this.placed.pose = this.#anchored.now(frame, room);
    for (const input of this.inputs) {
      input.read(frame, this.xr.inputSources, room);
      const found = this.calibrators[0]?.calibration;
      if (found && this.session.phase === "immersed")
        input.mendTips(found.tipOffset, this.#foundOn);
    }
    this.#keepSafe(time);
    this.#followTouches(time, frame, room);
    this.displacement.update(time, this.inputs, isDisplaced(this.session));
    this.#picture(elapsed);
    this.#probe.show(this);
    this.room.renderer.render(this.room.scene, this.room.camera);
  }

  #keepSafe(time: number): void {
    const wrists = this.inputs.map((input) => input.poses[13]!) as [number, number];
    if (this.#handsUp.update(this.#head.y, wrists, time))
      this.tell({ kind: "pause", pause: "asked" });
    if (!this.#playCentre || this.session.phase !== "immersed") return;
    const radius = this.choices.standing ? STANDING_RADIUS : SEATED_RADIUS;
    const was = this.session.pauses.has("outside");
    const is = isOutside(this.#head, { centre: this.#playCentre, radius }, was);
    if (is !== was) this.tell({ kind: is ? "pause" : "resume", pause: "outside" });
  }

  /** Strokes: one hand pinches and holds while the other's index fingertip is on the prop. */
  #followTouches(time: number, frame: XRFrame, room: XRReferenceSpace): void {
    const { phase } = this.session;
    if (phase !== "calibrate" && phase !== "verify") return;
    const pinching = this.inputs.find(({ pinch }) => pinch.closed);
    if (this.#touchingSide === null && pinching && this.inputs[1 - pinching.side]!.tracked) {
      this.#touchingSide = pinching.side === 0 ? 1 : 0;
    }
    if (this.#touchingSide === null) return;
    if (this.inputs[1 - this.#touchingSide]!.pinch.closed) {
      this.calibrator.sample(this.inputs[this.#touchingSide]!.sample(time));
      return;
    }
    this.#foundOn = this.#touchingSide;
    this.#touchingSide = null;
    if (phase === "calibrate") this.#endStroke(frame, room);
    else this.#endTouch();
  }

  #endStroke(frame: XRFrame, room: XRReferenceSpace): void {
    const { calibrator } = this;
    calibrator.endStroke();
    const { calibration } = calibrator;
    if (calibration) this.#anchored.set(calibration.pose, frame, room);
    if (!calibrator.done) return;
    const { x, z } = calibration!.pose.toRoom(calibrator.prop.surface.centre);
    this.notice = isBeyondBounds({ x, z }, this.#bounds)
      ? "Careful: the prop stands outside your play area."
      : "";
    this.tell({ kind: "calibrated" });
  }

  #endTouch(): void {
    const { calibrator } = this;
    const outcome = calibrator.endTouch();
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

  #verifyAnew(event: SessionEvent): void {
    if (event.kind === "origin moved") for (const each of this.calibrators) each.verifyAnew();
  }

  #restartCalibration(): void {
    for (const calibrator of this.calibrators) calibrator.restart();
    this.#touchingSide = null;
  }

  /** Several props: solve for where they really stand. */
  #resolve(): void {
    const measured = measuredPoses(
      this.calibrators.map(({ prop, calibration }) => ({
        name: prop.state.name,
        scenePose: prop.state.pose,
        room: calibration!.pose,
      })),
    );
    const moved = movedProps(measured);
    this.#anchored.set(this.calibrators[0]!.calibration!.pose);
    if (moved.length === 0) {
      this.tell({ kind: "resolved" });
    } else if (!this.context.connection) {
      const most = moved.reduce((one, other) => (other.shift > one.shift ? other : one));
      this.#resolved(
        `${most.name} stands ${mm(most.shift)} off, and there is no server to solve on.`,
      );
    } else {
      this.#solving = true;
      const poses = Object.fromEntries(moved.map(({ name, pose }) => [name, pose]));
      this.context.connection.send({ kind: "change_scene", poses });
    }
  }

  #resolved(failure: string | null): void {
    this.#solving = false;
    this.notice = "";
    if (failure === null) this.tell({ kind: "resolved" });
    else {
      this.tell({ kind: "unresolved", reason: failure });
      this.#restartCalibration();
    }
  }

  #picture(elapsed: number): void {
    const { room, session } = this;
    const goal = this.seesRoom ? backdropGoal(session) : 1;
    this.backdrop = fade(this.backdrop, goal, elapsed, goal === 1 ? APPEAR : VANISH);
    room.backdrop = this.backdrop;
    room.carried.matrix.copy(this.placed.pose.matrix(matrix));
    const calibrating = session.phase === "calibrate" || session.phase === "verify";
    this.calibrators.forEach(({ prop, calibration }, k) => {
      prop.ghost.visible = calibrating && calibration !== null && k <= session.prop;
      prop.virtualObject.visible = isDisplaced(session) || this.backdrop > 0.5;
      if (calibrating) prop.virtualObject.visible = false;
    });
    const suggestion = session.phase === "calibrate" ? (this.calibrator?.suggestion ?? null) : null;
    room.mark(suggestion);
    for (const input of this.inputs) {
      const hand = room.hands[input.side];
      const { touching, displayed } = this.displacement;
      const claims = this.displacement.mayClaimContact(input.side);
      room.glow(input.side, touching[input.side] !== 0 && claims);
      hand.visible = input.tracked && (this.backdrop > 0.01 || !this.seesRoom);
      if (hand.visible) hand.place(displayed[input.side], input.radii, 16, 12);
      const ghost = room.ghosts[input.side];
      ghost.visible = this.#showGhosts && input.tracked;
      if (ghost.visible) ghost.place(input.poses, input.radii, 16, 12);
      room.panel.poke(`${input.side}`, input.joint(9, tip));
    }
    this.#word();
  }

  #word(): void {
    if (!this.calibrator) return;
    const { session } = this;
    const { audit } = this.displacement.watch;
    const { title, lines, progress } = instruct(session, this.calibrator, {
      audit: audit.line,
      drifted: audit.hasDrifted,
      notice: this.notice,
    });
    const paused = session.pauses.has("asked");
    const buttons = [
      paused
        ? { label: "Resume", press: () => this.tell({ kind: "resume", pause: "asked" }) }
        : { label: "Pause", press: () => this.tell({ kind: "pause", pause: "asked" }) },
      { label: "Redo", press: () => this.tell({ kind: "redo" }) },
      { label: "Recentre", press: () => this.recentre() },
      { label: this.#showGhosts ? "Hide real" : "Show real", press: () => this.#toggleGhosts() },
      { label: "Leave", press: () => void this.xr.end() },
    ];
    this.room.panel.content = {
      title,
      lines: lines.filter((line) => line !== ""),
      progress,
      buttons,
    };
  }

  /** Put the panel and the play volume to where the person is now. */
  recentre(): void {
    this.room.panel.standBefore(this.#head, this.#gaze);
    if (this.#playCentre) this.#playCentre.copy(this.#head);
  }

  /** Whether the real room can be seen through. */
  get seesRoom(): boolean {
    const mode = this.xr.environmentBlendMode;
    return mode === "alpha-blend" || mode === "additive";
  }

  #toggleGhosts(): void {
    this.#showGhosts = !this.#showGhosts;
  }

  #select({ frame, inputSource }: XRInputSourceEvent): void {
    const room = this.room.renderer.xr.getReferenceSpace();
    const pose = room && frame.getPose(inputSource.targetRaySpace, room);
    if (!pose) return;
    matrix.fromArray(pose.transform.matrix);
    const origin = new Vector3().setFromMatrixPosition(matrix);
    this.room.panel.select(new Ray(origin, new Vector3(0, 0, -1).transformDirection(matrix)));
  }

  async #findBounds(): Promise<void> {
    try {
      const bounded = (await this.xr.requestReferenceSpace(
        "bounded-floor",
      )) as XRBoundedReferenceSpace;
      this.#bounds = [...bounded.boundsGeometry];
    } catch {
      this.#bounds = []; // The device knows of none, or keeps it to itself.
    }
  }

  #end(): void {
    this.tell({ kind: "end" });
    this.#unlisten();
    this.room.renderer.setAnimationLoop(null);
    this.room.dispose();
    this.#probe.close();
    this.ended();
  }
}

function pct(share: number): string {
  return `${Math.round(100 * share)} %`;
}

function mm(size: number): string {
  return `${(1000 * size).toFixed(1)} mm`;
}

const matrix = new Matrix4();
const tip = new Vector3();
