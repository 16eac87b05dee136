import { html, render } from "lit-html";
import type { Freedom } from "../calibrate/pose.js";

/** What the person has said before entering. */
export interface Choices {
  readonly standing: boolean;
  readonly freedom: Freedom;
  /** Whether all fingertips touch what they should, or the index finger leads a rigid hand. */
  readonly hand: "fingertips" | "rigid";
  /** Whether a tracked controller is fixed to the prop, which may then be carried. */
  readonly carried: boolean;
}

/** The short page before the headset: resolves with what was chosen, or null when turned away. */
export function askPreflight(blends: boolean, props: number): Promise<Choices | null> {
  const dialog = document.createElement("dialog");
  dialog.className = "preflight";
  document.body.append(dialog);
  return new Promise((resolve) => {
    const close = (choices: Choices | null) => {
      dialog.close();
      dialog.remove();
      resolve(choices);
    };
    const enter = (event: SubmitEvent) => {
      event.preventDefault();
      const said = new FormData(event.target as HTMLFormElement);
      close({
        standing: said.get("stance") === "standing",
        freedom: said.has("tilted") ? 6 : 4,
        hand: said.get("hand") === "rigid" ? "rigid" : "fingertips",
        carried: said.has("carried"),
      });
    };
    render(
      page(blends, props === 1, enter, () => close(null)),
      dialog,
    );
    dialog.addEventListener("cancel", () => close(null));
    dialog.showModal();
  });
}

function page(
  blends: boolean,
  single: boolean,
  enter: (event: SubmitEvent) => void,
  leave: () => void,
) {
  return html`<form @submit=${enter}>
    <h2>Before you put your hands in</h2>
    <label><input type="checkbox" name="clear" required /><span>The space around me is clear: an
      arm's length on all sides, nothing hot, sharp or fragile near the prop.</span></label>
    <label><input type="checkbox" name="empty" required /><span>The prop is empty and dry, and stands
      firmly.</span></label>
    <fieldset>
      <label><input type="radio" name="stance" value="seated" checked /> I sit</label>
      <label><input type="radio" name="stance" value="standing" /> I stand</label>
    </fieldset>
    <label><input type="checkbox" name="tilted" /><span>The prop is not upright: find all six freedoms,
      by more touches</span></label>
    <fieldset>
      <label><input type="radio" name="hand" value="fingertips" checked /> All five fingertips
        touch</label>
      <label><input type="radio" name="hand" value="rigid" /> The index finger leads, the hand follows
        as one piece</label>
    </fieldset>
    <label><input type="checkbox" name="carried" ?disabled=${!single} /><span>The prop may be carried: a
      controller that the headset tracks beside hands is fixed to
      it${single ? "" : " (for scenes with one prop)"}</span></label>
    <p>
      ${
        blends
          ? "You will see the real room first, and touch the prop so that it is found."
          : "This device cannot show the real room: place the prop within easy reach first."
      }
      Whatever happens: <b>raise both hands above your eyes</b> and all displacement stops${
        blends ? ", and the real room is back" : ""
      }.
    </p>
    <menu>
      <button type="button" @click=${leave}>Not now</button>
      <button class="enter main">Enter</button>
    </menu>
  </form>`;
}
