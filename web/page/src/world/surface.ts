import { BufferAttribute, BufferGeometry } from "three";

/** A prop's surface with where each vertex shall appear; see `pack_surface` of the server. */
export interface PackedSurface {
  /** (n, 3) m, scene frame. */
  readonly prop: Float32Array;
  readonly virtual: Float32Array;
  readonly faces: Uint32Array;
}

export async function fetchSurface(url: string): Promise<PackedSurface> {
  const answer = await fetch(new URL(url, document.baseURI));
  if (!answer.ok) throw new Error(`The surface ${url} cannot be fetched (${answer.status}).`);
  return unpackSurface(await answer.arrayBuffer());
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
