import { BufferAttribute, BufferGeometry } from "three";

/** A prop's surface with where each vertex shall appear; see `pack_surface` of the server. */
export interface PackedSurface {
  /** (n, 3) m, scene frame. */
  readonly prop: Float32Array;
  readonly virtual: Float32Array;
  readonly faces: Uint32Array;
}

/** A surface did not come: the server is gone, or does not know it. */
export class SurfaceError extends Error {
  constructor(url: string, reason: string) {
    super(`The surface ${url} cannot be fetched (${reason}).`);
  }
}

/** @throws SurfaceError */
export async function fetchSurface(url: string): Promise<PackedSurface> {
  const answer = await fetch(new URL(url, document.baseURI)).catch((error) => error as Error);
  if (answer instanceof Error) throw new SurfaceError(url, answer.message);
  if (!answer.ok) throw new SurfaceError(url, String(answer.status));
  const bytes = await answer.arrayBuffer().catch((error) => error as Error);
  if (bytes instanceof Error) throw new SurfaceError(url, bytes.message);
  return unpackSurface(bytes);
}

/** What `load` gives, once all its surfaces have come: a server may go and come back meanwhile. */
export async function persistently<T>(load: () => Promise<T>, pause = 1000): Promise<T> {
  for (;;) {
    try {
      return await load();
    } catch (error) {
      if (!(error instanceof SurfaceError)) throw error;
      await new Promise((resolve) => setTimeout(resolve, pause));
    }
  }
}

export function unpackSurface(bytes: ArrayBuffer): PackedSurface {
  const [vertices, faces] = new Uint32Array(bytes, 0, 2) as unknown as [number, number];
  const prop = new Float32Array(bytes, 8, 3 * vertices);
  const virtual = new Float32Array(bytes, 8 + 12 * vertices, 3 * vertices);
  return { prop, virtual, faces: new Uint32Array(bytes, 8 + 24 * vertices, 3 * faces) };
}

/** Vertices as they come, doubled along creases by the server, with normals weighted by area. */
export function geometryOf(points: Float32Array, faces: Uint32Array): BufferGeometry {
  const geometry = new BufferGeometry();
  geometry.setAttribute("position", new BufferAttribute(points, 3));
  geometry.setIndex(new BufferAttribute(faces, 1));
  geometry.computeVertexNormals();
  return geometry;
}
