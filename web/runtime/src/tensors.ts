/** safetensors: a JSON header, then arrays. docs/warp-file.md tells the format. */

export type Dtype = "F64" | "F32" | "F16" | "I32";

/** One array of the file: where its bytes are, counted from the end of the header. */
export interface TensorEntry {
  readonly dtype: Dtype;
  readonly shape: readonly number[];
  readonly begin: number;
  readonly end: number;
}

export interface TensorHeader {
  readonly metadata: Readonly<Record<string, string>>;
  readonly entries: ReadonlyMap<string, TensorEntry>;
  /** Bytes of all arrays together. */
  readonly dataLength: number;
}

/** Bytes before the header's JSON: its length. */
export const PREFIX = 8;

const SIZES: Readonly<Record<Dtype, number>> = { F64: 8, F32: 4, F16: 2, I32: 4 };
const LONGEST_HEADER = 100_000_000;

/**
 * The header's length, from the first 8 bytes of a file.
 * @throws Error where no header is so long.
 */
export function readHeaderLength(bytes: Uint8Array): number {
  const view = new DataView(bytes.buffer, bytes.byteOffset, PREFIX);
  const length = view.getUint32(0, true) + 2 ** 32 * view.getUint32(4, true);
  if (length < 2 || length > LONGEST_HEADER) {
    throw new Error(`a header of ${length} bytes`);
  }
  return length;
}

/**
 * The header, from its own bytes.
 * @throws Error where it is no header, or its arrays overlap, leave gaps or contradict themselves.
 */
export function readHeader(bytes: Uint8Array): TensorHeader {
  const text = new TextDecoder("utf-8", { fatal: true }).decode(bytes);
  const document = JSON.parse(text) as unknown;
  if (!isRecord(document)) {
    throw new Error("the header is no JSON object");
  }
  const entries = new Map<string, TensorEntry>();
  for (const [name, value] of Object.entries(document)) {
    if (name !== "__metadata__") {
      entries.set(name, readEntry(name, value));
    }
  }
  const ordered = [...entries.values()].sort((a, b) => a.begin - b.begin || a.end - b.end);
  let dataLength = 0;
  for (const entry of ordered) {
    if (entry.begin !== dataLength) {
      throw new Error(`an array begins at byte ${entry.begin} where ${dataLength} was due`);
    }
    dataLength = entry.end;
  }
  const metadata: Record<string, string> = {};
  if (isRecord(document.__metadata__)) {
    for (const [key, value] of Object.entries(document.__metadata__)) {
      metadata[key] = String(value);
    }
  }
  return { metadata, entries, dataLength };
}

function readEntry(name: string, value: unknown): TensorEntry {
  if (!isRecord(value) || !Array.isArray(value.shape) || !Array.isArray(value.data_offsets)) {
    throw new Error(`the entry of '${name}' is no array's`);
  }
  const { dtype, shape } = value;
  const [begin, end] = value.data_offsets as unknown[];
  const whole = [...(shape as unknown[]), begin, end].every(
    (n) => Number.isSafeInteger(n) && (n as number) >= 0,
  );
  if (typeof dtype !== "string" || !whole) {
    throw new Error(`the entry of '${name}' is no array's`);
  }
  const count = (shape as number[]).reduce((product, n) => product * n, 1);
  // arrays of other types belong to keys not known here; only their place matters
  const size = SIZES[dtype as Dtype];
  if (size !== undefined && (end as number) - (begin as number) !== count * size) {
    throw new Error(`the bytes of '${name}' do not fit its shape`);
  }
  return {
    dtype: dtype as Dtype,
    shape: shape as number[],
    begin: begin as number,
    end: end as number,
  };
}

/** A float64, float32 or int32 array; float16 is decoded to float32. A view where bytes lie even. */
export function readTensor(
  data: Uint8Array,
  entry: TensorEntry,
): Float64Array | Float32Array | Int32Array {
  const size = SIZES[entry.dtype];
  if (size === undefined) {
    throw new Error(
      `Its arrays of type ${entry.dtype} are not known; F64, F32, F16 or I32 is needed.`,
    );
  }
  const bytes = evenly(data, entry.begin, entry.end, size);
  const count = (entry.end - entry.begin) / size;
  switch (entry.dtype) {
    case "F64":
      return new Float64Array(bytes.buffer, bytes.byteOffset, count);
    case "F32":
      return new Float32Array(bytes.buffer, bytes.byteOffset, count);
    case "I32":
      return new Int32Array(bytes.buffer, bytes.byteOffset, count);
    case "F16": {
      const out = new Float32Array(count);
      decodeHalves(new Uint16Array(bytes.buffer, bytes.byteOffset, count), out, 0);
      return out;
    }
  }
}

/** The bytes begin…end, copied where they do not begin at a multiple of `size`. */
export function evenly(data: Uint8Array, begin: number, end: number, size: number): Uint8Array {
  const part = data.subarray(begin, end);
  return part.byteOffset % size === 0 ? part : part.slice();
}

let halves: Float32Array | undefined;

/** IEEE 754 binary16 numbers as float32, written from `at` on. */
export function decodeHalves(source: Uint16Array, out: Float32Array, at: number): void {
  halves ??= Float32Array.from({ length: 1 << 16 }, (_, bits) => half(bits));
  for (let n = 0; n < source.length; n++) {
    out[at + n] = halves[source[n]!]!;
  }
}

function half(bits: number): number {
  const sign = bits & 0x8000 ? -1 : 1;
  const exponent = (bits >> 10) & 31;
  const fraction = bits & 1023;
  if (exponent === 31) {
    return fraction ? Number.NaN : sign * Number.POSITIVE_INFINITY;
  }
  return exponent === 0
    ? sign * fraction * 2 ** -24
    : sign * (1 + fraction / 1024) * 2 ** (exponent - 15);
}

export function isRecord(value: unknown): value is Record<string, unknown> {
  return typeof value === "object" && value !== null && !Array.isArray(value);
}
