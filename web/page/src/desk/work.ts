import { html, nothing, render } from "lit-html";
import type { Context } from "../context.js";
import type { Progress, Task } from "../live/messages.js";

/** Something to tell for a while. */
export interface Note {
  readonly text: string;
  readonly isTrouble: boolean;
}

/** What is going on, kept by the desk. */
export interface Work {
  readonly progress: ReadonlyMap<Task, Progress>;
  readonly failures: ReadonlyMap<Task, string>;
  readonly note: Note | null;
  readonly connected: boolean;
}

const TASKS = { bases: "Preparing live changes", solve: "Solving", check: "Checking" } as const;

/** What the server is doing, and what went wrong, over the scene: nothing else moves for it. */
export function renderWork(context: Context, { progress, failures, note, connected }: Work): void {
  const { state, tables } = context;
  const gone = state.live && !connected;
  render(
    html`
      ${[...progress.values()].map(
        (p) => html`<div class="task" data-task=${p.task}>
          <span>${TASKS[p.task]} <em>${p.step}</em></span>
          <progress max="1" .value=${p.done} aria-label=${TASKS[p.task]}></progress>
        </div>`,
      )}
      ${[...failures].map(([task, reason]) => html`<p class="failure" data-task=${task}>${reason}</p>`)}
      ${tables.problem && !gone ? html`<p class="failure">${tables.problem}</p>` : nothing}
      ${note ? html`<p class=${note.isTrouble ? "failure" : "note"}>${note.text}</p>` : nothing}
      ${
        gone
          ? html`<p class="failure">The server is gone; trying again … What is shown can still be
              probed, and nothing that is recorded is lost.</p>`
          : nothing
      }`,
    document.querySelector<HTMLElement>("#work")!,
  );
}
