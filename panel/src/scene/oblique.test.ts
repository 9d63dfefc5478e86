import { Raycaster, Vector2, Vector3 } from 'three';
import { describe, expect, it } from 'vitest';
import type { Vec3 } from '../logic/types';
import { oblique, ObliqueCamera } from './oblique';

describe('the oblique drawing', () => {
  it('is true to scale in x and z, and draws y at 45 degrees with the factor sqrt(2)/2', () => {
    expect(oblique([0.3, 0, 0])).toEqual([0.3, 0]);
    expect(oblique([0, 0, 0.2])).toEqual([0, 0.2]);
    const [x, y] = oblique([0, 1, 0]);
    expect(Math.hypot(x, y)).toBeCloseTo(Math.SQRT2 / 2, 12);
    expect(Math.atan2(y, x)).toBeCloseTo(Math.PI / 4, 12);
    expect(oblique([0, -0.4, 0])[0]).toBeCloseTo(-0.2, 12);
  });

  it('keeps parallels parallel: places add up', () => {
    const [a, b]: [Vec3, Vec3] = [[0.1, -0.7, 0.3], [-0.5, 0.2, 0.9]];
    const sum = oblique([a[0] + b[0], a[1] + b[1], a[2] + b[2]]);
    expect(sum[0]).toBeCloseTo(oblique(a)[0] + oblique(b)[0], 12);
    expect(sum[1]).toBeCloseTo(oblique(a)[1] + oblique(b)[1], 12);
  });
});

describe('its camera', () => {
  const centre = new Vector3(0.4, -0.3, 0.25);
  const camera = new ObliqueCamera();
  camera.fit(1.5);
  camera.lookAtCentre(centre, 6, 0.8);
  camera.updateMatrixWorld();
  const places: Vec3[] = [[0.4, -0.3, 0.25], [0, 0, 0], [0.5, 0.4, 0.3], [0.2, -0.9, 0.6], [1, 1, 0]];

  it('draws each place where the drawing has it', () => {
    for (const place of places) {
      const seen = new Vector3(...place).project(camera);
      const [x, y] = oblique([place[0] - centre.x, place[1] - centre.y, place[2] - centre.z]);
      expect(seen.x, String(place)).toBeCloseTo(x / (0.8 * 1.5), 6);
      expect(seen.y, String(place)).toBeCloseTo(y / 0.8, 6);
      expect(Math.abs(seen.z)).toBeLessThan(1);
    }
  });

  it('points at what is drawn under the pointer', () => {
    for (const place of places) {
      const at = new Vector3(...place);
      const seen = at.clone().project(camera);
      const ray = new Raycaster();
      ray.setFromCamera(new Vector2(seen.x, seen.y), camera);
      expect(ray.ray.distanceToPoint(at), String(place)).toBeLessThan(1e-6);
    }
  });

  it('keeps its middle where it looks, however wide the picture is and however near', () => {
    camera.fit(0.5);
    camera.zoom = 3;
    camera.updateProjectionMatrix();
    const seen = centre.clone().project(camera);
    expect(seen.x).toBeCloseTo(0, 9);
    expect(seen.y).toBeCloseTo(0, 9);
    expect(new Vector3(centre.x, centre.y, centre.z + 0.1).project(camera).y).toBeCloseTo((3 * 0.1) / 0.8, 6);
  });
});
