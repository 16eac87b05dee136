import { interpolateInferno, interpolateRdBu, interpolateViridis } from "d3-scale-chromatic";
import { Color } from "three";
import type { Warp } from "touchwarp";
import type { Mark } from "../live/messages.js";
import type { PackedSurface } from "../world/surface.js";

export type FieldName = "none" | "mismatch" | "gain" | "error";

/** A quantity on a prop's surface and how it is coloured. */
export interface Field {
  readonly name: FieldName;
  readonly title: string;
  readonly unit: string;
  readonly explanation: string;
  readonly colour: (share: number) => string;
}

export const FIELDS: readonly Field[] = [
  {
    name: "mismatch",
    title: "Mismatch",
    unit: "mm",
    explanation: "How far the displayed finger is from the real one when it touches here.",
    colour: interpolateViridis,
  },
  {
    name: "gain",
    title: "Gain",
    unit: "×",
    explanation: "The greatest displayed over real speed just before contact here.",
    colour: (share) => interpolateRdBu(1 - share),
  },
  {
    name: "error",
    title: "Contact error",
    unit: "mm",
    explanation:
      "|f − g|: how far the displayed finger is at contact from where the goal puts it, off the virtual surface and along it together.",
    colour: (share) => interpolateInferno(0.08 + 0.9 * share),
  },
];

/** How far outside the surface the gain is taken, m: it jumps at the surface itself. */
const OUTSIDE = 1e-3;

/** A field's value at each vertex of a surface. */
export function evaluate(
  name: FieldName,
  surface: PackedSurface,
  normals: Float32Array,
  goal: Float64Array | undefined,
  warp: Warp,
): Float32Array {
  const count = surface.prop.length / 3;
  const values = new Float32Array(count);
  if (name === "gain") {
    const points = new Float64Array(surface.prop.length);
    for (let i = 0; i < points.length; i++) points[i] = surface.prop[i]! + OUTSIDE * normals[i]!;
    const jacobians = new Float64Array(9 * count);
    warp.jacobian(points, jacobians);
    for (let n = 0; n < count; n++) values[n] = greatestStretch(jacobians, 9 * n);
    return values;
  }
  const shown = new Float64Array(surface.prop.length);
  warp.displayed(surface.prop, shown);
  for (let n = 0; n < count; n++) {
    const o = 3 * n;
    const x = surface.prop[o]!;
    const y = surface.prop[o + 1]!;
    const z = surface.prop[o + 2]!;
    let to: [number, number, number] = [x, y, z];
    if (name === "error") {
      to = [surface.virtual[o]!, surface.virtual[o + 1]!, surface.virtual[o + 2]!];
      if (goal !== undefined) to = apply(goal, x, y, z);
    }
    const gap = Math.hypot(shown[o]! - to[0], shown[o + 1]! - to[1], shown[o + 2]! - to[2]);
    values[n] = 1e3 * gap;
  }
  return values;
}

/** The greatest singular value of a 3 × 3 matrix: the root of JᵀJ's greatest eigenvalue. */
export function greatestStretch(m: ArrayLike<number>, o: number): number {
  const dot = (i: number, j: number) =>
    m[o + 3 * i]! * m[o + 3 * j]! +
    m[o + 3 * i + 1]! * m[o + 3 * j + 1]! +
    m[o + 3 * i + 2]! * m[o + 3 * j + 2]!;
  const [a, b, c] = [dot(0, 0), dot(1, 1), dot(2, 2)];
  const [d, e, f] = [dot(0, 1), dot(1, 2), dot(0, 2)];
  // in closed form, by the angle of the characteristic cubic (Smith 1961)
  const mean = (a + b + c) / 3;
  const spread = Math.sqrt(
    ((a - mean) ** 2 + (b - mean) ** 2 + (c - mean) ** 2 + 2 * (d * d + e * e + f * f)) / 6,
  );
  if (!(spread > 1e-12)) return Math.sqrt(mean);
  const [p, q, r] = [(a - mean) / spread, (b - mean) / spread, (c - mean) / spread];
  const [s, t, u] = [d / spread, e / spread, f / spread];
  const half = (p * (q * r - t * t) - s * (s * r - t * u) + u * (s * t - q * u)) / 2;
  const angle = Math.acos(Math.min(1, Math.max(-1, half))) / 3;
  return Math.sqrt(mean + 2 * spread * Math.cos(angle));
}

export interface Scale {
  readonly low: number;
  readonly high: number;
  /** Equal ratios, not differences, are equally far apart. */
  readonly ratio: boolean;
}

/** What people notice stays on the scale, if the colours then still fill this share of it. */
const LEAST_FILLED = 0.7;

/** The ends of a colour scale for these values, with what people notice on it where that is near. */
export function scaleOf(
  name: FieldName,
  values: readonly Float32Array[],
  tolerance: number,
  marks: readonly Mark[],
): Scale {
  let high = 0;
  for (const part of values) for (const value of part) if (value > high) high = value;
  if (name === "gain") {
    const far = Math.min(Math.max(high, 1.2), 5);
    return { low: 1 / far, high: far, ratio: true };
  }
  if (name === "error") {
    const shown = Math.max(1.5 * tolerance, Math.min(high, 5 * tolerance));
    return { low: 0, high: shown, ratio: false };
  }
  high = Math.max(high, 1e-3);
  const near = marks.filter(
    (mark) => mark.scale === name && LEAST_FILLED * (mark.value ?? Number.POSITIVE_INFINITY) < high,
  );
  const farthest = Math.max(0, ...near.map((mark) => 1.08 * mark.value!));
  return { low: 0, high: Math.max(high, farthest), ratio: false };
}

/** Where on a scale a value is, 0 to 1 between its ends. */
export function shareOf({ low, high, ratio }: Scale, value: number): number {
  return ratio ? Math.log(value / low) / Math.log(high / low) : (value - low) / (high - low);
}

/** Colours of vertices, linear RGB. */
export function colourVertices(
  field: Field,
  scale: Scale,
  values: Float32Array,
  out: Float32Array,
): void {
  const steps = paletteOf(field);
  for (let n = 0; n < values.length; n++) {
    const share = shareOf(scale, values[n]!);
    const step = Math.round(255 * Math.min(1, Math.max(0, Number.isFinite(share) ? share : 1)));
    for (let d = 0; d < 3; d++) out[3 * n + d] = steps[3 * step + d]!;
  }
}

const palettes = new Map<Field, Float32Array>();

function paletteOf(field: Field): Float32Array {
  let steps = palettes.get(field);
  if (steps === undefined) {
    steps = new Float32Array(3 * 256);
    const colour = new Color();
    for (let i = 0; i < 256; i++) colour.set(field.colour(i / 255)).toArray(steps, 3 * i);
    palettes.set(field, steps);
  }
  return steps;
}

function apply(m: Float64Array, x: number, y: number, z: number): [number, number, number] {
  return [
    m[0]! * x + m[4]! * y + m[8]! * z + m[12]!,
    m[1]! * x + m[5]! * y + m[9]! * z + m[13]!,
    m[2]! * x + m[6]! * y + m[10]! * z + m[14]!,
  ];
}
