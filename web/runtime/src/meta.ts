import { columnMajor } from "./rigid.js";
import { isRecord } from "./tensors.js";
import type { BasisProp, Outline, WarpMeta } from "./warp.js";

/** An array of the file by name; undefined where there is none. */
export type ReadTensor = (name: string) => Float64Array | Float32Array | Int32Array | undefined;

/**
 * What the file's JSON document and its side arrays say.
 * @throws Error where something is missing or not what it should be.
 */
export function readMeta(document: Record<string, unknown>, tensor: ReadTensor): WarpMeta {
  const kind = document.kind;
  if (kind !== "warp" && kind !== "bases") {
    throw new Error(`It holds '${String(kind)}'; 'warp' or 'bases' is needed.`);
  }
  const dimension = document.dimension;
  if (dimension !== 2 && dimension !== 3) {
    throw new Error(`It has ${String(dimension)} dimensions; 2 or 3 are needed.`);
  }
  const m = dimension + 1;
  const box = field(document, "outer_box");
  const corners = box === null ? null : numbers(box, [2, dimension], "outer_box");
  return {
    kind,
    dimension,
    scene: String(field(document, "scene")),
    propNames: names(document, "prop_names"),
    outlines: names(document, "outlines").map((name, n) => readOutline(name, n, tensor)),
    outerBox: corners && {
      low: [...corners.subarray(0, dimension)],
      high: [...corners.subarray(dimension)],
    },
    outerSurface: readOuter(tensor),
    toleranceMm: number(document, "tolerance_mm"),
    edgeRadiusMm: number(document, "edge_radius_mm"),
    estimatedErrorMaxMm: numberOrNull(document, "estimated_error_max_mm"),
    estimatedErrorRmsMm: numberOrNull(document, "estimated_error_rms_mm"),
    storageErrorMm: number(document, "storage_error_mm"),
    levelErrorsMm: levelErrors(record(document, "notes")),
    screening: number(document, "screening"),
    goals: new Map(
      Object.entries(record(document, "goals")).map(([name, rows]) => [
        name,
        columnMajor(numbers(rows, [m, m], "goals"), m),
      ]),
    ),
    basis: new Map(
      Object.entries(record(document, "basis")).map(([name, entry]) => [name, readBasis(entry)]),
    ),
    rangeShift: number(document, "range_shift"),
    rangeStretch: number(document, "range_stretch"),
    T_room_scene: columnMajor(numbers(field(document, "T_room_scene"), [m, m], "T_room_scene"), m),
    notes: record(document, "notes"),
  };
}

/** A value of the document, which must be there. */
export function field(document: Record<string, unknown>, name: string): unknown {
  if (!(name in document)) {
    throw new Error(`'${name}' is missing.`);
  }
  return document[name];
}

/** A number, or null. */
export function numberOrNull(document: Record<string, unknown>, name: string): number | null {
  const value = field(document, name);
  return value === null ? null : number(document, name);
}

/** A list of whole numbers. */
export function wholeNumbers(document: Record<string, unknown>, name: string): number[] {
  const value = field(document, name);
  if (!Array.isArray(value) || !value.every((n) => Number.isSafeInteger(n))) {
    throw new Error(`Its ${name} is no list of whole numbers.`);
  }
  return value as number[];
}

function number(document: Record<string, unknown>, name: string): number {
  const value = field(document, name);
  if (typeof value !== "number") {
    throw new Error(`Its ${name} is ${JSON.stringify(value)}; a number is needed.`);
  }
  return value;
}

function levelErrors(notes: Record<string, unknown>): readonly number[] {
  const errors = notes.level_errors_mm;
  return Array.isArray(errors) && errors.every(Number.isFinite) ? (errors as number[]) : [];
}

/** What u is off by with the levels loaded; NaN where some are not and the file does not tell. */
export function addedError(meta: WarpMeta, levelsLoaded: number, levelCount: number): number {
  const missing = meta.levelErrorsMm[levelsLoaded - 1];
  return meta.storageErrorMm + (levelsLoaded === levelCount ? 0 : (missing ?? Number.NaN));
}

function record(document: Record<string, unknown>, name: string): Record<string, unknown> {
  const value = field(document, name);
  if (!isRecord(value)) {
    throw new Error(`Its ${name} is ${JSON.stringify(value)}; an object is needed.`);
  }
  return value;
}

function names(document: Record<string, unknown>, name: string): string[] {
  const value = field(document, name);
  if (!Array.isArray(value) || !value.every((text) => typeof text === "string")) {
    throw new Error(`Its ${name} is no list of names.`);
  }
  return value as string[];
}

/** Nested lists of finite numbers of a shape, in one row. */
function numbers(value: unknown, shape: readonly number[], name: string): Float64Array {
  const flat: unknown[] = Array.isArray(value) ? value.flat(shape.length - 1) : [];
  const count = shape.reduce((product, n) => product * n, 1);
  const first = Array.isArray(value) ? value.length : 0;
  if (first !== shape[0] || flat.length !== count || !flat.every((n) => Number.isFinite(n))) {
    throw new Error(`Its ${name} is not of shape ${shape.join(" × ")} and finite.`);
  }
  return Float64Array.from(flat as number[]);
}

function readBasis(entry: unknown): BasisProp {
  if (!isRecord(entry)) {
    throw new Error("Its basis has an entry that is no object.");
  }
  const centre = numbers(field(entry, "centre"), [3], "basis centre");
  return { centre: [...centre], halfDiagonal: number(entry, "half_diagonal") };
}

function readOutline(name: string, n: number, tensor: ReadTensor): Outline {
  const prop = tensor(`outline.${n}.prop`);
  const virtual = tensor(`outline.${n}.virtual`);
  const faces = tensor(`outline.${n}.faces`);
  if (
    !(prop instanceof Float32Array) ||
    !(virtual instanceof Float32Array) ||
    !(faces instanceof Int32Array)
  ) {
    throw new Error(`The outline of '${name}' is missing or of another type.`);
  }
  return { name, prop, virtual, faces };
}

function readOuter(tensor: ReadTensor): WarpMeta["outerSurface"] {
  const vertices = tensor("outer.vertices");
  const faces = tensor("outer.faces");
  return vertices instanceof Float32Array && faces instanceof Int32Array
    ? { vertices, faces }
    : null;
}
