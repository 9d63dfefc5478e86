import { BufferAttribute, BufferGeometry, Line, LineBasicMaterial, Vector3 } from 'three';

const kTrailPoints = 900;

/** The last places of a tool, in the world. */
export class Trail {
  readonly line: Line;
  private readonly places = new Float32Array(3 * kTrailPoints);
  private readonly geometry = new BufferGeometry();
  private count = 0;
  private last = new Vector3(NaN, 0, 0);

  constructor(material: LineBasicMaterial) {
    this.geometry.setAttribute('position', new BufferAttribute(this.places, 3));
    this.line = new Line(this.geometry, material);
    this.line.frustumCulled = false;
    this.geometry.setDrawRange(0, 0);
  }
  add(p: Vector3): boolean {
    if (this.last.distanceToSquared(p) < 1e-6) return false;
    this.last.copy(p);
    if (this.count === kTrailPoints) {
      this.places.copyWithin(0, 3);
      --this.count;
    }
    this.places.set([p.x, p.y, p.z], 3 * this.count);
    ++this.count;
    this.geometry.setDrawRange(0, this.count);
    this.geometry.attributes['position']!.needsUpdate = true;
    return true;
  }
  clear(): void {
    this.count = 0;
    this.last.set(NaN, 0, 0);
    this.geometry.setDrawRange(0, 0);
  }
}
