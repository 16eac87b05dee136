import { html, render } from "lit-html";
import type { SceneState } from "../live/messages.js";

/** How to open this page in a headset, on a device that has none. */
export function tellHow(state: SceneState): void {
  const dialog = document.createElement("dialog");
  document.body.append(dialog);
  dialog.addEventListener("close", () => dialog.remove());
  const { port, protocol, href } = location;
  const served = html`<ol>
      <li><b>By the network.</b> Start the server with
        <code>touchwarp view ${state.name} --host</code>; it prints a QR code, an address and a short
        code to type in the headset's browser.</li>
      <li><b>By cable.</b> <code>adb reverse tcp:${port} tcp:${port}</code>, then open
        <code>http://localhost:${port}</code> in the headset's browser.</li>
    </ol>`;
  const exported = html`<p>Open <code>${href}</code> in the headset's browser.
    ${protocol === "https:" ? "" : "It needs HTTPS there: put the page on an HTTPS host."}</p>`;
  render(
    html`<h2>Touch it with your own hands</h2>
      <p>This page also runs in the browser of a headset that tracks hands, such as a Quest: there you
        touch the real prop and see the virtual object.</p>
      ${state.live ? served : exported}
      <menu><button class="main" @click=${() => dialog.close()}>Close</button></menu>`,
    dialog,
  );
  dialog.showModal();
}
