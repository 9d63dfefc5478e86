/** What stands on a camera's table, and where the camera looks. */
import { BoxGeometry, BufferGeometry, Float32BufferAttribute, Group, LineSegments, Mesh, MeshLambertMaterial, type LineBasicMaterial, type Material } from 'three';
import { paintOf } from '../logic/camera';
import { add, fromFixedXyz, fromFlat, rotate } from '../logic/pose';
import type { Lens } from '../logic/lens';
import type { BasketJson, SeenCubeJson, Vec3 } from '../logic/types';
import { place } from './body';

const kWall = 0.003; // m

/** Floor and four walls. */
export function basketOf(basket: BasketJson, material: Material): Group {
  const group = new Group();
  place(group, fromFlat(basket));
  const { length_m: x, width_m: y, height_m: z } = basket;
  const wall = (size: Vec3, at: Vec3) => {
    const mesh = new Mesh(new BoxGeometry(...size), material);
    mesh.position.set(...at);
    mesh.castShadow = mesh.receiveShadow = true;
    group.add(mesh);
  };
  wall([x, y, kWall], [0, 0, kWall / 2]);
  for (const side of [-1, 1]) {
    wall([kWall, y + 2 * kWall, z], [(side * (x + kWall)) / 2, 0, z / 2]);
    wall([x, kWall, z], [0, (side * (y + kWall)) / 2, z / 2]);
  }
  return group;
}

const paints = new Map<string, MeshLambertMaterial>();
function paint(color: string): MeshLambertMaterial {
  let one = paints.get(color);
  if (!one) {
    one = new MeshLambertMaterial({ color: paintOf(color) });
    paints.set(color, one);
  }
  return one;
}

/** Nothing where its place is not known. */
export function cubeOf(cube: SeenCubeJson): Mesh | null {
  if (cube.x_m === undefined || cube.edge_m === undefined) return null;
  const edge = cube.edge_m;
  const mesh = new Mesh(new BoxGeometry(edge, edge, edge), paint(cube.color));
  place(mesh, { p: [cube.x_m, cube.y_m!, cube.z_m! - edge / 2], q: fromFixedXyz([0, 0, cube.yaw_rad ?? 0]) });
  mesh.castShadow = mesh.receiveShadow = true;
  return mesh;
}

/** Edges of what a camera sees, from its lens to the table. */
export function frustumOf(lens: Lens, material: LineBasicMaterial): LineSegments {
  const { p, q } = fromFlat(lens.pose);
  const [w, h] = [lens.width_px / (2 * lens.fx_px), lens.height_px / (2 * lens.fy_px)];
  const corners = ([[-w, -h], [w, -h], [w, h], [-w, h]] as const).map(([x, y]): Vec3 => {
    const ray = rotate(q, [x, y, 1]);
    // As far as the table, or an arm's length where it looks above it.
    const far = ray[2] < -0.1 ? -p[2] / ray[2] : 0.5;
    return add(p, [ray[0] * far, ray[1] * far, ray[2] * far]);
  });
  const places: number[] = [];
  corners.forEach((corner, i) => places.push(...p, ...corner, ...corner, ...corners[(i + 1) % 4]!));
  const geometry = new BufferGeometry();
  geometry.setAttribute('position', new Float32BufferAttribute(places, 3));
  return new LineSegments(geometry, material);
}
