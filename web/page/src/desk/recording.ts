import { html, nothing, render, type TemplateResult } from "lit-html";
import { Matrix4 } from "three";
import type { Context } from "../context.js";
import { unpackChunk } from "../live/rows.js";
import type { Desk } from "./index.js";
import { Replay } from "./replay.js";

const PSEUDONYM = "[A-Za-z0-9][A-Za-z0-9_\\-]{0,31}";

interface Listed {
  readonly participant: string;
  readonly recording: string;
  readonly started: string;
  readonly ended: boolean;
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
  /** Whose recording is replayed. */
  #replayed = "";

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
        recorder.frame(time, 1, weight, touching, realPoses, displayedPoses, radii, HERE, identity);
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
      ${
        status.deleted === null
          ? nothing
          : html`<p class="deleted" role="status">${status.deleted} was deleted on the server: recording has
              stopped</p>`
      }
      ${status.onDevice.map(
        (name) => html`<button name="save-recording" @click=${() => this.#download(name)}>
        Save recording ${name.slice(0, 4)}</button>
        ${
          // what a server takes in the end is deleted there
          state.live
            ? nothing
            : html`<button name="delete-recording" @click=${() => this.#confirmDelete(name)}>
                Delete</button>`
        }`,
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
        where the prop stood, the time, and which warp was in use. No picture, no sound, no name.
        ${state.live ? "They go to this experiment's computer, under the pseudonym below, and can be deleted at any time by naming it." : "They stay on this device, under the pseudonym below, until you save or delete them."}</p>
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
    const answer = await answerOf("./recordings.json");
    const listed = ((await answer?.json()) ?? []) as Listed[];
    const { onDevice } = this.context.recorder.status;
    if (!this.#listing) return; // closed meanwhile
    if (answer === null) return this.#tellTrouble("The recordings");
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
    const answer = await answerOf(`./recordings/${listed.participant}/${listed.recording}`);
    if (answer === null) return this.#tellTrouble(`The recording of ${listed.participant}`);
    const { header, numbers } = unpackChunk<{ columns: string[] }>(await answer.arrayBuffer());
    this.#replayed = listed.participant;
    this.#replay = new Replay(this.desk.stage, header.columns, numbers);
    this.desk.away = true;
    this.#play(this.#replay);
  }

  #play(replay: Replay): void {
    let before = performance.now();
    const step = (now: number) => {
      if (replay !== this.#replay) return;
      // time that no moment has taken up counts on for the next
      if (!replay.playing || replay.advance(now - before)) before = now;
      replay.show();
      this.#render();
      requestAnimationFrame(step);
    };
    requestAnimationFrame(step);
  }

  #replayControls(replay: Replay): TemplateResult {
    const toggle = () => {
      if (!replay.playing && replay.ended) replay.at = 0;
      replay.playing = !replay.playing;
    };
    const close = () => {
      replay.dispose();
      this.#replay = null;
      this.desk.away = false;
      this.#render();
    };
    const [now, end] = [replay.time, replay.duration].map((time) => (time / 1000).toFixed(1));
    return html`<b class="replayed">${this.#replayed}</b>
      <button name="play" @click=${toggle}>${replay.playing ? "Pause" : "Play"}</button>
      <input type="range" name="moment" min="0" max=${Math.max(0, replay.moments.length - 1)} .value=${String(replay.at)}
        aria-label="moment" @input=${(e: Event) => {
          replay.playing = false;
          replay.at = Number((e.target as HTMLInputElement).value);
        }} />
      <output>${now} of ${end} s</output>
      <button name="close-replay" @click=${close}>Close</button>`;
  }

  #confirmDelete(name: string): void {
    const remove = async () => {
      await this.context.recorder.forget(name);
      this.#dialog.close();
    };
    this.#show(html`<h2>Delete the recording?</h2>
      <p>Recording ${name.slice(0, 4)} is on this device only, unless you have saved it.</p>
      <menu>
        <button @click=${() => this.#dialog.close()}>Keep it</button>
        <button class="main" name="delete" @click=${remove}>Delete for good</button>
      </menu>`);
  }

  async #download(recording: string): Promise<void> {
    const { recorder, state } = this.context;
    const link = document.createElement("a");
    link.href = URL.createObjectURL(await recorder.asFiles(recording, state.version));
    link.download = `touchwarp-${recording}.zip`;
    link.click();
    URL.revokeObjectURL(link.href);
  }

  #tellTrouble(what: string): void {
    this.#show(html`<h2>Replay</h2>
      <p class="failure">${what} cannot be fetched: try again when the server is back.</p>
      <menu><button @click=${() => this.#dialog.close()}>Close</button></menu>`);
  }

  #show(content: TemplateResult): void {
    render(content, this.#dialog);
    if (!this.#dialog.open) this.#dialog.showModal();
  }
}

/** The desk's room is the scene's own frame. */
const HERE = new Matrix4().elements;

/** Whole, so that reading it cannot fail any more; null where it is not to be had. */
async function answerOf(url: string): Promise<Response | null> {
  try {
    const answer = await fetch(url);
    return answer.ok ? new Response(await answer.arrayBuffer()) : null;
  } catch {
    return null;
  }
}

function isThisMachine(): boolean {
  return ["localhost", "127.0.0.1", "[::1]"].includes(location.hostname);
}
