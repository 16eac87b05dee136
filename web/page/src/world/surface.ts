import { BufferAttribute, BufferGeometry } from "three";
import { toCreasedNormals } from "three/examples/jsm/utils/BufferGeometryUtils.js";

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

/** Corners in the order of `faces`, with normals that keep edges of more than 35° sharp. */
export function geometryOf(points: Float32Array, faces: Uint32Array): BufferGeometry {
  const indexed = new BufferGeometry();
  indexed.setAttribute("position", new BufferAttribute(points, 3));
  indexed.setIndex(new BufferAttribute(faces, 1));
  return toCreasedNormals(indexed, (35 / 180) * Math.PI);
}

/** Unit normals at the vertices, (n, 3), weighted by area. */
export function vertexNormals(points: Float32Array, faces: Uint32Array): Float32Array {
  const geometry = new BufferGeometry();
  geometry.setAttribute("position", new BufferAttribute(points, 3));
  geometry.setIndex(new BufferAttribute(faces, 1));
  geometry.computeVertexNormals();
  return geometry.getAttribute("normal").array as Float32Array;
}
