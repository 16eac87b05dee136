import { Vector3 } from "three";
import { ContactSurface } from "../../src/calibrate/surface.js";

/** A sphere of triangles. */
export function ball(centre: Vector3, radius: number, rings = 24): ContactSurface {
  const positions: number[] = [];
  const faces: number[] = [];
  const sides = 2 * rings;
  for (let ring = 0; ring <= rings; ring++) {
    for (let side = 0; side < sides; side++) {
      const point = new Vector3().setFromSphericalCoords(
        radius,
        (Math.PI * ring) / rings,
        (2 * Math.PI * side) / sides,
      );
      positions.push(...point.add(centre).toArray());
      if (ring === rings) continue;
      const [at, next] = [ring * sides + side, ring * sides + ((side + 1) % sides)];
      faces.push(at, at + sides, next, next, at + sides, next + sides);
    }
  }
  return new ContactSurface(Float32Array.from(positions), Uint32Array.from(faces));
}
