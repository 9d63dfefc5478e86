import { describe, expect, it } from 'vitest';
import { onPlane, project, type Lens } from './lens';
import { fromFixedXyz } from './pose';

/** Half a metre above the table, straight down, its picture's y towards -y of the cell. */
const lens: Lens = {
  pose: { x_m: 1, y_m: 0.2, z_m: 0.5, quaternion_wxyz: fromFixedXyz([Math.PI, 0, 0]) },
  width_px: 640, height_px: 480, fx_px: 800, fy_px: 800, cx_px: 320, cy_px: 240,
  distortion: [0, 0, 0, 0, 0], accuracy_m: 0.001,
};

describe('a camera that is calibrated', () => {
  it('sees a place of the cell at a pixel', () => {
    const p = project(lens, [1.05, 0.2, 0])!;
    expect(p[0]).toBeCloseTo(320 + 80);
    expect(p[1]).toBeCloseTo(240);
    expect(project(lens, [1, 0.25, 0])![1]).toBeCloseTo(240 - 80);
    expect(project(lens, [1, 0.2, 0.6])).toBeNull();
  });
  it('knows where on a plane a pixel lies, also through a bad lens', () => {
    for (const distortion of [[0, 0, 0, 0, 0], [-0.2, 0.08, 1e-3, -2e-3, 0.01]] as Lens['distortion'][]) {
      const bad = { ...lens, distortion };
      for (const [x, y, z] of [[0.95, 0.1, 0], [1.1, 0.29, 0.05], [1, 0.2, 0.025]] as const) {
        const back = onPlane(bad, project(bad, [x, y, z])!, z)!;
        expect(back[0]).toBeCloseTo(x, 5);
        expect(back[1]).toBeCloseTo(y, 5);
        expect(back[2]).toBeCloseTo(z, 9);
      }
    }
  });
  it('knows nothing of planes that it does not look at', () => {
    expect(onPlane(lens, [320, 240], 0.7)).toBeNull();
  });
});
