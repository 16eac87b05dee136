import { html, nothing, render, type TemplateResult } from "lit-html";
import type { Context } from "../context.js";
import { readPositions, unpackChunk } from "../live/rows.js";
import type { Desk } from "./index.js";

const PSEUDONYM = "[A-Za-z0-9][A-Za-z0-9_\\-]{0,31}";

interface Listed {
  readonly participant: string;
  readonly recording: string;
  readonly started: string;
  readonly ended: boolean;
}

interface Replay {
  readonly columns: readonly string[];
  readonly rows: Float64Array;
  /** The row and time, in ms from the beginning, of each frame. */
  readonly frames: readonly (readonly [row: number, time: number])[];
  at: number;
  playing: boolean;
}

/** The header's recording button, the consent that precedes it, and the replay. */
export function mountRecording(context: Context, desk: Desk): void {
  new RecordingControls(context, desk);
}

class RecordingControls {
  #slot = document.querySelector<HTMLElement>("#recording-slot")!;
  #dialog = document.createElement("dialog");
  /** Whether the dialog lists recordings, or will as soon as the list is there. */
  #listing = false;
  #replay: Replay | null = null;
  #weightless = new Float32Array(75);

  constructor(
    readonly context: Context,
    readonly desk: Desk,
  ) {
    document.body.append(this.#dialog);
    this.#dialog.addEventListener("close", () => (this.#listing = false));
    let onDevice = 0;
    context.recorder.listen(({ onDevice: { length } }) => {
      this.#render();
      if (length < onDevice && this.#listing) void this.#list(); // one has arrived
      onDevice = length;
    });
    context.connection?.listenStatus(() => this.#render());
    this.#render();
    this.#record();
  }

  /** In desk mode the probe is what is recorded. */
  #record(): void {
    const { probe, stage } = this.desk;
    const step = (time: number) => {
      const { recorder, tables } = this.context;
      // in the headset it is the person's own hands
      if (recorder.recording && !stage.paused && probe.reading !== null) {
        const touching = probe.reading.touching === null ? 0 : 1 << 1;
        const identity = tables.file?.identity ?? "none";
        const { realPoses, displayedPoses, radii } = probe;
        const weight = tables.current === null ? 0 : 1;
        recorder.frame(time, 1, weight, touching, realPoses, displayedPoses, radii, identity);
      }
      requestAnimationFrame(step);
    };
    requestAnimationFrame(step);
  }

  #render(): void {
    this.#slot.dataset.rows = String(this.context.recorder.status.rows);
    render(this.#controls(), this.#slot);
  }

  #controls(): TemplateResult {
    const { recorder, state } = this.context;
    const { status } = recorder;
    if (status.participant !== null) {
      const waiting =
        status.waiting > 2 && state.live
          ? ` · ${status.waiting} s kept here until the server is back`
          : "";
      return html`<p class="recording" role="status"><i></i>Recording ${status.participant}${waiting}</p>
        <button name="stop-recording" @click=${() => recorder.end()}>Stop</button>`;
    }
    if (this.#replay !== null) return this.#replayControls(this.#replay);
    return html`
      ${status.onDevice.map(
        (name) => html`<button name="save-recording" @click=${() => this.#download(name)}>
        Save recording ${name.slice(0, 4)}</button>`,
      )}
      <button name="record" @click=${() => this.#ask()}>Record …</button>
      ${state.live && isThisMachine() ? html`<button name="replay" @click=${() => this.#list()}>Replay …</button>` : nothing}`;
  }

  #ask(): void {
    const suggestion = `P${100 + Math.floor(900 * Math.random())}`;
    const { state } = this.context;
    const submit = (event: Event) => {
      event.preventDefault();
      const form = event.target as HTMLFormElement;
      const participant = String(new FormData(form).get("participant"));
      const identity = this.context.tables.file?.identity ?? "none";
      this.context.recorder.begin(participant, identity);
      this.#dialog.close();
    };
    this.#show(html`<form @submit=${submit}>
      <h2>Record the hands?</h2>
      <p>Recorded are, for each frame: the joints of both hands, real and displayed, their contacts,
        the time, and which warp was in use. No picture, no sound, no name.
        ${state.live ? "They go to this experiment's computer" : "They stay on this device until you save them"},
        under the pseudonym below, and can be deleted at any time by naming it.</p>
      <label>Pseudonym <input name="participant" required pattern=${PSEUDONYM} maxlength="32" .value=${suggestion}
        autocomplete="off" /></label>
      <label class="agree"><input type="checkbox" name="consent" required />
        I have been told what is recorded and for what, and I agree.</label>
      <menu>
        <button type="button" @click=${() => this.#dialog.close()}>Cancel</button>
        <button class="main" name="begin">Begin recording</button>
      </menu>
    </form>`);
  }

  async #list(): Promise<void> {
    this.#listing = true;
    const answer = await fetch("./recordings.json");
    const listed = answer.ok ? ((await answer.json()) as Listed[]) : [];
    const { onDevice } = this.context.recorder.status;
    if (!this.#listing) return; // closed meanwhile
    this.#show(html`<h2>Replay</h2>
      ${listed.length ? nothing : html`<p>Nothing has been recorded here yet.</p>`}
      <ul class="listed">
        ${listed.map((r) => {
          const coming = onDevice.includes(r.recording);
          return html`<li><button ?disabled=${coming} @click=${() => this.#open(r)}>
          <b>${r.participant}</b> ${new Date(r.started).toLocaleString()}
          ${coming ? "(on its way to the server)" : r.ended ? "" : "(not ended)"}</button></li>`;
        })}
      </ul>
      <menu><button @click=${() => this.#dialog.close()}>Close</button></menu>`);
  }

  async #open(listed: Listed): Promise<void> {
    this.#listing = false;
    this.#dialog.close();
    const answer = await fetch(`./recordings/${listed.participant}/${listed.recording}`);
    if (!answer.ok) return;
    const { header, numbers } = unpackChunk<{ columns: string[] }>(await answer.arrayBuffer());
    const width = header.columns.length;
    const time = header.columns.indexOf("time_ms");
    const frames: [number, number][] = [];
    for (let row = 0; row * width < numbers.length; row++) {
      frames.push([row, numbers[row * width + time]! - numbers[time]!]);
    }
    this.#replay = { columns: header.columns, rows: numbers, frames, at: 0, playing: true };
    this.desk.probe.pinned = true;
    this.#play();
  }

  #play(): void {
    let before = performance.now();
    let moment = 0;
    const step = (now: number) => {
      const replay = this.#replay;
      if (replay === null) return;
      if (replay.playing) {
        moment = (replay.frames[replay.at]?.[1] ?? 0) + now - before;
        while (replay.at + 1 < replay.frames.length && replay.frames[replay.at + 1]![1] <= moment) {
          replay.at++;
          before = now;
        }
        if (replay.at + 1 >= replay.frames.length) replay.playing = false;
      } else before = now;
      this.#showFrame(replay);
      this.#render();
      requestAnimationFrame(step);
    };
    requestAnimationFrame(step);
  }

  #showFrame(replay: Replay): void {
    const start = (replay.frames[replay.at]?.[0] ?? 0) * replay.columns.length;
    const { probe, stage } = this.desk;
    const first = replay.columns.findIndex((name) => name.startsWith("radius."));
    const radii = replay.rows.subarray(start + first, start + first + 25);
    readPositions(replay.rows, start, 0, this.#weightless);
    probe.real.place(this.#weightless, radii);
    probe.ghost.place(this.#weightless, radii);
    readPositions(replay.rows, start, 1, this.#weightless);
    probe.displayed.place(this.#weightless, radii);
    stage.draw();
  }

  #replayControls(replay: Replay): TemplateResult {
    const [, time] = replay.frames[replay.at] ?? [0, 0];
    const toggle = () => {
      if (!replay.playing && replay.at + 1 >= replay.frames.length) replay.at = 0;
      replay.playing = !replay.playing;
    };
    const close = () => {
      this.#replay = null;
      this.desk.probe.pinned = false;
      this.#render();
    };
    return html`<button name="play" @click=${toggle}>${replay.playing ? "Pause" : "Play"}</button>
      <input type="range" name="moment" min="0" max=${Math.max(0, replay.frames.length - 1)} .value=${String(replay.at)}
        aria-label="moment" @input=${(e: Event) => {
          replay.playing = false;
          replay.at = Number((e.target as HTMLInputElement).value);
        }} />
      <output>${(time / 1000).toFixed(1)} s</output>
      <button name="close-replay" @click=${close}>Close</button>`;
  }

  async #download(recording: string): Promise<void> {
    const link = document.createElement("a");
    link.href = URL.createObjectURL(await this.context.recorder.asCsv(recording));
    link.download = `touchwarp-${recording}.csv`;
    link.click();
    URL.revokeObjectURL(link.href);
  }

  #show(content: TemplateResult): void {
    render(content, this.#dialog);
    if (!this.#dialog.open) this.#dialog.showModal();
  }
}

function isThisMachine(): boolean {
  return ["localhost", "127.0.0.1", "[::1]"].includes(location.hostname);
}
