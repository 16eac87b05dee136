import type { AffineBases } from "./bases.js";
import { WarpFileError } from "./errors.js";
import { WarpFile } from "./file.js";
import type { PlaneWarp } from "./plane.js";
import type { TableWarp } from "./table.js";

/** A warp on its way: it can be used at once and is refined as levels arrive. */
export interface ArrivingWarp {
  readonly warp: TableWarp | PlaneWarp | AffineBases;
  /** Fulfilled when all levels are there; rejected with a WarpFileError where the file breaks off. */
  readonly complete: Promise<void>;
}

export interface FetchOptions {
  readonly signal?: AbortSignal;
  /** After each level that arrived: how many can be used, of how many. */
  readonly onLevel?: (levelsLoaded: number, levelCount: number) => void;
  /** After each piece that arrived: bytes so far, and of the whole file once that is known. */
  readonly onProgress?: (bytes: number, total: number | null) => void;
}

/**
 * Fetch a warp file. Fulfilled as soon as its coarsest level can be used.
 *
 * Files in float16 have their values last and so come coarse levels first in one request. In others
 * the index stands after the values: where the server can send parts it is asked for ahead.
 *
 * @throws WarpFileError the file is missing, truncated, foreign, newer or inconsistent.
 */
export function openWarp(
  source: string | URL | Response,
  options: FetchOptions = {},
): Promise<ArrivingWarp> {
  return new Promise((resolve, reject) => {
    let opened = false;
    const complete = receive(source, options, (warp) => {
      opened = true;
      resolve({ warp, complete });
    });
    complete.catch((error: unknown) => {
      if (!opened) {
        reject(error);
      }
    });
  });
}

async function receive(
  source: string | URL | Response,
  options: FetchOptions,
  open: (warp: TableWarp | PlaneWarp | AffineBases) => void,
): Promise<void> {
  const name = source instanceof Response ? source.url || "The warp file" : String(source);
  const response = source instanceof Response ? source : await request(source, options.signal);
  if (!response.ok || !response.body) {
    throw new WarpFileError(
      `There is no warp file ${name} (the server says ${response.status} ${response.statusText}); give the address that a warp was saved to.`,
    );
  }
  const file = new WarpFile(name);
  let levels = 0;
  let opened = false;
  const report = (): void => {
    const { warp } = file;
    if (warp && !opened) {
      opened = true;
      open(warp);
    }
    if (warp && warp.levelsLoaded !== levels) {
      levels = warp.levelsLoaded;
      options.onLevel?.(levels, warp.levelCount);
    }
  };
  let asked = source instanceof Response;
  let bytes = 0;
  const reader = response.body.getReader();
  for (;;) {
    const { done, value } = await read(reader, name);
    if (done) {
      break;
    }
    bytes += value.length;
    file.push(value);
    options.onProgress?.(bytes, file.length);
    if (file.length !== null && !asked) {
      asked = true;
      if (file.tail) {
        // not awaited: it may as well come in its turn, with the rest
        void fetchTail(response.url, file, options.signal).then(report, () => undefined);
      }
    }
    report();
  }
  file.finish();
  report();
}

async function request(source: string | URL, signal?: AbortSignal): Promise<Response> {
  try {
    return await fetch(source, signal ? { signal } : {});
  } catch (error) {
    signal?.throwIfAborted();
    throw new WarpFileError(
      `${source} cannot be reached (${String(error)}); check the connection, then try again.`,
    );
  }
}

async function read(
  reader: ReadableStreamDefaultReader<Uint8Array>,
  name: string,
): Promise<ReadableStreamReadResult<Uint8Array>> {
  try {
    return await reader.read();
  } catch (error) {
    if (error instanceof DOMException && error.name === "AbortError") {
      throw error;
    }
    throw new WarpFileError(
      `${name} broke off while it was read (${String(error)}); check the connection, then try again.`,
    );
  }
}

async function fetchTail(url: string, file: WarpFile, signal?: AbortSignal): Promise<void> {
  const [begin, end] = file.tail!;
  const headers = { Range: `bytes=${begin}-${end - 1}` };
  const response = await fetch(url, signal ? { headers, signal } : { headers });
  const bytes = response.status === 206 ? new Uint8Array(await response.arrayBuffer()) : null;
  if (bytes?.length === end - begin) {
    file.pushTail(bytes);
  } else {
    await response.body?.cancel(); // it comes in its turn
  }
}
