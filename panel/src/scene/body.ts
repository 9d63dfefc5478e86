/**
 * A robot's body, drawn from its model: what its file says of its shapes gives the sizes, its
 * chain, linkage or legs give the rest. Nothing is loaded, and nothing is drawn that is not there.
 */
import {
  BoxGeometry,
  BufferGeometry,
  CapsuleGeometry,
  CylinderGeometry,
  Group,
  type Material,
  Mesh,
  Object3D,
  Quaternion,
  SphereGeometry,
  Vector3,
} from 'three';
import { RoundedBoxGeometry } from 'three/examples/jsm/geometries/RoundedBoxGeometry.js';
import { jawReach, linkPoses, nearness } from '../logic/kinematics';
import { compose, fromColumns } from '../logic/pose';
import { jointLimits } from '../logic/store';
import type { Pose, PoseJson, RobotModel, ShapeJson, Vec3 } from '../logic/types';
import { drawnShapes } from './body_shapes';
import type { Materials } from './look';

const kUp = new Vector3(0, 1, 0);
const kSegments = 28;

export function place(object: Object3D, pose: Pose): void {
  object.position.set(...pose.p);
  object.quaternion.set(pose.q[1], pose.q[2], pose.q[3], pose.q[0]);
}

/** A mesh whose y axis goes from a to b. */
function between(object: Object3D, a: Vec3, b: Vec3): void {
  const from = new Vector3(...a);
  const to = new Vector3(...b);
  object.position.copy(from).add(to).multiplyScalar(0.5);
  const way = to.sub(from);
  if (way.lengthSq() > 0) object.quaternion.setFromUnitVectors(kUp, way.normalize());
}

const distance = (a: Vec3, b: Vec3): number => Math.hypot(a[0] - b[0], a[1] - b[1], a[2] - b[2]);

export interface BodyLook {
  shell: Material;
  hub: Material;
  metal: Material;
  accent: Material;
  /** Of legs whose limits are far, to those that are at one; a ghost shows none. */
  near?: Material[];
}

export const bodyLook = (all: Materials): BodyLook => ({
  shell: all.shell,
  hub: all.hub,
  metal: all.metal,
  accent: all.accent,
  near: all.near,
});
export const ghostLook = (material: Material): BodyLook => ({
  shell: material,
  hub: material,
  metal: material,
  accent: material,
});

/** A robot that can be posed. Its group stands in the robot's base frame. */
export class Body {
  readonly group = new Group();
  private readonly links: Group[];
  private readonly shapes = new Group();
  private readonly drawn: ShapeJson[];
  private readonly movers: ((links: Pose[]) => void)[] = [];
  private readonly fingers: { left: Object3D; right: Object3D; thick: number }[] = [];

  constructor(
    readonly model: RobotModel,
    private readonly look: BodyLook,
    shadows = true,
  ) {
    this.drawn = drawnShapes(model);
    this.links = model.links.map(() => new Group());
    this.group.add(...this.links, this.shapes);
    if (model.kind === 'serial') this.buildChain();
    else if (model.kind === 'palletizer') this.buildPalletizer();
    else this.buildHexapod();
    if (shadows) {
      this.group.traverse((one) => {
        if (one instanceof Mesh) one.castShadow = one.receiveShadow = true;
      });
    }
  }

  /** @param platform  a hexapod's; others compute their own */
  pose(q: readonly number[], platform?: Pose): Pose[] {
    const poses = linkPoses(this.model, q, platform);
    poses.forEach((pose, i) => place(this.links[i]!, pose));
    for (const move of this.movers) move(poses);
    return poses;
  }

  /** How far a gripper is open, m. */
  open(width: number): void {
    const gripper = this.model.kind === 'serial' ? this.model.geometry.gripper : undefined;
    if (!gripper) return;
    for (const { left, right, thick } of this.fingers) {
      left.position.y = -(width + thick) / 2;
      right.position.y = (width + thick) / 2;
      left.position.z = right.position.z = jawReach(gripper, width) - gripper.reach_open_m;
    }
  }

  /** What is held against what: the shapes of its file, as wires. */
  showShapes(material: Material | null): void {
    for (const link of this.links) {
      for (const one of [...link.children]) if (one.userData['shape']) link.remove(one);
    }
    if (!material) return;
    for (const shape of this.model.shapes) {
      const mesh = shapeMesh(shape, 1, material, 10);
      if (!mesh) continue;
      mesh.userData['shape'] = true;
      this.links[shape.link]!.add(mesh);
    }
  }

  /** A ghost has no feet: what stands there stands there already. */
  withoutStand(): this {
    this.links[0]!.visible = false;
    return this;
  }

  dispose(): void {
    this.group.traverse((one) => {
      if (one instanceof Mesh) (one.geometry as BufferGeometry).dispose();
    });
    this.group.removeFromParent();
  }

  private add(link: number, geometry: BufferGeometry, material: Material): Mesh {
    const mesh = new Mesh(geometry, material);
    this.links[link]!.add(mesh);
    return mesh;
  }

  private radiusOf(link: number): number | null {
    const radii = this.drawn
      .filter((shape) => shape.link === link && shape.form === 'capsule')
      .map((shape) => shape.radius_m!);
    return radii.length > 0 ? Math.max(...radii) : null;
  }

  /** Links are slimmer than the bodies that are checked; hubs at the joints are as wide. */
  private buildShapes(slim: number, skip: (shape: ShapeJson) => boolean = () => false): void {
    for (const shape of this.drawn) {
      if (skip(shape)) continue;
      const mesh = shapeMesh(shape, slim, shape.link === 0 ? this.look.hub : this.look.shell, kSegments);
      if (mesh) this.links[shape.link]!.add(mesh);
    }
  }

  private buildChain(): void {
    const { model } = this;
    if (model.kind !== 'serial') return;
    const grips = model.geometry.gripper !== undefined;
    const tool = model.links.length - 1;
    const hand = model.shapes.find((shape) => shape.form === 'box' && shape.link >= tool - 1);
    this.buildShapes(0.82, (shape) => shape === hand || shape.form === 'finger');
    model.geometry.dh.forEach((row, i) => {
      const radius = (this.radiusOf(i + 1) ?? this.radiusOf(i) ?? 0.03) * (i === 0 ? 1.05 : 0.92);
      const long = i === 0 ? radius * 0.5 : radius * 2.06;
      const hub = this.add(i, new CylinderGeometry(radius, radius, long, kSegments), this.look.hub);
      hub.rotation.x = Math.PI / 2;
      hub.position.z = i === 0 ? this.topOfStand() + long / 2 : 0;
      // A ring in the accent's colour at each end of a hub: where something turns.
      const ring = new CylinderGeometry(radius * 0.55, radius * 0.55, long * 1.02, kSegments);
      if (i > 0 && row) {
        const cap = this.add(i, ring, this.look.accent);
        cap.rotation.x = Math.PI / 2;
      }
    });
    if (grips) this.buildGripper(model.geometry.gripper!);
    else if (hand) this.buildHand(hand);
  }

  private topOfStand(): number {
    const box = this.model.shapes.find((shape) => shape.link === 0 && shape.form === 'box');
    return box ? box.pose!.xyz_m[2] + box.half_m![2] : 0;
  }

  private buildGripper(gripper: { width_max_m: number; reach_open_m: number }): void {
    const tool = this.model.links.length - 1;
    const reach = gripper.reach_open_m;
    const wide = gripper.width_max_m * 0.95;
    const thick = 0.008;
    const palm = this.add(tool, new RoundedBoxGeometry(0.026, wide, 0.03, 3, 0.005), this.look.hub);
    palm.position.z = -0.004;
    const finger = () => {
      const group = new Group();
      const bar = new Mesh(new RoundedBoxGeometry(0.016, thick, reach, 2, 0.003), this.look.metal);
      bar.position.z = reach / 2;
      const tip = new Mesh(new RoundedBoxGeometry(0.018, thick * 1.5, reach * 0.3, 2, 0.003), this.look.hub);
      tip.position.z = reach * 0.85;
      group.add(bar, tip);
      this.links[tool]!.add(group);
      return group;
    };
    this.fingers.push({ left: finger(), right: finger(), thick: thick * 1.5 });
    this.open(gripper.width_max_m);
  }

  /** A gripper of which only its box is known: a palm, and two fingers in its wider direction. */
  private buildHand(box: ShapeJson): void {
    const [x, y, z] = box.half_m!;
    const hand = new Group();
    place(hand, fromPoseJson(box.pose!));
    const palm = new Mesh(new RoundedBoxGeometry(1.6 * x, 1.5 * y, 0.7 * z, 3, 0.006), this.look.hub);
    palm.position.z = -0.62 * z;
    hand.add(palm);
    for (const side of [-1, 1]) {
      const finger = new Mesh(new RoundedBoxGeometry(0.8 * x, 0.2 * y, 1.35 * z, 2, 0.003), this.look.metal);
      finger.position.set(0, side * 0.55 * y, 0.3 * z);
      hand.add(finger);
    }
    this.links[box.link]!.add(hand);
  }

  private buildPalletizer(): void {
    const { model } = this;
    if (model.kind !== 'palletizer') return;
    this.buildShapes(0.85, (shape) => shape.link === model.links.length - 1);
    const g = model.geometry;
    const hub = (link: number, radius: number, long: number, material: Material) => {
      const mesh = this.add(link, new CylinderGeometry(radius, radius, long, kSegments), material);
      mesh.rotation.z = Math.PI / 2;
      return mesh;
    };
    hub(2, 0.019, 0.05, this.look.hub);
    hub(2, 0.01, 0.054, this.look.accent);
    hub(3, 0.016, 0.044, this.look.hub);
    hub(3, 0.008, 0.048, this.look.accent);
    const wrist = hub(3, 0.012, 0.036, this.look.hub);
    wrist.position.y = -g.forearm_m;
    const tool = model.links.length - 1;
    const holder = this.add(tool, new RoundedBoxGeometry(0.022, g.tool_offset_m + 0.02, 0.016, 2, 0.004), this.look.hub);
    holder.position.set(0, g.tool_offset_m / 2, 0.004);
    const nozzle = this.add(tool, new CylinderGeometry(0.005, 0.005, 0.026, 16), this.look.metal);
    nozzle.rotation.x = Math.PI / 2;
    nozzle.position.z = -0.012;
    const cup = this.add(tool, new CylinderGeometry(0.006, 0.011, 0.01, 20), this.look.hub);
    cup.rotation.x = Math.PI / 2;
    cup.position.z = -0.027;
    // The rods that keep the holder level: each end stands off its joint by the same vector.
    const plate = this.rod(0.003);
    const back = this.rod(0.004);
    const top = this.rod(0.004);
    this.movers.push((poses) => {
      const level = poses[tool]!.q;
      const shoulder = poses[2]!;
      const elbow = poses[3]!;
      const end = compose(elbow, { p: [0, -g.forearm_m, 0], q: [1, 0, 0, 0] });
      const off = (at: Pose, v: Vec3) => compose({ p: at.p, q: level }, { p: v, q: [1, 0, 0, 0] }).p;
      const rear: Vec3 = [0.021, 0.026, 0.006];
      const above: Vec3 = [0.021, -0.012, 0.026];
      stretch(back, off(shoulder, rear), off(elbow, rear));
      stretch(top, off(elbow, above), off(end, above));
      stretch(plate, off(elbow, rear), off(elbow, above));
    });
  }

  private rod(radius: number): Mesh {
    const mesh = new Mesh(new CylinderGeometry(radius, radius, 1, 12), this.look.metal);
    this.group.add(mesh);
    return mesh;
  }

  private buildHexapod(): void {
    const { model } = this;
    if (model.kind !== 'hexapod') return;
    const g = model.geometry;
    const platform = model.links.length - 1;
    const rim = (anchors: Vec3[]) => Math.max(...anchors.map((a) => Math.hypot(a[0], a[1])));
    const disc = (link: number, radius: number, long: number, z: number, material: Material) => {
      const mesh = this.add(link, new CylinderGeometry(radius, radius, long, 48), material);
      mesh.rotation.x = Math.PI / 2;
      mesh.position.z = z;
    };
    const stand = model.shapes.find((shape) => shape.link === 0 && shape.form === 'box');
    const bottom = stand ? stand.pose!.xyz_m[2] : -0.02;
    disc(0, rim(g.base_anchors_m) * 1.08, 0.016, bottom, this.look.hub);
    const top = model.shapes.find((shape) => shape.link === platform && shape.form === 'box');
    const height = top ? top.pose!.xyz_m[2] : 0.01;
    disc(platform, rim(g.platform_anchors_m) * 1.06, 0.008, height, this.look.shell);
    disc(platform, rim(g.platform_anchors_m) * 0.3, 0.004, height + 0.006, this.look.accent);
    const ball = (link: number, at: Vec3, material: Material) => {
      const mesh = this.add(link, new SphereGeometry(0.009, 18, 12), material);
      mesh.position.set(...at);
    };
    g.base_anchors_m.forEach((anchor, i) => {
      ball(0, anchor, this.look.metal);
      const post = new Mesh(new CylinderGeometry(0.012, 0.014, anchor[2] - bottom, 20), this.look.hub);
      between(post, [anchor[0], anchor[1], bottom], anchor);
      this.links[0]!.add(post);
      ball(platform, g.platform_anchors_m[i]!, this.look.metal);
      this.buildLeg(i, anchor, g.platform_anchors_m[i]!, platform);
    });
  }

  /** A motor's tube of fixed length, and the spindle that comes out of it; amber as its limits come near. */
  private buildLeg(leg: number, base: Vec3, anchor: Vec3, platform: number): void {
    const { model } = this;
    const { lower, upper } = jointLimits(model.joints[leg]!);
    const shortest = lower;
    const tube = new Mesh(new CylinderGeometry(0.011, 0.011, shortest * 0.62, 20), this.look.shell);
    const collar = new Mesh(new CylinderGeometry(0.0125, 0.0125, 0.012, 20), this.look.accent);
    const spindle = this.rod(0.004);
    this.group.add(tube, collar);
    this.movers.push((poses) => {
      const end = compose(poses[platform]!, { p: anchor, q: [1, 0, 0, 0] }).p;
      const length = distance(base, end);
      const at = (share: number): Vec3 => [
        base[0] + (end[0] - base[0]) * share,
        base[1] + (end[1] - base[1]) * share,
        base[2] + (end[2] - base[2]) * share,
      ];
      const reach = (shortest * 0.62) / length;
      between(tube, at(0.06), at(0.06 + reach));
      between(collar, at(0.06 + reach), at(0.06 + reach + 0.001));
      stretch(spindle, at(reach), end);
      const { near, accent } = this.look;
      if (!near) return;
      const step = Math.round(nearness(length, lower, upper) * (near.length - 1));
      spindle.material = near[step]!;
      collar.material = step > 0 ? near[step]! : accent;
    });
  }
}

/** A rod of length 1 along its y, from a to b. */
function stretch(rod: Object3D, a: Vec3, b: Vec3): void {
  between(rod, a, b);
  rod.scale.y = distance(a, b);
}

export function shapeMesh(shape: ShapeJson, slim: number, material: Material, segments: number): Mesh | null {
  if (shape.form === 'capsule') {
    const radius = shape.radius_m! * slim;
    const length = distance(shape.from_m!, shape.to_m!);
    const mesh = new Mesh(new CapsuleGeometry(radius, length, 8, segments), material);
    between(mesh, shape.from_m!, shape.to_m!);
    return mesh;
  }
  if (shape.form === 'box' || shape.form === 'finger') {
    const [x, y, z] = shape.half_m!;
    const least = Math.min(x, y, z);
    const geometry =
      segments > 12 ? new RoundedBoxGeometry(2 * x, 2 * y, 2 * z, 3, least * 0.3) : new BoxGeometry(2 * x, 2 * y, 2 * z);
    const mesh = new Mesh(geometry, material);
    place(mesh, fromPoseJson(shape.pose!));
    return mesh;
  }
  return null;
}

const fromPoseJson = (json: PoseJson): Pose => ({ p: json.xyz_m, q: json.quaternion_wxyz });

/** Frames of a palletizer's joints against its level one: x where the joint's angle is 0, z its axis. */
const kPalletizerTurns = [fromColumns([0, 1, 0], [0, 0, 1], [1, 0, 0]), fromColumns([0, -1, 0], [0, 0, -1], [1, 0, 0])];

/** Turns of the joint whose limits are shown: a sector in the plane that its axis stands on. */
export function axisFrame(model: RobotModel, joint: number, poses: Pose[]): { pose: Pose; offset: number } | null {
  if (model.kind === 'palletizer') {
    // Its base counts clockwise from above.
    if (joint === 0) return { pose: { p: [0, 0, 0.02], q: [0, 1, 0, 0] }, offset: Math.PI / 2 - model.geometry.base_front_rad };
    const turn = kPalletizerTurns[joint - 1];
    const link = poses[joint + 1];
    if (!turn || !link) return null;
    return { pose: compose({ p: link.p, q: poses[1]!.q }, { p: [0, 0, 0], q: turn }), offset: 0 };
  }
  if (model.kind !== 'serial') return null;
  const row = model.geometry.dh[joint];
  if (!row) return null;
  const pose = compose(poses[joint]!, { p: [0, 0, joint === 0 ? 0.02 : 0], q: [1, 0, 0, 0] });
  return { pose, offset: row.theta_offset_rad };
}

export { Quaternion };
