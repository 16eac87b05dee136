import type { Connection } from "./connection.js";
import type { BeginRecording, ChunkHeader, FromServer, Refused } from "./messages.js";
import { type Part, zipRecording } from "./recording_files.js";
import { COLUMNS, packChunk, unpackChunk, writeRow } from "./rows.js";
import { ChunkStore, type Kept } from "./store.js";

const ROWS_A_CHUNK = 144; // two hands for a second at 72 Hz
const MOST_MS_A_CHUNK = 1000;
const OF_RECORDINGS: readonly Refused["about"][] = ["begin_recording", "chunk", "end_recording"];

/** What of the recorder the page shows. */
export interface RecorderStatus {
  readonly participant: string | null;
  readonly rows: number;
  /** Chunks not yet acknowledged by the server. */
  readonly waiting: number;
  /** Recordings that are whole, but not yet with the server. */
  readonly onDevice: readonly string[];
  /** Whose recording was deleted on the server while it went on, until the next begins. */
  readonly deleted: string | null;
}

/**
 * Records hands once the person has consented. Chunks are kept on this device until the server
 * has acknowledged them, and sent again after a lost connection or a reload; without a server they
 * stay here until saved as a file.
 */
export class Recorder {
  #store = new ChunkStore();
  #begin: BeginRecording | null = null;
  #numbers = new Float64Array(ROWS_A_CHUNK * COLUMNS.length);
  #rowsInChunk = 0;
  #chunkSince = 0;
  #sequence = 0;
  #rows = 0;
  #notes: string[] = [];
  #warp = "";
  #waiting = new Set<string>();
  #onDevice: string[] = [];
  #deleted: string | null = null;
  #release = () => {};
  /** Recordings that this page has made or taken over. */
  #own = new Set<string>();
  /** Recordings that other pages of this browser make now. */
  #ofOthers = new Set<string>();
  /** Before what was refused is sent again, ms. */
  #patience = 1000;
  #writes: Promise<unknown> = Promise.resolve();
  #listeners = new Set<(status: RecorderStatus) => void>();

  constructor(readonly connection: Connection | null) {
    connection?.listen((message) => this.#hear(message));
    connection?.listenStatus((open) => {
      if (open) this.#write(() => this.#resend());
    });
    this.#write(() => this.#resend());
    addEventListener("pagehide", () => this.#closeChunk());
    // a headset that is taken off hides the page, and may never come back to it
    document.addEventListener("visibilitychange", () => this.#closeChunk());
  }

  get recording(): boolean {
    return this.#begin !== null;
  }

  get status(): RecorderStatus {
    return {
      participant: this.#begin?.participant ?? null,
      rows: this.#rows,
      waiting: this.#waiting.size,
      onDevice: this.#onDevice,
      deleted: this.#deleted,
    };
  }

  /** Told of every change of `status`. */
  listen(listener: (status: RecorderStatus) => void): () => void {
    this.#listeners.add(listener);
    return () => this.#listeners.delete(listener);
  }

  /** Begin; call it only after the person has agreed. */
  begin(participant: string, warp: string): string {
    if (this.#begin !== null) this.end();
    const begin: BeginRecording = {
      kind: "begin_recording",
      recording: randomName(),
      participant,
      consent: true,
      started: new Date().toISOString(),
      columns: COLUMNS,
      device: navigator.userAgent.slice(0, 300),
    };
    this.#begin = begin;
    this.#deleted = null;
    // while this page records, others of this browser must not take the recording for abandoned
    const held = new Promise<void>((resolve) => (this.#release = resolve));
    void navigator.locks?.request(begin.recording, () => held);
    this.#own.add(begin.recording);
    this.#sequence = this.#rows = this.#rowsInChunk = 0;
    this.#notes = [];
    this.#warp = warp;
    this.#write(() => this.#store.put(`begin/${begin.recording}`, begin));
    this.connection?.send(begin);
    this.#changed();
    return begin.recording;
  }

  /** One hand of one frame, its time in ms; does nothing unless recording. See `writeRow`. */
  frame(
    time: number,
    hand: 0 | 1,
    weight: number,
    contacts: number,
    real: Float32Array,
    displayed: Float32Array,
    radii: Float32Array,
    T_room_scene: ArrayLike<number>,
    warp: string,
  ): void {
    if (this.#begin === null) return;
    const full = this.#rowsInChunk === ROWS_A_CHUNK;
    const old = this.#rowsInChunk > 0 && time - this.#chunkSince > MOST_MS_A_CHUNK;
    if (full || old || warp !== this.#warp) this.#closeChunk();
    this.#warp = warp;
    if (this.#rowsInChunk === 0) this.#chunkSince = time;
    const start = this.#rowsInChunk * COLUMNS.length;
    writeRow(
      this.#numbers,
      start,
      time,
      hand,
      weight,
      contacts,
      real,
      displayed,
      radii,
      T_room_scene,
    );
    this.#rowsInChunk++;
    this.#rows++;
  }

  /** Remember an event as text, with its time in ms. */
  note(time: number, text: string): void {
    if (this.#begin !== null) this.#notes.push(`${time} ${text}`.slice(0, 2000));
  }

  /** End the recording. */
  end(): void {
    const [begin, release] = [this.#begin, this.#release];
    if (begin === null) return;
    this.#closeChunk();
    this.#begin = null;
    const chunks = this.#sequence;
    this.#onDevice = [...this.#onDevice, begin.recording];
    this.#write(() => this.#store.put(`end/${begin.recording}`, chunks));
    this.#write(async () => release()); // another page may take it for abandoned from now on
    this.#write(() => this.#resend());
    this.#changed();
  }

  /** A recording kept on this device, as `recording.csv` and `about.json` in a zip. */
  async asFiles(recording: string, version: string): Promise<Blob> {
    await this.#writes; // the last chunk may be on its way into the store
    const begin = await this.#store.get<BeginRecording>(`begin/${recording}`);
    if (begin === undefined) throw new Error(`There is no recording ${recording} on this device.`);
    return zipRecording(begin, version, this.#parts(recording));
  }

  async *#parts(recording: string): AsyncGenerator<Part> {
    for (const key of await this.#store.keys(`chunk/${recording}/`)) {
      const kept = await this.#store.get<Kept>(key);
      if (kept !== undefined) yield unpackChunk<ChunkHeader>(kept.bytes);
    }
  }

  /** Delete a recording from this device. */
  async forget(recording: string): Promise<void> {
    const keys = await this.#store.keys(`chunk/${recording}/`);
    for (const key of [...keys, `begin/${recording}`, `end/${recording}`]) {
      await this.#store.delete(key);
      this.#waiting.delete(key);
    }
    this.#onDevice = this.#onDevice.filter((other) => other !== recording);
    this.#changed();
  }

  #closeChunk(): void {
    if (this.#begin === null || (this.#rowsInChunk === 0 && this.#notes.length === 0)) return;
    const { recording } = this.#begin;
    const header: ChunkHeader = {
      recording,
      sequence: this.#sequence++,
      rows: this.#rowsInChunk,
      warp: this.#warp,
      notes: this.#notes,
    };
    const numbers = this.#numbers.subarray(0, this.#rowsInChunk * COLUMNS.length);
    const bytes = packChunk(header, numbers);
    this.#rowsInChunk = 0;
    this.#notes = [];
    const key = keyOf(recording, header.sequence);
    this.#waiting.add(key);
    // at once, not after what is being written: the page may be closed in this very moment
    const written = this.#store.put(key, { recording, sequence: header.sequence, bytes });
    written.catch(() => {}); // as any other write that fails: the server may still have it
    this.#write(() => written);
    this.connection?.send(bytes);
    this.#changed();
  }

  #hear(message: FromServer): void {
    if (message.kind === "acknowledged") {
      const key = keyOf(message.recording, message.sequence);
      this.#patience = 1000;
      this.#waiting.delete(key);
      this.#write(() => this.#store.delete(key));
      this.#changed();
    } else if (message.kind === "finished") {
      void this.forget(message.recording);
    } else if (message.kind === "deleted") {
      this.#drop(message.recording);
    } else if (message.kind === "refused" && OF_RECORDINGS.includes(message.about)) {
      setTimeout(() => this.#write(() => this.#resend()), this.#patience);
      this.#patience = Math.min(2 * this.#patience, 60_000);
    }
  }

  /** The server has deleted it for its participant's sake: nothing of it may stay here. */
  #drop(recording: string): void {
    if (this.#begin?.recording === recording) {
      this.#deleted = this.#begin.participant;
      this.#begin = null;
      this.#release();
    }
    this.#write(() => this.forget(recording)); // after what is still being written
  }

  /** Send all that the server has not acknowledged: beginnings, chunks, ends, in this order. */
  async #resend(): Promise<void> {
    const onDevice: string[] = [];
    const held = (await navigator.locks?.query())?.held ?? [];
    for (const key of await this.#store.keys("begin/")) {
      const begin = await this.#store.get<BeginRecording>(key);
      if (begin === undefined) continue;
      const { recording } = begin;
      const mine = recording === this.#begin?.recording;
      if (!this.#own.has(recording) && held.some((lock) => lock.name === recording)) {
        this.#takeOver(recording);
        continue;
      }
      this.connection?.send(begin);
      for (const chunk of await this.#store.keys(`chunk/${recording}/`)) {
        this.#waiting.add(chunk);
        const kept = await this.#store.get<Kept>(chunk);
        if (kept !== undefined) this.connection?.send(kept.bytes);
      }
      if (mine) continue;
      let chunks = await this.#store.get<number>(`end/${recording}`);
      if (chunks === undefined) {
        // the page was closed while recording: what there is, is all there is
        chunks = await this.#chunksSoFar(recording);
        await this.#store.put(`end/${recording}`, chunks);
      }
      this.connection?.send({ kind: "end_recording", recording, chunks });
      onDevice.push(recording);
    }
    this.#onDevice = onDevice;
    this.#changed();
  }

  /** Send what another page leaves behind, once it is closed or has ended. */
  #takeOver(recording: string): void {
    if (this.#ofOthers.has(recording)) return;
    this.#ofOthers.add(recording);
    void navigator.locks.request(recording, async () => {
      this.#own.add(recording);
      this.#write(() => this.#resend());
    });
  }

  async #chunksSoFar(recording: string): Promise<number> {
    const last = (await this.#store.keys(`chunk/${recording}/`)).at(-1);
    return last === undefined ? 0 : Number(last.split("/")[2]) + 1;
  }

  #write(action: () => Promise<unknown>): void {
    this.#writes = this.#writes.then(action, action);
  }

  #changed(): void {
    for (const listener of this.#listeners) listener(this.status);
  }
}

function keyOf(recording: string, sequence: number): string {
  return `chunk/${recording}/${String(sequence).padStart(6, "0")}`;
}

/** Not crypto.randomUUID, which plain-HTTP pages lack. */
function randomName(): string {
  const bytes = crypto.getRandomValues(new Uint8Array(10));
  return Array.from(bytes, (byte) => byte.toString(16).padStart(2, "0")).join("");
}
