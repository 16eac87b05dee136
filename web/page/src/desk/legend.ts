import { html, nothing, type TemplateResult } from "lit-html";
import type { Mark } from "../live/messages.js";
import type { Field, Scale } from "./fields.js";

/** A colour scale with its ends and what people notice. */
export function legend(
  field: Field,
  scale: Scale,
  marks: readonly Mark[],
  tolerance: number,
): TemplateResult {
  const own = marks.filter((mark) => mark.scale === field.name);
  const all =
    field.name === "error"
      ? [{ scale: "error", value: tolerance, label: "the scene's tolerance", source: "" } as Mark]
      : own;
  const share = (value: number) => (value - scale.low) / (scale.high - scale.low);
  const inside = all.filter((mark) => share(mark.value) >= 0 && share(mark.value) <= 1);
  const beyond = all.filter((mark) => !inside.includes(mark));
  const stops = Array.from({ length: 13 }, (_, i) => field.colour(i / 12)).join(", ");
  return html`<div class="legend" data-field=${field.name}>
    <div class="bar" style="background: linear-gradient(90deg, ${stops})">
      ${inside.map(
        (mark) => html`<b style="left: ${100 * share(mark.value)}%" title=${mark.source}></b>`,
      )}
    </div>
    <div class="ends">
      <span>${number(scale.low)}</span>
      <span>${number(scale.high)} ${field.unit}</span>
    </div>
    ${inside.map((mark) => html`<p class="mark" title=${mark.source}>▏${number(mark.value)} ${field.unit} ${mark.label}</p>`)}
    ${beyond.map(
      (mark) =>
        html`<p class="mark" title=${mark.source}>▸ beyond this scale: ${number(mark.value)} ${field.unit} ${mark.label}</p>`,
    )}
    ${all.length ? nothing : html`<p class="mark">no threshold is known</p>`}
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
