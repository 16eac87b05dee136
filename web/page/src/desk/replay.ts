import { Matrix4, Quaternion, Vector3 } from "three";
import { readPositions, readScenePose } from "../live/rows.js";
import { HandPicture } from "../world/hand_picture.js";
import { FELT, SEEN, showIn, TOGETHER } from "./layers.js";
import type { Stage } from "./stage.js";

const SKIN = 0xd9a98a;
const GHOST = 0x5a626c;

/** One moment of a recording: its time, in ms from the beginning, and the rows of its hands. */
interface Moment {
  readonly time: number;
  readonly rows: number[];
}

/** A recording, played in desk mode: both hands, where they were beside the props. */
export class Replay {
  at = 0;
  playing = true;
  readonly moments: Moment[] = [];
  #hands = [0, 1].map(() => ({
    real: new HandPicture(SKIN),
    ghost: new HandPicture(GHOST, 0.3),
    displayed: new HandPicture(SKIN),
  }));
  #joints = new Float32Array(75);

  /** @param rows the recording's numbers, row by row. */
  constructor(
    readonly stage: Stage,
    readonly columns: readonly string[],
    readonly rows: Float64Array,
  ) {
    const time = this.#column("time_ms");
    for (let start = 0; start < rows.length; start += columns.length) {
      const now = rows[start + time]! - rows[time]!;
      const last = this.moments.at(-1);
      if (last?.time === now) last.rows.push(start);
      else this.moments.push({ time: now, rows: [start] });
    }
    for (const { real, ghost, displayed } of this.#hands) {
      showIn(real, [FELT]);
      showIn(ghost, [SEEN, TOGETHER]);
      showIn(displayed, [SEEN, TOGETHER]);
      stage.scene.add(real, ghost, displayed);
    }
  }

  get time(): number {
    return this.moments[this.at]?.time ?? 0;
  }

  /** ms. */
  get duration(): number {
    return this.moments.at(-1)?.time ?? 0;
  }

  get ended(): boolean {
    return this.at + 1 >= this.moments.length;
  }

  /** Go on to the last moment that has begun `elapsed` ms after the present one. */
  advance(elapsed: number): boolean {
    const now = this.time + elapsed;
    const before = this.at;
    while (!this.ended && this.moments[this.at + 1]!.time <= now) this.at++;
    if (this.ended) this.playing = false;
    return this.at !== before;
  }

  /** Draw the hands of the present moment. */
  show(): void {
    const radius = this.columns.findIndex((name) => name.startsWith("radius."));
    const hand = this.#column("hand");
    const contacts = this.#column("contacts");
    for (const pictures of this.#hands)
      for (const each of Object.values(pictures)) each.visible = false;
    for (const start of this.moments[this.at]?.rows ?? []) {
      const radii = this.rows.subarray(start + radius, start + radius + 25);
      const pictures = this.#hands[this.rows[start + hand]!]!;
      for (const [which, picture] of [
        [0, pictures.real],
        [0, pictures.ghost],
        [1, pictures.displayed],
      ] as const) {
        readPositions(this.rows, start, which, this.#joints);
        this.#toScene(start);
        picture.place(this.#joints, radii);
        picture.touch(picture === pictures.ghost ? 0 : this.rows[start + contacts]!);
        picture.visible = true;
      }
    }
    this.stage.draw();
  }

  dispose(): void {
    for (const pictures of this.#hands) {
      for (const each of Object.values(pictures)) each.removeFromParent();
    }
    this.stage.draw();
  }

  /** From the room, where a headset has recorded, to the scene as the desk shows it. */
  #toScene(start: number): void {
    if (!readScenePose(this.rows, start, this.columns, place, turn)) return;
    T_scene_room.compose(place, turn, ONE).invert();
    for (let at = 0; at < this.#joints.length; at += 3) {
      point.fromArray(this.#joints, at).applyMatrix4(T_scene_room).toArray(this.#joints, at);
    }
  }

  #column(name: string): number {
    return this.columns.indexOf(name);
  }
}

const ONE = new Vector3(1, 1, 1);
const place = new Vector3();
const turn = new Quaternion();
const point = new Vector3();
const T_scene_room = new Matrix4();
