/** Where a robot can take cubes, drawn on the table. */
import { BufferGeometry, Float32BufferAttribute, Group, LineBasicMaterial, LineLoop, Mesh, MeshBasicMaterial, Shape, ShapeGeometry, type Color } from 'three';
import { outlines, smooth, straightDown, taken, type Place } from '../logic/region';
import type { CubeReachJson } from '../logic/types';

const kAbove = 0.0015; // m, over the table

const areaOf = (loop: readonly Place[]): number =>
  loop.reduce((sum, [x, y], i) => {
    const [u, v] = loop[(i + 1) % loop.length]!;
    return sum + (x * v - u * y) / 2;
  }, 0);

function holds(loop: readonly Place[], [x, y]: Place): boolean {
  let inside = false;
  loop.forEach(([ax, ay], i) => {
    const [bx, by] = loop[(i + 1) % loop.length]!;
    if (ay > y !== by > y && x < ax + ((y - ay) / (by - ay)) * (bx - ax)) inside = !inside;
  });
  return inside;
}

const pathOf = (loop: readonly Place[]): Shape => {
  const shape = new Shape();
  loop.forEach(([x, y], i) => (i === 0 ? shape.moveTo(x, y) : shape.lineTo(x, y)));
  shape.closePath();
  return shape;
};

/** Outer loops with the holes in them: those turn the other way. */
function shapesOf(loops: readonly Place[][]): Shape[] {
  const turn = Math.sign(areaOf(loops.reduce((a, b) => (Math.abs(areaOf(a)) > Math.abs(areaOf(b)) ? a : b))));
  const outer = loops.filter((loop) => Math.sign(areaOf(loop)) === turn);
  const holes = loops.filter((loop) => Math.sign(areaOf(loop)) !== turn);
  return outer.map((loop) => {
    const shape = pathOf(loop);
    shape.holes = holes.filter((hole) => holds(loop, hole[0]!)).map(pathOf);
    return shape;
  });
}

export function regionOf(grid: CubeReachJson, color: Color): Group {
  const group = new Group();
  for (const [fits, opacity] of [[taken, 0.16], [straightDown, 0.22]] as const) {
    const loops = outlines(grid, fits).map((loop) => smooth(loop));
    if (loops.length === 0) continue;
    const fill = new MeshBasicMaterial({ color, transparent: true, opacity, depthWrite: false });
    const mesh = new Mesh(new ShapeGeometry(shapesOf(loops)), fill);
    mesh.position.z = grid.z_m + kAbove;
    group.add(mesh);
    for (const loop of loops) {
      const geometry = new BufferGeometry();
      geometry.setAttribute('position', new Float32BufferAttribute(loop.flatMap(([x, y]) => [x, y, grid.z_m + kAbove]), 3));
      group.add(new LineLoop(geometry, new LineBasicMaterial({ color, transparent: true, opacity: 0.8 })));
    }
  }
  return group;
}
