import { afterEach, beforeEach, describe, expect, it, vi } from "vitest";
import { fetchSurface, persistently, SurfaceError } from "../../src/world/surface.js";

/** One triangle; see `pack_surface` of the server. */
function packed(): ArrayBuffer {
  const bytes = new ArrayBuffer(8 + 2 * 36 + 12);
  new Uint32Array(bytes, 0, 2).set([3, 1]);
  new Uint32Array(bytes, 8 + 72, 3).set([0, 1, 2]);
  return bytes;
}

const cutOff = () =>
  new Response(
    new ReadableStream({
      pull(control) {
        control.error(new TypeError("network error"));
      },
    }),
  );

let answers: (() => Response)[];

beforeEach(() => {
  vi.stubGlobal("document", { baseURI: "http://localhost/" });
  vi.stubGlobal("fetch", async () => answers.shift()!());
});
afterEach(() => vi.unstubAllGlobals());

const gone = () => {
  throw new TypeError("Failed to fetch");
};
const unknown = () => new Response("", { status: 404 });

describe("a surface", () => {
  it.each([
    ["Failed to fetch", gone],
    ["404", unknown],
    ["network error", cutOff],
  ])("that does not come says why: %s", async (reason, answer) => {
    answers = [answer];
    await expect(fetchSurface("./surfaces/a.bin")).rejects.toThrow(
      new SurfaceError("./surfaces/a.bin", reason),
    );
  });

  it("comes in the end, whatever befalls the server meanwhile", async () => {
    answers = [cutOff, gone, gone, unknown, () => new Response(packed())];
    const { faces } = await persistently(() => fetchSurface("./surfaces/a.bin"), 1);
    expect([...faces]).toEqual([0, 1, 2]);
    expect(answers).toEqual([]);
  });

  it("is not asked for again for a defect of the page", async () => {
    const load = vi.fn(async () => {
      throw new RangeError("a defect");
    });
    await expect(persistently(load, 1)).rejects.toThrow("a defect");
    expect(load).toHaveBeenCalledTimes(1);
  });
});
