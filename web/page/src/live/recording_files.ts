import { strToU8, Zip, ZipDeflate } from "three/addons/libs/fflate.module.js";
import type { BeginRecording, ChunkHeader } from "./messages.js";

/** Some of the chunks of a recording, in their order. */
export interface Part {
  readonly header: ChunkHeader;
  /** (rows, columns) */
  readonly numbers: Float64Array;
}

/**
 * A recording as one zip of two files, the same that `touchwarp recordings export` writes: its rows
 * as `recording.csv` and what is told of it, notes among that, as `about.json`.
 */
export async function zipRecording(
  begin: BeginRecording,
  version: string,
  parts: AsyncIterable<Part>,
): Promise<Blob> {
  const packed: BlobPart[] = [];
  let failure: Error | null = null;
  const zip = new Zip((error, bytes) => {
    failure ??= error;
    packed.push(bytes as Uint8Array<ArrayBuffer>);
  });
  const table = new ZipDeflate("recording.csv", { level: 1 });
  zip.add(table);
  table.push(strToU8(csvHead(begin.columns)));
  const notes: { chunk: number; text: string }[] = [];
  for await (const { header, numbers } of parts) {
    table.push(strToU8(csvRows(header, numbers)));
    for (const text of header.notes ?? []) notes.push({ chunk: header.sequence, text });
  }
  table.push(new Uint8Array(), true);
  const about = new ZipDeflate("about.json", { level: 1 });
  zip.add(about);
  about.push(strToU8(JSON.stringify(aboutOf(begin, version, notes), null, 1)), true);
  zip.end();
  if (failure) throw failure;
  return new Blob(packed, { type: "application/zip" });
}

function aboutOf(begin: BeginRecording, version: string, notes: readonly object[]): object {
  const { participant, recording, consent, started, device, columns } = begin;
  const touchwarp_version = version;
  return { participant, recording, consent, started, device, touchwarp_version, columns, notes };
}

function csvHead(columns: readonly string[]): string {
  return `${[...columns, "warp", "chunk"].map(quoted).join(",")}\n`;
}

function csvRows({ rows, warp, sequence }: ChunkHeader, numbers: Float64Array): string {
  const width = rows > 0 ? numbers.length / rows : 0;
  const tail = `,${quoted(warp)},${sequence}\n`;
  let text = "";
  for (let row = 0; row < rows; row++) {
    const values = Array.from(numbers.subarray(row * width, (row + 1) * width), numberText);
    text += values.join(",") + tail;
  }
  return text;
}

/** As few digits as bring the number back to the last bit. */
function numberText(value: number): string {
  if (Number.isNaN(value)) return "nan";
  return Object.is(value, -0) ? "-0" : String(value);
}

function quoted(text: string): string {
  return `"${text.replaceAll('"', '""')}"`;
}
