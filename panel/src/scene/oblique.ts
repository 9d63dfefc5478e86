/**
 * The oblique drawing that the hexapod's own program showed: the picture plane is seen true to scale, x to the right
 * and z up, and the third axis y, away from who looks, runs at 45 degrees with the factor sqrt(2)/2. Parallel lines
 * stay parallel, and lengths along all three axes can be measured in it.
 */
import { Matrix4, OrthographicCamera, Vector3 } from 'three';
import type { Vec3 } from '../logic/types';

export const kAngle = Math.PI / 4;
export const kFactor = Math.SQRT1_2;
/** Of a metre away: how far to the right and up it is drawn. */
const kAside = kFactor * Math.cos(kAngle);
const kUp = kFactor * Math.sin(kAngle);

/** Where a place is drawn, m to the right and m up of where the origin is. */
export const oblique = ([x, y, z]: Vec3): [number, number] => [x + kAside * y, z + kUp * y];

/** Looks along +y; what is as far away as the centre is drawn where it is. */
export class ObliqueCamera extends OrthographicCamera {
  /** m from the camera to its centre. */
  private away = 1;
  private halfHeight = 1;
  private aspect = 1;
  private readonly shear = new Matrix4();

  /** @param halfHeight  m, of the picture */
  lookAtCentre(centre: Vector3, away: number, halfHeight: number): void {
    this.away = away;
    this.halfHeight = halfHeight;
    this.zoom = 1;
    this.near = 0.01;
    this.far = away + 40;
    this.up.set(0, 0, 1);
    this.position.set(centre.x, centre.y - away, centre.z);
    this.lookAt();
    this.fit(this.aspect);
  }
  /** Whoever steers it may move it, never turn it. */
  override lookAt(): void {
    this.rotation.set(Math.PI / 2, 0, 0);
  }

  /** @param aspect  of the picture, width by height */
  fit(aspect: number): void {
    this.aspect = aspect;
    this.top = this.halfHeight;
    this.bottom = -this.top;
    this.right = this.halfHeight * aspect;
    this.left = -this.right;
    this.updateProjectionMatrix();
  }

  /** Sheared here and not in the projection: rays of the pointer are made from this matrix, too. */
  override updateMatrixWorld(): void {
    this.updateMatrix();
    // Back from the drawing to the place: its view's -z is y.
    this.shear.set(1, 0, kAside, kAside * this.away, 0, 1, kUp, kUp * this.away, 0, 0, 1, 0, 0, 0, 0, 1);
    this.matrixWorld.copy(this.matrix).multiply(this.shear);
    this.matrixWorldInverse.copy(this.matrixWorld).invert();
  }
  override updateWorldMatrix(): void {
    this.updateMatrixWorld();
  }
}
