/** Where a camera's picture shows what stands in the cell, and the other way round. */
import { add, fromFlat, inverse, rotate } from './pose';
import type { CellCamera, FlatPoseJson, Vec3 } from './types';

export type Lens = NonNullable<CellCamera['lens']> & { pose: FlatPoseJson };
export type Pixel = [number, number];

/** m; what is nearer to the lens, or behind it, has no place in the picture. */
const kNearest = 0.01;
const kRounds = 12;

/** Brown's lens errors: from straight lines to what is seen. */
function bent([x, y]: Pixel, [k1, k2, p1, p2, k3]: Lens['distortion']): Pixel {
  const r2 = x * x + y * y;
  const radial = 1 + r2 * (k1 + r2 * (k2 + r2 * k3));
  return [x * radial + 2 * p1 * x * y + p2 * (r2 + 2 * x * x), y * radial + p1 * (r2 + 2 * y * y) + 2 * p2 * x * y];
}

/** @param p  m, in the cell. @returns  px of the picture that it was calibrated with */
export function project(lens: Lens, p: Vec3): Pixel | null {
  const to = inverse(fromFlat(lens.pose));
  const [x, y, z] = add(to.p, rotate(to.q, p));
  if (z < kNearest) return null;
  const [u, v] = bent([x / z, y / z], lens.distortion);
  return [lens.cx_px + lens.fx_px * u, lens.cy_px + lens.fy_px * v];
}

/** What is seen at a pixel on the level plane of this height in the cell; nothing where it looks above it. */
export function onPlane(lens: Lens, [px, py]: Pixel, height: number): Vec3 | null {
  const wanted: Pixel = [(px - lens.cx_px) / lens.fx_px, (py - lens.cy_px) / lens.fy_px];
  let at: Pixel = wanted;
  for (let round = 0; round < kRounds; ++round) {
    const [u, v] = bent(at, lens.distortion);
    at = [at[0] + wanted[0] - u, at[1] + wanted[1] - v];
  }
  const { p, q } = fromFlat(lens.pose);
  const ray = rotate(q, [at[0], at[1], 1]);
  const far = (height - p[2]) / ray[2];
  if (!(far > 0) || !Number.isFinite(far)) return null;
  return add(p, [ray[0] * far, ray[1] * far, ray[2] * far]);
}
