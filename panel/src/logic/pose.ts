/** Poses and rotations; quaternions w, x, y, z of length 1. X_AB * X_BC reads right. */
import type { FlatPoseJson, Pose, PoseJson, Quat, ToolRow, Vec3 } from './types';

export const kIdentity: Pose = { p: [0, 0, 0], q: [1, 0, 0, 0] };

export const multiply = (a: Quat, b: Quat): Quat => [
  a[0] * b[0] - a[1] * b[1] - a[2] * b[2] - a[3] * b[3],
  a[0] * b[1] + a[1] * b[0] + a[2] * b[3] - a[3] * b[2],
  a[0] * b[2] - a[1] * b[3] + a[2] * b[0] + a[3] * b[1],
  a[0] * b[3] + a[1] * b[2] - a[2] * b[1] + a[3] * b[0],
];

export function rotate(q: Quat, v: Vec3): Vec3 {
  const [w, x, y, z] = q;
  const tx = 2 * (y * v[2] - z * v[1]);
  const ty = 2 * (z * v[0] - x * v[2]);
  const tz = 2 * (x * v[1] - y * v[0]);
  return [
    v[0] + w * tx + y * tz - z * ty,
    v[1] + w * ty + z * tx - x * tz,
    v[2] + w * tz + x * ty - y * tx,
  ];
}

export const add = (a: Vec3, b: Vec3): Vec3 => [a[0] + b[0], a[1] + b[1], a[2] + b[2]];

export const compose = (a: Pose, b: Pose): Pose => ({
  p: add(a.p, rotate(a.q, b.p)),
  q: multiply(a.q, b.q),
});

export function inverse(pose: Pose): Pose {
  const q: Quat = [pose.q[0], -pose.q[1], -pose.q[2], -pose.q[3]];
  const p = rotate(q, pose.p);
  return { p: [-p[0], -p[1], -p[2]], q };
}

export const fromJson = (json: PoseJson): Pose => ({ p: json.xyz_m, q: json.quaternion_wxyz });
export const fromFlat = (json: FlatPoseJson): Pose => ({
  p: [json.x_m, json.y_m, json.z_m],
  q: json.quaternion_wxyz,
});
export const fromRow = (row: ToolRow): Pose => ({
  p: [row[0], row[1], row[2]],
  q: [row[3], row[4], row[5], row[6]],
});

/** The quaternion of a rotation by its columns. */
export function fromColumns(x: Vec3, y: Vec3, z: Vec3): Quat {
  const trace = x[0] + y[1] + z[2];
  if (trace > 0) {
    const s = 2 * Math.sqrt(1 + trace);
    return [s / 4, (y[2] - z[1]) / s, (z[0] - x[2]) / s, (x[1] - y[0]) / s];
  }
  if (x[0] > y[1] && x[0] > z[2]) {
    const s = 2 * Math.sqrt(1 + x[0] - y[1] - z[2]);
    return [(y[2] - z[1]) / s, s / 4, (y[0] + x[1]) / s, (z[0] + x[2]) / s];
  }
  if (y[1] > z[2]) {
    const s = 2 * Math.sqrt(1 + y[1] - x[0] - z[2]);
    return [(z[0] - x[2]) / s, (y[0] + x[1]) / s, s / 4, (z[1] + y[2]) / s];
  }
  const s = 2 * Math.sqrt(1 + z[2] - x[0] - y[1]);
  return [(x[1] - y[0]) / s, (z[0] + x[2]) / s, (z[1] + y[2]) / s, s / 4];
}

/** Turns about the fixed axes x, then y, then z: R = Rz(rz) Ry(ry) Rx(rx). */
export function fixedXyz(q: Quat): Vec3 {
  const [w, x, y, z] = q;
  const sin = 2 * (w * y - x * z);
  if (Math.abs(sin) > 1 - 1e-12) {
    return [0, Math.sign(sin) * (Math.PI / 2), Math.atan2(-2 * (x * y - w * z), 1 - 2 * (x * x + z * z))];
  }
  return [
    Math.atan2(2 * (w * x + y * z), 1 - 2 * (x * x + y * y)),
    Math.asin(sin),
    Math.atan2(2 * (w * z + x * y), 1 - 2 * (y * y + z * z)),
  ];
}

export function fromFixedXyz([rx, ry, rz]: Vec3): Quat {
  const about = (angle: number, axis: 1 | 2 | 3): Quat => {
    const q: Quat = [Math.cos(angle / 2), 0, 0, 0];
    q[axis] = Math.sin(angle / 2);
    return q;
  };
  return multiply(multiply(about(rz, 3), about(ry, 2)), about(rx, 1));
}
