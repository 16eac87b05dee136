import { html, nothing, render, type TemplateResult } from "lit-html";
import type { Context } from "../context.js";
import type { CheckLine, Placement } from "../live/messages.js";
import { certificatePanel } from "./certificate.js";
import { FIELDS, type FieldName, type Scale } from "./fields.js";
import type { GizmoMode } from "./gizmo.js";
import { legend, number } from "./legend.js";
import type { Axis, SliceMode } from "./slice.js";

/** What the panel shows, kept by the desk. */
export interface Shown {
  readonly field: FieldName;
  /** Null before there is a warp. */
  readonly scale: Scale | null;
  readonly split: boolean;
  readonly sliceMode: SliceMode;
  readonly sliceAxis: Axis;
  readonly sliceShare: number;
  readonly slicePlace: number;
  readonly gizmoMode: GizmoMode;
  readonly prop: string | null;
  readonly placement: Placement | null;
  readonly chosen: CheckLine | null;
  /** Of the λ slider, while it is being dragged. */
  readonly weightShare: number | null;
}

/** What a person can do in it. */
export interface Actions {
  field(name: FieldName): void;
  split(split: boolean): void;
  home(): void;
  slice(change: { mode?: SliceMode; axis?: Axis; share?: number }): void;
  gizmo(mode: GizmoMode): void;
  choose(prop: string): void;
  place(placement: Placement): void;
  weightTold(share: number): void;
  weight(value: number): void;
  save(): void;
  check(line: CheckLine): void;
}

const MOST_WEIGHT = 1000;
const LEAST_WEIGHT = 0.1;

export function renderPanel(into: HTMLElement, context: Context, shown: Shown, act: Actions): void {
  render(panel(context, shown, act), into);
}

function panel(context: Context, shown: Shown, act: Actions): TemplateResult {
  const { state } = context;
  return html`
    <section>
      <div class="row">
        <h2>Look</h2>
        <button class="small" name="home" @click=${act.home}>Show all</button>
      </div>
      ${choices(
        "split",
        "How felt and seen are shown",
        [
          ["true", "Side by side"],
          ["false", "Together"],
        ],
        String(shown.split),
        (v) => act.split(v === "true"),
      )}
      <h3>Colour of what is felt</h3>
      ${choices("field", "Colour of what is felt", [["none", "Plain"], ...FIELDS.map((f) => [f.name, f.title] as const)], shown.field, act.field)}
      ${FIELDS.filter((f) => f.name === shown.field).map(
        (f) => html`<p class="quiet">${f.explanation}</p>
          ${
            shown.scale === null
              ? html`<p class="quiet">There are colours once there is a warp.</p>`
              : legend(f, shown.scale, state.marks, state.tolerance_mm)
          }`,
      )}
      <h3>Slice through space</h3>
      ${choices(
        "slice",
        "Slice through space",
        [
          ["off", "Off"],
          ["arrows", "Arrows"],
          ["lattice", "Lattice"],
        ],
        shown.sliceMode,
        (mode) => act.slice({ mode }),
      )}
      ${shown.sliceMode === "off" ? nothing : slice(shown, act)}
    </section>
    <section>
      <h2>Virtual object</h2>
      ${virtualObject(context, shown, act)}
    </section>
    <section>
      <h2>Locality <span class="symbol">λ</span></h2>
      ${weight(context, shown, act)}
    </section>
    <section>
      <h2>Certificate</h2>
      ${certificatePanel(state.certificate, context.tables.file?.identity ?? null, shown.chosen, act.check)}
    </section>
    <footer>${exactness(context)}<br />touchwarp ${state.version}</footer>`;
}

function slice(shown: Shown, act: Actions): TemplateResult {
  return html`
    ${choices(
      "axis",
      "Across which axis",
      [
        ["0", "x"],
        ["1", "y"],
        ["2", "z"],
      ],
      String(shown.sliceAxis),
      (v) => act.slice({ axis: Number(v) as Axis }),
    )}
    <label class="slider">
      <input name="slice-share" type="range" aria-label="Where the slice is" min="0" max="1" step="0.001" .value=${String(shown.sliceShare)}
        @input=${(e: Event) => act.slice({ share: Number((e.target as HTMLInputElement).value) })} />
      <output>${"xyz"[shown.sliceAxis]} = ${(1e3 * shown.slicePlace).toFixed(0)} mm</output>
    </label>
    <p class="quiet">Or drag the orange knob. ${shown.sliceMode === "arrows" ? "Arrows lead from the real to the displayed place, at their true length." : "What is straight where it is felt is bent where it is seen."}</p>`;
}

function virtualObject(context: Context, shown: Shown, act: Actions): TemplateResult {
  const { state } = context;
  const movable = state.props.filter((prop) => prop.placement !== null);
  if (movable.length === 0) {
    return html`<p class="quiet">Its goal is not written as scale, turn and shift, so it cannot be dragged.</p>`;
  }
  const ready = context.tables.instant;
  return html`
    ${
      movable.length > 1
        ? choices(
            "prop",
            "Whose virtual object",
            movable.map((p) => [p.name, p.name] as const),
            shown.prop ?? "",
            act.choose,
          )
        : nothing
    }
    ${choices(
      "gizmo",
      "What dragging does",
      [
        ["translate", "Move"],
        ["rotate", "Turn"],
        ["scale", "Scale"],
      ],
      shown.gizmoMode,
      act.gizmo,
    )}
    ${
      shown.placement === null
        ? nothing
        : html`<table class="numbers">
          <tr><th></th>${["x", "y", "z"].map((axis) => html`<th scope="col">${axis}</th>`)}</tr>
          ${numbers("Shift", "mm", shown.placement, "translation", 1e3, 1, act)}
          ${numbers("Turn", "°", shown.placement, "rotation_deg", 1, 1, act)}
          ${numbers("Scale", "×", shown.placement, "scale", 1, 0.05, act)}
        </table>`
    }
    <p class="quiet">
      ${ready ? "Every change is live: no new solve is needed to see it." : state.live ? "Live changes are being prepared." : "This page has no bases for live changes."}
    </p>
    ${
      state.live
        ? html`<button class="main" name="save" ?disabled=${!state.unsaved || !state.solvable} @click=${act.save}>
          Save to ${state.name}
        </button>`
        : nothing
    }`;
}

function numbers(
  title: string,
  unit: string,
  placement: Placement,
  key: "translation" | "rotation_deg" | "scale",
  factor: number,
  step: number,
  act: Actions,
): TemplateResult {
  const change = (axis: number, event: Event) => {
    const input = event.target as HTMLInputElement;
    const value = Number(input.value) / factor;
    if (input.value === "" || !Number.isFinite(value) || (key === "scale" && value <= 0)) {
      input.value = number(placement[key][axis]! * factor);
      return;
    }
    act.place({ ...placement, [key]: placement[key].map((old, i) => (i === axis ? value : old)) });
  };
  return html`<tr>
    <th scope="row">${title}, ${unit}</th>
    ${placement[key].map(
      (value, axis) => html`<td><input type="number" name=${`${key}-${axis}`} step=${step}
        aria-label=${`${title} ${"xyz"[axis]}`} .value=${number(value * factor)}
        @change=${(event: Event) => change(axis, event)} /></td>`,
    )}
  </tr>`;
}

function weight(context: Context, shown: Shown, act: Actions): TemplateResult {
  const { state } = context;
  const share = shown.weightShare ?? shareOf(state.mismatch_weight);
  const told = shown.weightShare === null ? state.mismatch_weight : weightAt(share);
  const at = (event: Event) => Number((event.target as HTMLInputElement).value);
  return html`<label class="slider">
      <input name="weight" type="range" aria-label="Locality λ" aria-valuetext=${number(told)} min="0" max="1" step="0.01" .value=${String(share)}
        ?disabled=${!state.solvable}
        @input=${(event: Event) => act.weightTold(at(event))}
        @change=${(event: Event) => act.weight(weightAt(at(event)))} />
      <output>${number(told)}</output>
    </label>
    <p class="quiet">
      0 is the smoothest warp; larger keeps the displacement nearer the prop.
      ${state.solvable ? "Solved anew when you let go." : "Needs a server and the scene's meshes."}
    </p>`;
}

/** The slider is logarithmic, with 0 at its left end. */
export function weightAt(share: number): number {
  if (share === 0) return 0;
  return Number((LEAST_WEIGHT * (MOST_WEIGHT / LEAST_WEIGHT) ** share).toPrecision(2));
}

function shareOf(weight: number): number {
  if (weight <= 0) return 0;
  const share = Math.log(weight / LEAST_WEIGHT) / Math.log(MOST_WEIGHT / LEAST_WEIGHT);
  return Math.min(1, Math.max(0.01, share));
}

function exactness(context: Context): TemplateResult {
  const { tables } = context;
  const { file, current } = tables;
  if (file === null || current === null) {
    return html`<span class="exactness">No warp yet: it is being solved, or on its way.</span>`;
  }
  const what = tables.exact ? "Warp" : tables.instant ? "Live warp" : "Warp before the last change";
  const error = tables.errorMm;
  return html`<span class="exactness" data-exact=${String(tables.exact)}>
    ${what}: ${(file.size / 1e6).toFixed(1)} MB as float16, which adds ${number(tables.addedErrorMm)} mm;
    ${error === null ? "error not estimated" : html`error ≤ ${number(error)} mm (estimated)`};
    ${current.levelsLoaded} of ${current.levelCount} levels of detail loaded.</span>`;
}

function choices<T extends string>(
  name: string,
  label: string,
  options: readonly (readonly [T, string])[],
  chosen: T,
  choose: (value: T) => void,
): TemplateResult {
  return html`<div class="choices" role="radiogroup" aria-label=${label}>
    ${options.map(
      ([value, title]) => html`<label>
        <input type="radio" name=${name} value=${value} .checked=${value === chosen} @change=${() => choose(value)} />
        <span>${title}</span>
      </label>`,
    )}
  </div>`;
}
