import { html, nothing, type TemplateResult } from "lit-html";
import type { Mark } from "../live/messages.js";
import { type Field, type Scale, shareOf } from "./fields.js";

/** A colour scale with its ends and what people notice. */
export function legend(
  field: Field,
  scale: Scale,
  marks: readonly Mark[],
  tolerance: number,
): TemplateResult {
  const own = marks.filter((mark) => mark.scale === field.name);
  const asked: Mark = {
    scale: "error",
    value: tolerance,
    label: "the scene's tolerance",
    source: "",
  };
  const all = field.name === "error" ? [asked, ...own] : own;
  const share = (mark: Mark) => (mark.value === null ? Number.NaN : shareOf(scale, mark.value));
  const inside = all.filter((mark) => share(mark) >= 0 && share(mark) <= 1);
  const sources = all.filter((mark) => mark.source);
  const stops = Array.from({ length: 13 }, (_, i) => field.colour(i / 12)).join(", ");
  const told = (mark: Mark) => (mark.value === null ? "?" : `${number(mark.value)} ${field.unit}`);
  const where = (mark: Mark) =>
    inside.includes(mark) || mark.value === null ? "" : ", beyond this scale";
  return html`<div class="legend" data-field=${field.name}>
    <div class="bar" style="background: linear-gradient(90deg, ${stops})">
      ${inside.map((mark) => html`<b style="left: ${100 * share(mark)}%" title=${mark.label}></b>`)}
    </div>
    <div class="ends">
      <span>${number(scale.low)}</span>
      ${scale.ratio ? html`<span>1</span>` : nothing}
      <span>${number(scale.high)} ${field.unit}</span>
    </div>
    <ul class="marks">
      ${all.map(
        (mark) =>
          html`<li class=${inside.includes(mark) ? "on" : "beyond"}>
            <b>${told(mark)}</b> ${mark.label}${where(mark)}
          </li>`,
      )}
      ${all.length ? nothing : html`<li class="beyond">no threshold is known</li>`}
    </ul>
    ${
      sources.length
        ? html`<details class="sources">
            <summary>Where these come from</summary>
            ${sources.map((mark) => html`<p>${told(mark)}: ${mark.source}.</p>`)}
          </details>`
        : nothing
    }
  </div>`;
}

export function number(value: number): string {
  if (value === 0) return "0";
  const size = Math.abs(value);
  return value
    .toFixed(size >= 100 ? 0 : size >= 10 ? 1 : size >= 1 ? 2 : size >= 0.1 ? 3 : 4)
    .replace(/(\.\d*?)0+$/, "$1")
    .replace(/\.$/, "");
}
