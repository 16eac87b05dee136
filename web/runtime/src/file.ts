/**
 * Warp files: one safetensors file that stands alone, read as its bytes arrive.
 *
 * Bricks stand in order of level in the file, so a table can be used from the moment its coarsest
 * rows are there.
 */

import { AffineBases } from "./bases.js";
import { BRICK, type BrickIndex, Bricks } from "./bricks.js";
import { WarpFileError } from "./errors.js";
import { field, numberOrNull, readMeta, wholeNumbers } from "./meta.js";
import { PlaneWarp } from "./plane.js";
import { columnMajor } from "./rigid.js";
import { TableWarp } from "./table.js";
import {
  decodeHalves,
  evenly,
  isRecord,
  PREFIX,
  readHeader,
  readHeaderLength,
  readTensor,
  type TensorEntry,
  type TensorHeader,
} from "./tensors.js";

const FORMAT = "touchwarp-warp";
const VERSION = 1;
const VALUES = "values";

/** A warp file of which more and more is known. */
export class WarpFile {
  /** The warp, or bases, once the header, the index and the coarsest level are there. */
  warp: TableWarp | PlaneWarp | AffineBases | null = null;
  private readonly name: string;
  private head = new Uint8Array(0);
  private headerLength = 0;
  private header: TensorHeader | null = null;
  private data = new Uint8Array(0);
  /** Bytes of `data` that have come from its beginning on, and from where on its end is there. */
  private arrived = 0;
  private tailFrom = Number.POSITIVE_INFINITY;
  private bricks: Bricks | null = null;
  /** The warp of `bricks`, shown as `warp` from the coarsest level on. */
  private made: TableWarp | AffineBases | null = null;

  constructor(name: string) {
    this.name = name;
  }

  /** Bytes of the whole file; null before the header is there. */
  get length(): number | null {
    return this.header && PREFIX + this.headerLength + this.header.dataLength;
  }

  /** Bytes that the index needs and that only come after the values, if any: [begin, end). */
  get tail(): readonly [number, number] | null {
    const values = this.header?.entries.get(VALUES);
    if (!this.header || !values || values.end === this.header.dataLength) {
      return null;
    }
    const start = PREFIX + this.headerLength;
    return [start + values.end, start + this.header.dataLength];
  }

  /**
   * The next bytes of the file.
   * @throws WarpFileError the file is damaged, foreign, newer or inconsistent, or too long.
   */
  push(chunk: Uint8Array): void {
    if (this.header) {
      if (this.arrived + chunk.length > this.data.length) {
        throw this.unreadable("it is longer than its header says");
      }
      this.data.set(chunk, this.arrived);
      this.arrived += chunk.length;
    } else {
      const joined = new Uint8Array(this.head.length + chunk.length);
      joined.set(this.head);
      joined.set(chunk, this.head.length);
      this.head = joined;
      this.readHead();
    }
    this.advance();
  }

  /** The bytes of `tail`, fetched ahead of their turn. */
  pushTail(bytes: Uint8Array): void {
    const begin = this.data.length - bytes.length;
    if (this.arrived < begin) {
      this.data.set(bytes, begin);
      this.tailFrom = begin;
    }
    this.advance();
  }

  /**
   * The whole file has come.
   * @throws WarpFileError it is truncated.
   */
  finish(): TableWarp | PlaneWarp | AffineBases {
    if (!this.header || this.arrived < this.data.length || !this.warp) {
      const missing = this.header ? this.data.length - this.arrived : "its header";
      throw this.unreadable(`${missing}${this.header ? " bytes are" : " is"} missing`);
    }
    return this.warp;
  }

  private readHead(): void {
    if (this.head.length < PREFIX) {
      return;
    }
    try {
      this.headerLength = readHeaderLength(this.head);
      const end = PREFIX + this.headerLength;
      if (this.head.length < end) {
        return;
      }
      const header = readHeader(this.head.subarray(PREFIX, end));
      this.checkFormat(header.metadata);
      const rest = this.head.subarray(end);
      if (rest.length > header.dataLength) {
        throw new Error("it is longer than its header says");
      }
      this.data = new Uint8Array(header.dataLength);
      this.data.set(rest);
      this.arrived = rest.length;
      this.header = header;
      this.head = new Uint8Array(0);
    } catch (error) {
      throw error instanceof WarpFileError ? error : this.unreadable(told(error));
    }
  }

  private advance(): void {
    if (!this.header) {
      return;
    }
    try {
      if (!this.bricks && !this.warp && this.indexIsThere(this.header)) {
        this.begin(this.header);
      }
      if (this.bricks) {
        this.addLevels(this.bricks, this.header.entries.get(VALUES)!);
      }
    } catch (error) {
      throw error instanceof WarpFileError
        ? error
        : new WarpFileError(`${this.name} is inconsistent: ${told(error)} Save the warp again.`);
    }
  }

  private indexIsThere(header: TensorHeader): boolean {
    for (const [name, { begin, end }] of header.entries) {
      if (name !== VALUES && end > this.arrived && begin < this.tailFrom) {
        return false;
      }
    }
    return true;
  }

  private begin(header: TensorHeader): void {
    const document = this.readDocument(header);
    const tensor = (name: string) => {
      const entry = header.entries.get(name);
      return entry && readTensor(this.data, entry);
    };
    const meta = readMeta(document, tensor);
    if (meta.dimension === 2) {
      if (this.arrived === this.data.length) {
        this.warp = new PlaneWarp(
          {
            T_scene_table: columnMajor(this.doubles("T_scene_table", [3, 3]), 3),
            xLines: this.doubles("x_lines", [null]),
            yLines: this.doubles("y_lines", [null]),
            values: this.planeValues(),
            outer: this.doubles("outer_segments", [null, 2, 2]),
            mirrorDepth: numberOrNull(document, "mirror_depth"),
          },
          meta,
        );
      }
      return;
    }
    const values = this.entry(VALUES, ["F32", "F16"], [null, 9, 9, 9, null]);
    const [rows, channels] = [values.shape[0]!, values.shape[4]!];
    const index: BrickIndex = {
      T_scene_table: columnMajor(this.doubles("T_scene_table", [4, 4]), 4),
      spacing: this.doubles("spacing", [3]),
      rootShape: this.entry("root", ["I32"], [null, null, null]).shape,
      root: this.integers("root", [null, null, null]),
      child: this.integers("child", [null, 8]),
      slot: this.integers("slot", [null]),
      rows,
      channels,
      mirrorDepth: numberOrNull(document, "mirror_depth"),
      levelBricks: wholeNumbers(document, "level_bricks"),
      levelSlots: wholeNumbers(document, "level_slots"),
    };
    const even = (this.data.byteOffset + values.begin) % 4 === 0;
    const ready =
      values.dtype === "F32" && even
        ? new Float32Array(
            this.data.buffer,
            this.data.byteOffset + values.begin,
            rows * BRICK * channels,
          )
        : new Float32Array(rows * BRICK * channels);
    const bricks = new Bricks(index, ready);
    if (meta.kind === "warp" && channels !== 3) {
      throw new Error(
        `A warp's bricks have ${channels} channels; the 3 components of u are needed.`,
      );
    }
    this.made = meta.kind === "warp" ? new TableWarp(bricks, meta) : new AffineBases(bricks, meta);
    this.bricks = bricks;
  }

  /** Use the levels whose rows are all there. */
  private addLevels(bricks: Bricks, values: TensorEntry): void {
    while (bricks.levelsLoaded < bricks.levelCount) {
      const level = bricks.levelsLoaded;
      const stride = BRICK * bricks.channels;
      const size = values.dtype === "F16" ? 2 : 4;
      const first = level === 0 ? 0 : bricks.rowsOf(level - 1) * stride;
      const last = bricks.rowsOf(level) * stride;
      if (values.begin + size * last > this.arrived) {
        break;
      }
      if (values.dtype === "F16" || bricks.values.buffer !== this.data.buffer) {
        const bytes = evenly(
          this.data,
          values.begin + size * first,
          values.begin + size * last,
          size,
        );
        if (size === 2) {
          const halves = new Uint16Array(bytes.buffer, bytes.byteOffset, last - first);
          decodeHalves(halves, bricks.values, first);
        } else {
          bricks.values.set(new Float32Array(bytes.buffer, bytes.byteOffset, last - first), first);
        }
      }
      bricks.addLevel();
    }
    if (bricks.levelsLoaded > 0) {
      this.warp = this.made;
    }
  }

  private readDocument(header: TensorHeader): Record<string, unknown> {
    let document: unknown;
    try {
      document = JSON.parse(header.metadata.meta ?? "");
    } catch (error) {
      throw this.unreadable(told(error));
    }
    if (!isRecord(document)) {
      throw this.unreadable("its meta is no JSON object");
    }
    field(document, "dimension");
    return document;
  }

  private entry(name: string, types: string[], shape: readonly (number | null)[]): TensorEntry {
    const entry = this.header?.entries.get(name);
    if (!entry) {
      throw new Error(`'${name}' is missing.`);
    }
    const fits =
      entry.shape.length === shape.length &&
      shape.every((n, axis) => n === null || n === entry.shape[axis]);
    if (!types.includes(entry.dtype) || !fits) {
      throw new Error(
        `Its ${name} is of type ${entry.dtype} and shape (${entry.shape}); ${types.join(" or ")} of shape (${shape.map((n) => n ?? "·")}) is needed.`,
      );
    }
    return entry;
  }

  private doubles(name: string, shape: readonly (number | null)[]): Float64Array {
    const numbers = readTensor(this.data, this.entry(name, ["F64"], shape)) as Float64Array;
    if (!numbers.every(Number.isFinite)) {
      throw new Error(`Its ${name} has NaN or infinite numbers.`);
    }
    return numbers;
  }

  private integers(name: string, shape: readonly (number | null)[]): Int32Array {
    return readTensor(this.data, this.entry(name, ["I32"], shape)) as Int32Array;
  }

  private planeValues(): Float32Array {
    const [nx, ny] = ["x_lines", "y_lines"].map(
      (name) => this.header!.entries.get(name)!.shape[0]!,
    );
    const entry = this.entry(VALUES, ["F32", "F16"], [nx!, ny!, 2]);
    return readTensor(this.data, entry) as Float32Array;
  }

  private checkFormat(metadata: Readonly<Record<string, string>>): void {
    if (metadata.format !== FORMAT) {
      throw new WarpFileError(
        `${this.name} is a safetensors file, but no warp file (its format is '${metadata.format}', not '${FORMAT}'); give a file that touchwarp saved.`,
      );
    }
    const version = metadata.version ?? "";
    if (!/^\d+$/.test(version) || Number(version) > VERSION) {
      throw new WarpFileError(
        `${this.name} is of version '${version}' of the warp file; this touchwarp reads versions up to ${VERSION}: update touchwarp, or save the warp with this one.`,
      );
    }
  }

  private unreadable(what: string): WarpFileError {
    return new WarpFileError(
      `${this.name} cannot be read (${what}): it is truncated, damaged or no warp file; save the warp again, or copy the file again whole.`,
    );
  }
}

/**
 * A whole warp file in memory.
 * @param name what to call it in messages.
 * @throws WarpFileError it is truncated, foreign, newer or inconsistent.
 */
export function parseWarp(
  bytes: ArrayBuffer | Uint8Array,
  name = "The warp file",
): TableWarp | PlaneWarp | AffineBases {
  const file = new WarpFile(name);
  file.push(bytes instanceof Uint8Array ? bytes : new Uint8Array(bytes));
  return file.finish();
}

function told(error: unknown): string {
  return error instanceof Error ? error.message : String(error);
}
