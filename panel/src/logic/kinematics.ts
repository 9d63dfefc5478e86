/**
 * Where each link is with the joints at q, for drawing. Chains and the four-bar linkage are
 * computed here, since a slider has to show its ghost before any answer came; a platform's pose
 * always comes from the server, which solves for it. A test holds this against the links' home
 * poses as the server computes them, of all robots.
 */
import { compose, fromColumns, fromJson, kIdentity } from './pose';
import type { PalletizerGeometry, Pose, Quat, RobotModel, SerialGeometry, Vec3 } from './types';

/** X_{i-1,i} = Rot_z(q + offset) Trans_z(d) Trans_x(a) Rot_x(alpha); what slides adds q to d instead. */
function dhLink(row: SerialGeometry['dh'][number], q: number): Pose {
  const theta = row.theta_offset_rad + (row.slides ? 0 : q);
  const half = theta / 2;
  const turn: Quat = [
    Math.cos(half) * Math.cos(row.alpha_rad / 2),
    Math.cos(half) * Math.sin(row.alpha_rad / 2),
    Math.sin(half) * Math.sin(row.alpha_rad / 2),
    Math.sin(half) * Math.cos(row.alpha_rad / 2),
  ];
  return { p: [row.a_m * Math.cos(theta), row.a_m * Math.sin(theta), row.d_m + (row.slides ? q : 0)], q: turn };
}

function serialLinks(geometry: SerialGeometry, q: readonly number[]): Pose[] {
  const links: Pose[] = [kIdentity];
  geometry.dh.forEach((row, i) => links.push(compose(links[i]!, dhLink(row, q[i] ?? 0))));
  links.push(compose(links.at(-1)!, fromJson(geometry.tool)));
  return links;
}

/** docs/kinematics/maxarm.md, eq. (14) to (17): each link lies along its frame's -y. */
function palletizerLinks(geometry: PalletizerGeometry, q: readonly number[]): Pose[] {
  const turn = geometry.base_front_rad - (q[0] ?? 0);
  const x: Vec3 = [Math.cos(turn), Math.sin(turn), 0];
  const outward: Vec3 = [Math.sin(turn), -Math.cos(turn), 0];
  const along = (out: number, up: number): Quat => {
    const y: Vec3 = [-out * outward[0], -out * outward[1], -up];
    const z: Vec3 = [-up * outward[0], -up * outward[1], out];
    return fromColumns(x, y, z);
  };
  const at = (out: number, up: number): Vec3 => [out * outward[0], out * outward[1], up];
  const shoulder = q[1] ?? 0;
  const forearm = q[2] ?? 0;
  const level = along(1, 0);
  const upper: [number, number] = [-Math.cos(shoulder), Math.sin(shoulder)];
  const fore: [number, number] = [Math.cos(forearm), -Math.sin(forearm)];
  const joint: [number, number] = [geometry.shoulder_offset_m, geometry.base_height_m];
  const elbow: [number, number] = [
    joint[0] + geometry.upper_arm_m * upper[0],
    joint[1] + geometry.upper_arm_m * upper[1],
  ];
  const nozzle: [number, number] = [
    elbow[0] + geometry.forearm_m * fore[0] + geometry.tool_offset_m,
    elbow[1] + geometry.forearm_m * fore[1],
  ];
  return [
    kIdentity,
    { p: [0, 0, 0], q: level },
    { p: at(...joint), q: along(...upper) },
    { p: at(...elbow), q: along(...fore) },
    { p: at(...nozzle), q: level },
  ];
}

/**
 * Poses of all links in base B, in the order of the model's links; of a hexapod's legs the base's.
 * @param platform  a hexapod's platform in base; its home where nobody knows
 */
export function linkPoses(model: RobotModel, q: readonly number[], platform?: Pose): Pose[] {
  if (model.kind === 'serial') return serialLinks(model.geometry, q);
  if (model.kind === 'palletizer') return palletizerLinks(model.geometry, q);
  const legs = model.geometry.base_anchors_m.map(() => kIdentity);
  return [kIdentity, ...legs, platform ?? fromJson(model.geometry.home)];
}

/** From the flange to the tips of a gripper's jaws, m. */
export function jawReach(gripper: NonNullable<SerialGeometry['gripper']>, width = gripper.width_m): number {
  const open = (width ?? gripper.width_max_m) / gripper.width_max_m;
  return gripper.reach_closed_m + open * (gripper.reach_open_m - gripper.reach_closed_m);
}

/** Where the tool is: with a gripper, between the tips of its jaws. */
export function toolPose(model: RobotModel, q: readonly number[], platform?: Pose): Pose {
  const tool = linkPoses(model, q, platform).at(-1)!;
  const gripper = model.kind === 'serial' ? model.geometry.gripper : undefined;
  const reach = gripper ? jawReach(gripper) : 0;
  return compose(tool, { p: [0, 0, reach], q: [1, 0, 0, 0] });
}

/** Shares of a range: where a limit begins to be near, and where the rows by hand say that it is there. */
const kNearBegin = 0.25;
const kNearEnd = 0.03;

/** How near the nearer limit is: 0 where it is far, 1 at it. */
export function nearness(value: number, lower: number, upper: number): number {
  const room = Math.min(value - lower, upper - value) / (upper - lower);
  return Math.min(1, Math.max(0, (kNearBegin - room) / (kNearBegin - kNearEnd)));
}

/** A hexapod's legs with its platform there, m. */
export function legLengths(model: RobotModel & { kind: 'hexapod' }, platform: Pose): number[] {
  return model.geometry.platform_anchors_m.map((anchor, i) => {
    const end = compose(platform, { p: anchor, q: [1, 0, 0, 0] }).p;
    const base = model.geometry.base_anchors_m[i]!;
    return Math.hypot(end[0] - base[0], end[1] - base[1], end[2] - base[2]);
  });
}
