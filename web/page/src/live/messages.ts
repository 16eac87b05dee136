// Made by `python -m touchwarp.live.typescript` from src/touchwarp/live/messages.py: change that.

export type Vector = readonly [number, number, number];
export type Row = readonly [number, number, number, number];
export type Matrix = readonly [Row, Row, Row, Row];
export type Status = "pass" | "warn" | "fail" | "unknown";
export type Task = "solve" | "bases" | "check";

/** An affine goal as the scene file writes it: pivot + translation + R·S·(x − pivot). */
export interface Placement {
  readonly scale: Vector;
  readonly rotation_deg: Vector;
  readonly translation: Vector;
}

/** Where a prop stands: R = Rz·Ry·Rx of `rotation_deg`. */
export interface Pose {
  readonly position: Vector;
  readonly rotation_deg: Vector;
}

/** One prop. */
export interface PropState {
  readonly name: string;
  readonly pose: Pose;
  readonly pivot: Vector;
  readonly goal: Matrix | null;
  readonly placement: Placement | null;
  readonly surface: string;
}

/** A fixed plane. */
export interface Plane {
  readonly name: string;
  readonly point: Vector;
  readonly normal: Vector;
}

/** Where a warp (or bases) can be fetched, as float16 and in byte ranges, and how exact it is. */
export interface WarpFile {
  readonly identity: string;
  readonly url: string;
  readonly size: number;
  readonly estimated_error_max_mm: number | null;
  readonly storage_error_mm: number;
}

/** One line of the certificate; `where` is the place it is about, `nowhere` why it has none. */
export interface CheckLine {
  readonly name: string;
  readonly title: string;
  readonly subject: string;
  readonly group: "hard" | "judged" | "told";
  readonly status: Status;
  readonly value: string;
  readonly limit: string;
  readonly where: Vector | null;
  readonly nowhere: string;
  readonly detail: string;
  readonly source: string;
}

/** The certificate of the warp `identity`. */
export interface Certificate {
  readonly identity: string;
  readonly status: Status;
  readonly checks: readonly CheckLine[];
}

/** A threshold to draw on a colour scale, in the scale's unit; null where no number is known. */
export interface Mark {
  readonly scale: "mismatch" | "gain" | "error";
  readonly value: number | null;
  readonly label: string;
  readonly source: string;
}

/** The scene as it now is, and what has been made of it. */
export interface SceneState {
  readonly kind: "state";
  readonly name: string;
  readonly version: string;
  readonly revision: number;
  readonly live: boolean;
  readonly solvable: boolean;
  readonly unsaved: boolean;
  readonly props: readonly PropState[];
  readonly planes: readonly Plane[];
  readonly outer_box: readonly [Vector, Vector];
  readonly outer_fixed: boolean;
  readonly mismatch_weight: number;
  readonly tolerance_mm: number;
  readonly interaction: string;
  readonly marks: readonly Mark[];
  readonly warp: WarpFile | null;
  readonly warp_current: boolean;
  readonly bases: WarpFile | null;
  readonly certificate: Certificate | null;
  readonly recording: boolean;
}

/** How far a task is, 0 to 1. */
export interface Progress {
  readonly kind: "progress";
  readonly task: Task;
  readonly step: string;
  readonly done: number;
}

/** A task that ended without a result, and why. */
export interface Failed {
  readonly kind: "failed";
  readonly task: Task;
  readonly reason: string;
}

/** The change of this number was taken up: states of this revision, or newer, hold it. */
export interface Changed {
  readonly kind: "changed";
  readonly number: number;
  readonly revision: number;
}

/** The scene file now holds the changed scene. */
export interface Saved {
  readonly kind: "saved";
  readonly path: string;
}

/** A chunk of a recording is on disk (or was already). */
export interface Acknowledged {
  readonly kind: "acknowledged";
  readonly recording: string;
  readonly sequence: number;
}

/** A recording is whole on disk. */
export interface Finished {
  readonly kind: "finished";
  readonly recording: string;
  readonly path: string;
}

/** A recording was deleted, and nothing more of it is kept: the page forgets what it has. */
export interface Deleted {
  readonly kind: "deleted";
  readonly recording: string;
}

/** A message of the page's that was not carried out, and why. */
export interface Refused {
  readonly kind: "refused";
  readonly about: "change_scene" | "save_scene" | "begin_recording" | "end_recording" | "chunk" | null;
  readonly reason: string;
}

/** Change the scene and solve it anew; what is not given stays. */
export interface ChangeScene {
  readonly kind: "change_scene";
  readonly number?: number;
  readonly mismatch_weight?: number | null;
  readonly goals?: Readonly<Record<string, Placement>>;
  readonly poses?: Readonly<Record<string, Pose>>;
}

/** Write the changed scene back to its file. */
export interface SaveScene {
  readonly kind: "save_scene";
}

/** The person has consented to this recording, under this pseudonym. */
export interface BeginRecording {
  readonly kind: "begin_recording";
  readonly recording: string;
  readonly participant: string;
  readonly consent: true;
  readonly started: string;
  readonly columns: readonly string[];
  readonly device: string;
}

/** The recording has this many chunks; once they are all there it is whole. */
export interface EndRecording {
  readonly kind: "end_recording";
  readonly recording: string;
  readonly chunks: number;
}

/** Begins a binary message: u32 length of this as JSON, this, padding to 8 bytes, float64 rows. */
export interface ChunkHeader {
  readonly recording: string;
  readonly sequence: number;
  readonly rows: number;
  readonly warp: string;
  readonly notes?: readonly string[];
}

export type FromServer = SceneState | Progress | Failed | Changed | Saved | Acknowledged | Finished | Deleted | Refused;

export type FromPage = ChangeScene | SaveScene | BeginRecording | EndRecording;
