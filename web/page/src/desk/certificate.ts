import { html, nothing, type TemplateResult } from "lit-html";
import type { Certificate, CheckLine } from "../live/messages.js";

const ORDER = ["fail", "warn", "unknown", "pass"] as const;
const WORDS = { fail: "fails", warn: "beware", unknown: "unknown", pass: "holds" } as const;
const SIGNS = { fail: "✕", warn: "!", unknown: "?", pass: "✓" } as const;

/**
 * The certificate's lines, the worst first; each leads to its place, or tells why it has none.
 * @param used identity of the warp in use, which may be another one than was checked.
 */
export function certificatePanel(
  certificate: Certificate | null,
  used: string | null,
  chosen: CheckLine | null,
  choose: (line: CheckLine) => void,
): TemplateResult {
  if (certificate === null) return html`<p class="quiet">Not made yet for this warp.</p>`;
  const shown = certificate.checks.filter((line) => line.group !== "told");
  const told = certificate.checks.filter((line) => line.group === "told");
  return html`
    ${used === null || used === certificate.identity ? nothing : html`<p class="quiet earlier">Of the solved warp, before what was changed.</p>`}
    <p class="verdict ${certificate.status}">
      <i>${SIGNS[certificate.status]}</i>
      ${ORDER.map((status) => {
        const count = shown.filter((line) => line.status === status).length;
        return count ? html`<span>${count} ${WORDS[status]}</span>` : nothing;
      })}
    </p>
    ${ORDER.map((status) => {
      const lines = shown.filter((line) => line.status === status);
      return lines.length
        ? html`<ul class="checks">${lines.map((l) => row(l, l === chosen, choose))}</ul>`
        : nothing;
    })}
    <details>
      <summary>${told.length} more values, without a limit</summary>
      <ul class="checks">${told.map((line) => row(line, line === chosen, choose))}</ul>
    </details>`;
}

function row(line: CheckLine, chosen: boolean, choose: (line: CheckLine) => void): TemplateResult {
  const title = line.subject ? `${line.title} · ${line.subject}` : line.title;
  return html`<li>
    <button
      class="check ${line.status} ${chosen ? "chosen" : ""}"
      data-check=${line.name}
      title="${line.detail} ${line.where === null ? line.nowhere : "Show the place."}"
      @click=${() => choose(line)}
    >
      <i>${SIGNS[line.status]}</i>
      <span class="what">${title}</span>
      <span class="value">${line.value}</span>
      <span class="limit">${line.limit}</span>
    </button>
    ${chosen ? html`<p class="why">${line.detail} ${line.nowhere} ${line.source ? html`<br />Limit from ${line.source}.` : nothing}</p>` : nothing}
  </li>`;
}
