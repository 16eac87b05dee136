/** Files that are wrong, and files that arrive piece by piece. */

import { createServer, type Server } from "node:http";
import { afterAll, beforeAll, describe, expect, test } from "vitest";
import { WarpFile } from "../src/file.js";
import { openWarp, parseWarp, type TableWarp, type Warp, WarpFileError } from "../src/index.js";
import { PREFIX, readHeaderLength } from "../src/tensors.js";
import { difference, fileBytes, vector } from "./vectors.js";

type Entry = { dtype: string; shape: number[]; data_offsets: number[] };
type Header = Record<string, Entry> & { __metadata__: Record<string, string> };

/** A file with its header changed; its arrays stay as they are. */
function rewritten(bytes: Uint8Array, change: (header: Header) => void): Uint8Array {
  const length = readHeaderLength(bytes);
  const header = JSON.parse(
    new TextDecoder().decode(bytes.subarray(PREFIX, PREFIX + length)),
  ) as Header;
  change(header);
  const text = new TextEncoder().encode(JSON.stringify(header));
  const padded = new Uint8Array(Math.ceil(text.length / 8) * 8).fill(32);
  padded.set(text);
  const out = new Uint8Array(PREFIX + padded.length + bytes.length - PREFIX - length);
  new DataView(out.buffer).setUint32(0, padded.length, true);
  out.set(padded, PREFIX);
  out.set(bytes.subarray(PREFIX + length), PREFIX + padded.length);
  return out;
}

function withMeta(bytes: Uint8Array, change: (meta: Record<string, unknown>) => void): Uint8Array {
  return rewritten(bytes, (header) => {
    const meta = JSON.parse(header.__metadata__.meta!) as Record<string, unknown>;
    change(meta);
    header.__metadata__.meta = JSON.stringify(meta);
  });
}

/** A file with one number of an array replaced. */
function withNumber(bytes: Uint8Array, name: string, at: number, value: number): Uint8Array {
  const out = bytes.slice();
  const start = PREFIX + readHeaderLength(out);
  const header = JSON.parse(new TextDecoder().decode(out.subarray(PREFIX, start))) as Header;
  const { dtype, data_offsets } = header[name]!;
  const view = new DataView(out.buffer, start + data_offsets[0]!);
  if (dtype === "F64") {
    view.setFloat64(8 * at, value, true);
  } else if (dtype === "F32") {
    view.setFloat32(4 * at, value, true);
  } else {
    view.setInt32(4 * at, value, true);
  }
  return out;
}

const LEVELS = fileBytes("levels.warp");

describe("a wrong file is refused:", () => {
  const unreadable = /bad\.warp cannot be read \(.*\): it is truncated, damaged or no warp file/;
  const cases: [string, Uint8Array, RegExp][] = [
    ["empty", new Uint8Array(0), unreadable],
    ["shorter than a header", LEVELS.slice(0, 100), unreadable],
    ["cut off", LEVELS.slice(0, -1), /bad\.warp cannot be read \(1 bytes are missing\)/],
    ["too long", new Uint8Array([...LEVELS, 0]), /longer than its header says/],
    ["a picture", new Uint8Array([137, 80, 78, 71, 13, 10, 26, 10, 0, 0]), unreadable],
    ["no JSON", new Uint8Array([4, 0, 0, 0, 0, 0, 0, 0, 120, 120, 120, 120]), unreadable],
    [
      "of another format",
      rewritten(LEVELS, (header) => {
        header.__metadata__.format = "weights";
      }),
      /is a safetensors file, but no warp file \(its format is 'weights', not 'touchwarp-warp'\)/,
    ],
    [
      "newer",
      rewritten(LEVELS, (header) => {
        header.__metadata__.version = "2";
      }),
      /is of version '2' of the warp file; this touchwarp reads versions up to 1: update touchwarp/,
    ],
    [
      "with a gap between arrays",
      rewritten(LEVELS, (header) => {
        header.root!.data_offsets[0]! += 4;
      }),
      /cannot be read \((an array begins at byte|the bytes of 'root')/,
    ],
    [
      "without an array",
      rewritten(LEVELS, (header) => {
        header.roots = header.root!;
        delete (header as Record<string, unknown>).root;
      }),
      /is inconsistent: 'root' is missing\. Save the warp again/,
    ],
    [
      "without a key",
      withMeta(LEVELS, (meta) => {
        delete meta.mirror_depth;
      }),
      /'mirror_depth' is missing/,
    ],
    [
      "of an unknown kind",
      withMeta(LEVELS, (meta) => {
        meta.kind = "wrap";
      }),
      /holds 'wrap'; 'warp' or 'bases' is needed/,
    ],
    [
      "in four dimensions",
      withMeta(LEVELS, (meta) => {
        meta.dimension = 4;
      }),
      /has 4 dimensions; 2 or 3 are needed/,
    ],
    [
      "with levels told wrong",
      withMeta(LEVELS, (meta) => {
        meta.level_slots = [0, 2, 3, 4, 5];
      }),
      /not in order of level, as level_bricks tells it/,
    ],
    [
      "that names bricks it has not",
      withNumber(LEVELS, "root", 0, 99),
      /names brick 99, but the table has bricks 0 to \d/,
    ],
    ["that names a brick twice", withNumber(LEVELS, "child", 1, 1), /names a brick twice/],
    ["that leaves out a brick", withNumber(LEVELS, "root", 0, -1), /never names \d of \d bricks/],
    ["with a lost slot", withNumber(LEVELS, "slot", 0, 3), /slots do not name each of the/],
    ["with a cell of no size", withNumber(LEVELS, "spacing", 1, 0), /three lengths > 0 are needed/],
    [
      "with a number lost",
      withNumber(LEVELS, "values", 9, Number.NaN),
      /row 0 hold NaN or infinity/,
    ],
    [
      "bases of a prop without scaling",
      withMeta(fileBytes("bases.warp"), (meta) => {
        meta.basis = {};
      }),
      /have scalings for ; one for each prop is needed/,
    ],
    [
      "bases called a warp",
      withMeta(fileBytes("bases.warp"), (meta) => {
        meta.kind = "warp";
      }),
      /have 4 channels; the 3 components of u are needed/,
    ],
    [
      "a plane table whose lines do not ascend",
      withNumber(fileBytes("plane.warp"), "x_lines", 2, -5),
      /array 'x_lines' does not ascend/,
    ],
  ];
  test.each(cases)("%s", (_, bytes, message) => {
    expect(() => parseWarp(bytes, "bad.warp")).toThrow(WarpFileError);
    expect(() => parseWarp(bytes, "bad.warp")).toThrow(message);
  });

  test("the same file unspoilt is read", () => {
    const untouched = rewritten(LEVELS, () => undefined);
    expect(parseWarp(untouched).levelsLoaded).toBe(4);
  });
});

describe("meta", () => {
  test("tells what the file says", () => {
    const { meta } = parseWarp(LEVELS);
    expect(meta.scene).toContain("Größe 1.2 ×");
    expect(meta.propNames).toEqual(["ball"]);
    expect(meta.outlines[0]!.virtual[8]).toBe(2);
    expect([...meta.goals.get("ball")!.subarray(0, 6)]).toEqual([1.2, 0, 0, 0, 0, 1]);
    expect(meta.outerBox!.high).toEqual([0.2, 0.2, 0.2]);
    expect(meta.notes).toEqual({ cycles: 3 });
    expect(meta.storageErrorMm).toBe(0);
    expect(parseWarp(fileBytes("half.warp")).meta.storageErrorMm).toBeGreaterThan(0);
  });
});

/** Points of the vectors, and u there by what has arrived. */
function look(warp: Warp, name: string): Float64Array {
  const out = new Float64Array(vector(`${name}.points`).length);
  warp.displacement(vector(`${name}.points`), out);
  return out;
}

describe("a file that arrives", () => {
  test.each(["half", "levels"] as const)("piece by piece is used as soon as may be: %s", (name) => {
    const bytes = fileBytes(`${name}.warp`);
    const file = new WarpFile(name);
    const errors: number[] = [];
    let levels = 0;
    for (let at = 0; at < bytes.length; at += 1000) {
      file.push(bytes.subarray(at, at + 1000));
      const tail = file.tail;
      if (tail && levels === 0 && at < 5000) {
        file.pushTail(bytes.subarray(...tail));
      }
      const warp = file.warp as Warp | null;
      if (warp && warp.levelsLoaded > levels) {
        levels = warp.levelsLoaded;
        const u = look(warp, name);
        const known = u.map((value, n) =>
          Number.isNaN(value) ? Number.NaN : vector(`${name}.displacement`)[n]!,
        );
        errors.push(difference(u, known));
      }
    }
    file.finish();
    expect(errors.length).toBeGreaterThan(1);
    expect(errors.at(-1)).toBeLessThan(1e-9);
    if (name === "levels") {
      // every level is there from the first on, and better with each
      expect(errors.length).toBe(4);
      expect(errors[0]).toBeGreaterThan(errors[2]!);
      expect(errors[0]).toBeLessThan(0.02);
    }
  });

  test("tells what is missing", () => {
    const bytes = withMeta(LEVELS, (meta) => {
      meta.notes = { level_errors_mm: [4, 2, 1, 0] };
      meta.storage_error_mm = 0.5;
    });
    const file = new WarpFile("levels.warp");
    const added = new Map<number, number>();
    for (let at = 0; at < bytes.length; at += 1000) {
      file.push(bytes.subarray(at, at + 1000));
      if (at === 4000) {
        file.pushTail(bytes.subarray(...file.tail!));
      }
      const warp = file.warp as TableWarp | null;
      if (warp) {
        added.set(warp.levelsLoaded, warp.addedErrorMm);
      }
    }
    expect([...added]).toEqual([
      [1, 4.5],
      [2, 2.5],
      [3, 1.5],
      [4, 0.5],
    ]);
    expect(parseWarp(LEVELS).addedErrorMm).toBe(0);
    const untold = new WarpFile("levels.warp");
    untold.push(LEVELS.subarray(0, 15_000));
    untold.pushTail(LEVELS.subarray(...untold.tail!));
    expect(untold.warp?.addedErrorMm).toBeNaN();
  });

  test("gives NaN where a brick leaves all to children that have not come", () => {
    const file = new WarpFile("half.warp");
    const bytes = fileBytes("half.warp");
    const rows = parseWarp(bytes);
    expect(rows.levelCount).toBe(3);
    // all but the last row: the levels 0 (no values of its own) and 1 are there
    file.push(bytes.subarray(0, bytes.length - 8 * 729 * 6 - 729 * 6));
    expect(file.warp?.levelsLoaded).toBe(1);
    const x = vector("half.points").slice(0, 3);
    (file.warp as TableWarp).displacement(x, x);
    expect(x).toEqual(Float64Array.of(Number.NaN, Number.NaN, Number.NaN));
  });
});

describe("over HTTP", () => {
  let server: Server;
  let address = "";
  const requests: string[] = [];
  /** What the server has not said yet. */
  const rests: (() => void)[] = [];
  const letThrough = () => {
    for (const say of rests.splice(0)) say();
  };
  beforeAll(async () => {
    server = createServer((request, response) => {
      const range = /bytes=(\d+)-(\d+)/.exec(request.headers.range ?? "");
      requests.push(`${request.url} ${request.headers.range ?? "whole"}`);
      if (request.url === "/none.warp") {
        response.writeHead(404).end();
        return;
      }
      const bytes = fileBytes(request.url!.slice(1).replace("cut-", ""));
      if (range) {
        response.writeHead(206).end(bytes.subarray(Number(range[1]), Number(range[2]) + 1));
      } else {
        const end = request.url!.startsWith("/cut-") ? 20_000 : bytes.length;
        response.writeHead(200);
        response.write(bytes.subarray(0, 12_000));
        rests.push(() => response.end(bytes.subarray(12_000, end)));
      }
    });
    await new Promise<void>((resolve) => server.listen(0, "127.0.0.1", resolve));
    const bound = server.address();
    address = `http://127.0.0.1:${typeof bound === "object" ? bound?.port : ""}`;
  });
  afterAll(() => server.close());

  test("a warp can be used before all of it is there, its index fetched ahead", async () => {
    const seen: number[] = [];
    const { warp, complete } = await openWarp(`${address}/levels.warp`, {
      onLevel: (levels) => seen.push(levels),
    });
    expect(warp.levelsLoaded).toBe(1);
    letThrough();
    await complete;
    expect(seen).toEqual([1, 4]);
    expect(difference(look(warp as Warp, "levels"), vector("levels.displacement"))).toBeLessThan(
      1e-9,
    );
    expect(requests).toEqual([
      expect.stringMatching(/whole/),
      expect.stringMatching(/bytes=\d+-\d+/),
    ]);
  });

  test("a missing file is told of", async () => {
    await expect(openWarp(`${address}/none.warp`)).rejects.toThrow(/There is no warp file .*404/);
  });

  test("a file that breaks off fails the promise of the rest", async () => {
    const { complete } = await openWarp(`${address}/cut-levels.warp`);
    letThrough();
    await expect(complete).rejects.toThrow(/cannot be read \(\d+ bytes are missing\)/);
  });

  test("a server that is not there is told of", async () => {
    await expect(openWarp("http://127.0.0.1:1/x.warp")).rejects.toThrow(/cannot be reached/);
  });
});
