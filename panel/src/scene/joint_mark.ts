/**
 * The joint that a question is about, marked in the 3D view: a ring about its axis with an arrow in
 * the way in which it counts up, the link that it turns in the same colour; of what slides an arrow, of a leg the
 * leg itself.
 */
import {
  ConeGeometry,
  CylinderGeometry,
  Group,
  Mesh,
  MeshBasicMaterial,
  Object3D,
  TorusGeometry,
  Vector3,
} from 'three';
import { compose } from '../logic/pose';
import type { Pose, Quat, RobotModel, Vec3 } from '../logic/types';
import { axisFrame, place, shapeMesh } from './body';
import { kAmber } from './look';

const kArc = 1.62 * Math.PI;
const kStill: Quat = [1, 0, 0, 0];
/** From z to x: what turns about its own x. */
const kToX: Quat = [Math.SQRT1_2, 0, Math.SQRT1_2, 0];

export class JointMark {
  /** In the robot's base frame. */
  readonly group = new Group();
  private readonly line = new MeshBasicMaterial({ color: kAmber, depthTest: false, transparent: true, opacity: 0.95 });
  private readonly skin = new MeshBasicMaterial({ color: kAmber, transparent: true, opacity: 0.42, depthWrite: false });
  private readonly mark = new Group();
  private readonly tint = new Group();

  constructor(
    private readonly model: RobotModel,
    readonly joint: number,
  ) {
    this.group.add(this.mark, this.tint);
    this.group.renderOrder = 6;
    if (model.kind === 'hexapod') this.buildLeg();
    else if (model.joints[joint]?.kind === 'prismatic') this.buildArrow();
    else this.buildRing();
  }

  private buildRing(): void {
    const { model, joint } = this;
    const radius = Math.min(0.14, Math.max(0.045, 0.13 * reachOf(model)));
    const tube = radius * 0.055;
    const counts = model.kind === 'serial' || joint === 0;
    const arc = counts ? kArc : 2 * Math.PI;
    this.mark.add(new Mesh(new TorusGeometry(radius, tube, 10, 72, arc), this.line));
    if (counts) {
      const tip = new Mesh(new ConeGeometry(tube * 3.4, tube * 8.5, 20), this.line);
      tip.position.set(radius * Math.cos(arc), radius * Math.sin(arc), 0);
      // A cone's own way is y; the arc goes on along its tangent.
      tip.rotation.z = arc;
      this.mark.add(tip);
    }
    const axle = new Mesh(new CylinderGeometry(tube * 0.5, tube * 0.5, radius * 2.2, 12), this.line);
    axle.rotation.x = Math.PI / 2;
    this.mark.add(axle);
    this.tintLink();
  }

  /** What slides: an arrow along its axis. */
  private buildArrow(): void {
    const long = Math.min(0.2, Math.max(0.08, 0.25 * reachOf(this.model)));
    const shaft = new Mesh(new CylinderGeometry(0.02 * long, 0.02 * long, long, 12), this.line);
    const tip = new Mesh(new ConeGeometry(0.08 * long, 0.22 * long, 20), this.line);
    shaft.rotation.x = tip.rotation.x = Math.PI / 2;
    tip.position.z = 0.6 * long;
    this.mark.add(shaft, tip);
    this.tintLink();
  }

  private tintLink(): void {
    for (const shape of this.model.shapes.filter((one) => one.link === this.joint + 1)) {
      const mesh = shapeMesh(shape, 0.88, this.skin, 20);
      if (mesh) this.tint.add(mesh);
    }
  }

  private buildLeg(): void {
    const body = new Mesh(new CylinderGeometry(0.0165, 0.0165, 1, 24), this.skin);
    body.name = 'leg';
    const tip = new Mesh(new ConeGeometry(0.016, 0.04, 20), this.line);
    tip.name = 'tip';
    this.mark.add(body, tip);
  }

  /** @param poses  of the links, in the base frame */
  pose(poses: Pose[]): void {
    const { model, joint } = this;
    if (model.kind === 'hexapod') {
      this.poseLeg(poses);
      return;
    }
    const link = poses[joint + 1];
    if (link) place(this.tint, link);
    if (model.kind === 'serial') {
      const at = axisFrame(model, joint, poses);
      if (at) place(this.mark, at.pose);
    } else if (link) {
      place(this.mark, joint === 0 ? { p: [0, 0, 0.06], q: kStill } : compose(link, { p: [0, 0, 0], q: kToX }));
    }
  }

  private poseLeg(poses: Pose[]): void {
    const { model, joint } = this;
    if (model.kind !== 'hexapod') return;
    const from = model.geometry.base_anchors_m[joint];
    const anchor = model.geometry.platform_anchors_m[joint];
    const plate = poses.at(-1);
    if (!from || !anchor || !plate) return;
    const to = compose(plate, { p: anchor, q: kStill }).p;
    const [a, b] = [new Vector3(...from), new Vector3(...to)];
    const way = b.clone().sub(a);
    const long = way.length();
    const up = new Vector3(0, 1, 0);
    way.normalize();
    const stretch = (object: Object3D, at: Vec3, scale: number) => {
      object.position.set(...at);
      object.quaternion.setFromUnitVectors(up, way);
      object.scale.y = scale;
    };
    const [body, tip] = this.mark.children as [Mesh, Mesh];
    stretch(body, a.clone().add(b).multiplyScalar(0.5).toArray() as Vec3, long);
    stretch(tip, b.clone().addScaledVector(way, 0.035).toArray() as Vec3, 1);
  }

  dispose(): void {
    this.group.removeFromParent();
    this.group.traverse((one) => {
      if (one instanceof Mesh) one.geometry.dispose();
    });
    this.line.dispose();
    this.skin.dispose();
  }
}

/** How far its links go together, m. */
function reachOf(model: RobotModel): number {
  if (model.kind === 'serial') {
    return model.geometry.dh.reduce((sum, row) => sum + Math.abs(row.a_m) + Math.abs(row.d_m), 0);
  }
  return model.kind === 'palletizer' ? model.geometry.upper_arm_m + model.geometry.forearm_m : 0.4;
}
