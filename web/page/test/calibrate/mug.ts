import {
  type BufferGeometry,
  CatmullRomCurve3,
  LatheGeometry,
  TubeGeometry,
  Vector2,
  Vector3,
} from "three";
import { mergeGeometries, mergeVertices } from "three/addons/utils/BufferGeometryUtils.js";
import { ContactSurface } from "../../src/calibrate/surface.js";

/** A mug like the demo's: 80 mm wide, 95 mm tall, walls of 4 mm; z up; its handle in +x. */
export function mugSurface(withHandle = true): ContactSurface {
  const profile = [
    [0, 0],
    [0.04, 0],
    [0.04, 0.05],
    [0.04, 0.095],
    [0.036, 0.095],
    [0.036, 0.05],
    [0.036, 0.006],
    [0, 0.006],
  ];
  const body = new LatheGeometry(
    profile.map(([r, h]) => new Vector2(r, h)),
    64,
  );
  const parts: BufferGeometry[] = [body];
  if (withHandle) {
    const arc = Array.from({ length: 9 }, (_, k) => {
      const angle = -Math.PI / 2 + (Math.PI * k) / 8;
      return new Vector3(0.038 + 0.03 * Math.cos(angle), 0.048 + 0.03 * Math.sin(angle), 0);
    });
    parts.push(new TubeGeometry(new CatmullRomCurve3(arc), 24, 0.006, 10));
  }
  for (const part of parts) {
    part.deleteAttribute("uv");
    part.deleteAttribute("normal");
  }
  const merged = mergeVertices(mergeGeometries(parts), 1e-6);
  merged.rotateX(Math.PI / 2); // y up to z up
  const positions = new Float32Array(merged.getAttribute("position").array);
  const faces = new Uint32Array(merged.getIndex()!.array);
  return new ContactSurface(positions, faces);
}
