/**
 * The cell in 3D: every robot where it stands, what it does, what it is asked to do. Draws only
 * when something has changed. World W of the cell: metres, z up.
 */
import {
  AmbientLight,
  Box3,
  BufferAttribute,
  BufferGeometry,
  Color,
  CylinderGeometry,
  DirectionalLight,
  Fog,
  GridHelper,
  Group,
  HemisphereLight,
  Line,
  LineBasicMaterial,
  LineSegments,
  Mesh,
  MeshBasicMaterial,
  MOUSE,
  Object3D,
  PCFShadowMap,
  PerspectiveCamera,
  PlaneGeometry,
  Raycaster,
  RingGeometry,
  Scene,
  ShadowMaterial,
  SphereGeometry,
  TOUCH,
  Vector2,
  Vector3,
  WebGLRenderer,
} from 'three';
import { OrbitControls } from 'three/examples/jsm/controls/OrbitControls.js';
import { TransformControls } from 'three/examples/jsm/controls/TransformControls.js';
import { RoundedBoxGeometry } from 'three/examples/jsm/geometries/RoundedBoxGeometry.js';
import { linkPoses } from '../logic/kinematics';
import { compose, fromFlat } from '../logic/pose';
import { jointLimits, jointsOf } from '../logic/store';
import { regionOf } from './table_reach';
import { basketOf, cubeOf, frustumOf } from './table_top';
import type { Lens } from '../logic/lens';
import type { BasketJson, CellDescription, CubeReachJson, Pose, RobotModel, RobotStatus, SeenCubeJson, ToolRow, Vec3 } from '../logic/types';
import { Body, bodyLook, ghostLook, place } from './body';
import { JointMark } from './joint_mark';
import { limitMark } from './limits';
import { kPalettes, Materials, type Theme } from './look';
import { oblique, ObliqueCamera } from './oblique';
import { reachShell } from './reach';
import { Trail } from './trail';

export type Preset = 'iso' | 'front' | 'side' | 'top' | 'oblique';

export interface Layers {
  trail: boolean;
  reach: boolean;
  bodies: boolean;
  objects: boolean;
}

interface Stand {
  name: string;
  model: RobotModel;
  /** In the base frame. */
  group: Group;
  body: Body;
  base: Pose;
  trail: Trail;
  tool: Object3D;
  ring: Mesh;
  reach: Object3D | null;
  q: number[] | null;
  key: string;
}

/** What nobody sees: m, and parts of a quaternion. */
const kStill = 1e-6;

export interface Ghost {
  robot: string;
  joints: number[];
  platform?: Pose;
  refused: boolean;
  path?: ToolRow[];
}

export interface GizmoWish {
  robot: string;
  /** Tool in base. */
  pose: Pose;
  mode: 'translate' | 'rotate';
  space: 'world' | 'local';
  /** Turns about the vertical only. */
  upright?: boolean;
}

export interface SceneOptions {
  host: HTMLElement;
  labels: HTMLElement;
  /** Draw as cheaply as can be; found out where nobody says. */
  plain?: boolean;
  onPick: (robot: string) => void;
  onGizmo: (robot: string, pose: Pose, done: boolean) => void;
}

export class CellScene {
  private readonly scene = new Scene();
  private readonly perspective = new PerspectiveCamera(38, 1, 0.01, 60);
  private readonly drawing = new ObliqueCamera();
  private camera: PerspectiveCamera | ObliqueCamera = this.perspective;
  private readonly renderer: WebGLRenderer;
  private readonly orbit: OrbitControls;
  private readonly gizmo: TransformControls;
  private readonly gizmoTarget = new Object3D();
  private gizmoRobot: string | null = null;
  private readonly materials: Materials;
  /** This browser draws in software. */
  private readonly helpless = drawsWithoutHelp();
  private readonly plain: boolean;
  /** No frame before this, so that drawing never has more than a third of the page's time. */
  private notBefore = 0;
  /** A frame that a computer without help has not finished yet: script only asks for it. */
  private asked: { begin: number; done: WebGLSync } | null = null;
  private readonly trailMaterial = new LineBasicMaterial({ transparent: true, opacity: 0.45 });
  private readonly floor = new Group();
  private readonly objects = new Group();
  private readonly frustums = new Group();
  private readonly cubes = new Group();
  private readonly baskets = new Group();
  private readonly region = new Group();
  private readonly sun = new DirectionalLight(0xffffff, 2);
  private readonly hemi = new HemisphereLight(0xffffff, 0x888888, 1.1);
  private readonly stands = new Map<string, Stand>();
  private readonly limits = new Group();
  private readonly labels = new Map<string, HTMLElement>();
  private ghost: { body: Body; robot: string; path: Line } | null = null;
  private mark: { robot: string; of: JointMark } | null = null;
  private selected: string | null = null;
  private layers: Layers = { trail: true, reach: false, bodies: false, objects: true };
  private dirty = true;
  private frame = 0;
  private readonly resize: ResizeObserver;
  /** Script time of the last frames, ms: what a test looks at. */
  readonly frames: number[] = [];

  constructor(private readonly options: SceneOptions) {
    this.perspective.up.set(0, 0, 1);
    this.plain = options.plain ?? this.helpless;
    this.materials = new Materials(this.plain);
    this.renderer = new WebGLRenderer({ antialias: !this.plain, powerPreference: 'high-performance' });
    this.renderer.setPixelRatio(this.plain ? 1 : Math.min(devicePixelRatio, 2));
    this.renderer.shadowMap.enabled = !this.plain;
    this.renderer.shadowMap.type = PCFShadowMap;
    this.renderer.shadowMap.autoUpdate = false;
    this.renderer.domElement.setAttribute('aria-hidden', 'true');
    options.host.append(this.renderer.domElement);
    this.orbit = new OrbitControls(this.camera, this.renderer.domElement);
    this.orbit.enableDamping = false;
    this.orbit.minDistance = 0.15;
    this.orbit.maxDistance = 25;
    this.orbit.maxPolarAngle = Math.PI * 0.52;
    this.orbit.addEventListener('change', () => this.invalidate());
    this.gizmo = new TransformControls(this.camera, this.renderer.domElement);
    this.gizmo.size = 0.8;
    this.gizmo.setColors(0xd98a5b, 0x7fb565, 0x5f97d8, 0x35c2b2);
    this.gizmo.addEventListener('dragging-changed', (event) => {
      this.orbit.enabled = !event.value;
      this.holdSize(event.value === true);
      if (!event.value) this.tellGizmo(true);
    });
    this.gizmo.addEventListener('objectChange', () => this.tellGizmo(false));
    this.gizmo.addEventListener('change', () => this.invalidate());
    this.scene.add(this.hemi, new AmbientLight(0xffffff, 0.25), this.sun, this.sun.target);
    this.scene.add(this.floor, this.objects, this.frustums, this.cubes, this.baskets, this.region, this.limits, this.gizmo.getHelper());
    this.sun.castShadow = !this.plain;
    this.sun.shadow.mapSize.set(2048, 2048);
    this.sun.shadow.bias = -0.0005;
    this.sun.shadow.normalBias = 0.004;
    this.paint('dark');
    this.pickOnClick();
    this.resize = new ResizeObserver(() => this.fitToHost());
    this.resize.observe(options.host);
    this.fitToHost();
    const loop = () => {
      this.frame = requestAnimationFrame(loop);
      if (this.asked) this.lookForEnd();
      if (this.dirty && !this.asked && performance.now() >= this.notBefore) this.draw();
    };
    this.frame = requestAnimationFrame(loop);
  }

  dispose(): void {
    cancelAnimationFrame(this.frame);
    this.resize.disconnect();
    this.orbit.dispose();
    this.gizmo.dispose();
    this.renderer.dispose();
    this.renderer.domElement.remove();
    for (const label of this.labels.values()) label.remove();
  }

  invalidate(): void {
    this.dirty = true;
  }

  get triangles(): number {
    return this.renderer.info.render.triangles;
  }

  paint(theme: Theme): void {
    const palette = kPalettes[theme];
    this.materials.paint(theme);
    this.trailMaterial.color = new Color(palette.accent);
    this.scene.background = new Color(palette.background);
    this.scene.fog = new Fog(palette.background, 9, 22);
    this.hemi.color = new Color(palette.sky);
    this.hemi.groundColor = new Color(palette.ground);
    this.sun.intensity = palette.light;
    this.makeFloor(theme);
    this.invalidate();
  }

  private floorHeight(): number {
    let least = 0;
    for (const stand of this.stands.values()) {
      least = Math.min(least, stand.base.p[2] + footOf(stand.model));
    }
    return least;
  }

  private makeFloor(theme: Theme): void {
    const palette = kPalettes[theme];
    this.floor.clear();
    const height = this.floorHeight();
    const grid = (size: number, parts: number, color: number, z: number) => {
      const lines = new GridHelper(size, parts, color, color);
      lines.rotation.x = Math.PI / 2;
      lines.position.z = height + z;
      this.floor.add(lines);
    };
    const ground = new Mesh(new PlaneGeometry(60, 60), new MeshBasicMaterial({ color: palette.floor }));
    ground.position.z = height - 0.003;
    const shade = new Mesh(
      new PlaneGeometry(14, 14),
      new ShadowMaterial({ opacity: theme === 'dark' ? 0.42 : 0.2 }),
    );
    shade.position.z = height - 0.0005;
    shade.receiveShadow = true;
    this.floor.add(ground);
    if (!this.plain) this.floor.add(shade);
    grid(12, 60, palette.gridMinor, -0.002);
    grid(12, 12, palette.gridMajor, -0.001);
    for (const stand of this.stands.values()) {
      const foot = stand.base.p[2] + footOf(stand.model);
      const radius = footRadius(stand.model);
      const tall = foot - height;
      if (tall < 0.01) continue;
      const plinth = new Mesh(new CylinderGeometry(radius, radius * 1.04, tall, 56), this.materials.plinth);
      plinth.rotation.x = Math.PI / 2;
      plinth.position.set(stand.base.p[0], stand.base.p[1], height + tall / 2);
      plinth.receiveShadow = plinth.castShadow = true;
      this.floor.add(plinth);
    }
  }

  setCell(cell: CellDescription, models: Record<string, RobotModel>, theme: Theme): void {
    for (const stand of this.stands.values()) stand.group.removeFromParent();
    for (const stand of this.stands.values()) this.scene.remove(stand.trail.line);
    for (const label of this.labels.values()) label.remove();
    this.labels.clear();
    this.stands.clear();
    this.markJoint(null, 0);
    this.hideGhost();
    for (const robot of cell.robots) {
      const model = models[robot.name];
      if (model) this.addRobot(robot.name, model, fromFlat(robot.pose));
    }
    this.objects.clear();
    for (const object of cell.objects) {
      const size: Vec3 = [object.length_m, object.width_m, object.height_m];
      const mesh = new Mesh(
        new RoundedBoxGeometry(...size, 2, Math.min(...size) * 0.08),
        this.materials.object,
      );
      place(mesh, fromFlat(object));
      mesh.castShadow = mesh.receiveShadow = true;
      this.objects.add(mesh);
    }
    this.showCubes([]);
    this.showBaskets(cell.baskets ?? []);
    this.makeFloor(theme);
    this.aimSun();
    this.showAll('iso');
  }

  /** Those that a camera sees, where it sees them. */
  showCubes(cubes: readonly SeenCubeJson[]): void {
    this.fill(this.cubes, cubes.map(cubeOf));
  }
  /** What cameras see of their tables. */
  showFrustums(lenses: readonly Lens[]): void {
    this.fill(this.frustums, lenses.map((lens) => frustumOf(lens, this.materials.path)));
  }
  showBaskets(baskets: readonly BasketJson[]): void {
    this.fill(this.baskets, baskets.map((one) => basketOf(one, this.materials.object)));
  }
  /** Where cubes can be taken; nothing where it is null. */
  showRegion(grid: CubeReachJson | null): void {
    this.fill(this.region, grid ? [regionOf(grid, this.materials.accent.color)] : []);
  }
  private fill(group: Group, things: readonly (Object3D | null)[]): void {
    group.clear();
    for (const one of things) if (one) group.add(one);
    this.renderer.shadowMap.needsUpdate = true;
    this.invalidate();
  }

  private addRobot(name: string, model: RobotModel, base: Pose): void {
    const group = new Group();
    place(group, base);
    const body = new Body(model, bodyLook(this.materials));
    const tool = new Object3D();
    const dot = new Mesh(new SphereGeometry(0.006, 16, 12), this.materials.accent);
    tool.add(dot);
    const radius = footRadius(model);
    const ring = new Mesh(new RingGeometry(radius * 1.1, radius * 1.1 + 0.012, 72), this.materials.limit);
    ring.position.z = footOf(model) + 0.002;
    ring.visible = false;
    group.add(body.group, tool, ring);
    group.traverse((one) => (one.userData['robot'] = name));
    const trail = new Trail(this.trailMaterial);
    this.scene.add(group, trail.line);
    const label = document.createElement('div');
    label.className = 'scene-label';
    label.textContent = name;
    this.options.labels.append(label);
    this.labels.set(name, label);
    this.stands.set(name, { name, model, group, body, base, trail, tool, ring, reach: null, q: null, key: '' });
    body.pose(model.joints.map((joint) => jointLimits(joint).home));
  }

  setStatus(name: string, status: RobotStatus): void {
    const stand = this.stands.get(name);
    if (!stand) return;
    const label = this.labels.get(name);
    if (label) label.dataset['state'] = status.state;
    const q = jointsOf(status);
    if (!q) return;
    const platform = status.tool ? fromFlat(status.tool) : undefined;
    const jaws = status.jaws_m;
    const key = [...q, ...(platform ? [...platform.p, ...platform.q] : []), jaws ?? 0]
      .map((one) => one.toFixed(5))
      .join();
    if (key === stand.key) return;
    stand.key = key;
    stand.q = q;
    const poses = stand.body.pose(q, platform);
    if (this.mark?.robot === name) this.mark.of.pose(poses);
    if (jaws !== undefined) stand.body.open(jaws);
    if (platform) {
      place(stand.tool, platform);
      stand.trail.add(new Vector3(...compose(stand.base, platform).p));
    }
    stand.trail.line.visible = this.layers.trail;
    this.renderer.shadowMap.needsUpdate = true;
    this.invalidate();
  }

  clearTrails(): void {
    for (const stand of this.stands.values()) stand.trail.clear();
    this.invalidate();
  }

  select(name: string | null): void {
    this.selected = name;
    for (const stand of this.stands.values()) {
      stand.ring.visible = stand.name === name;
      this.labels.get(stand.name)?.toggleAttribute('data-selected', stand.name === name);
    }
    this.setLayers(this.layers);
    this.showLimits(null);
  }

  setLayers(layers: Layers): void {
    this.layers = layers;
    this.objects.visible = this.frustums.visible = this.baskets.visible = layers.objects;
    for (const stand of this.stands.values()) {
      stand.trail.line.visible = layers.trail;
      stand.body.showShapes(layers.bodies ? this.materials.body : null);
      const reach = layers.reach && (this.selected === null || this.selected === stand.name);
      if (reach && !stand.reach) stand.reach = this.makeReach(stand);
      if (stand.reach) stand.reach.visible = reach;
    }
    this.invalidate();
  }

  private makeReach(stand: Stand): Object3D {
    const shell = reachShell(stand.model);
    const geometry = new BufferGeometry();
    geometry.setAttribute('position', new BufferAttribute(new Float32Array(shell.points.flat()), 3));
    geometry.setIndex(shell.faces.flat());
    const group = new Group();
    const skin = this.materials.reach;
    skin.side = 2;
    group.add(new Mesh(geometry, skin));
    const lines: number[] = [];
    // Every sixth line of the shell's own net.
    const rows = shell.points.length / shell.row;
    for (let k = 0; k < rows; ++k) {
      for (let i = 0; i < shell.row; ++i) {
        const here = shell.points[k * shell.row + i]!;
        const beside = i + 1 < shell.row ? shell.points[k * shell.row + i + 1] : undefined;
        const behind = shell.points[(k + 1) * shell.row + i];
        // Its rim and its hole may meet in the axis only.
        const meet = beside && Math.hypot(here[0], here[1], beside[0], beside[1]) < 1e-9;
        if (k % 6 === 0 && beside && !meet) lines.push(...here, ...beside);
        if (i % 6 === 0 && behind) lines.push(...here, ...behind);
      }
    }
    const net = new BufferGeometry();
    net.setAttribute('position', new BufferAttribute(new Float32Array(lines), 3));
    group.add(new LineSegments(net, this.materials.reachLines));
    stand.group.add(group);
    return group;
  }

  /** A joint's range; nothing takes it away. */
  showLimits(joint: number | null, value?: number): void {
    if (joint === null && this.limits.children.length === 0) return;
    this.limits.traverse((one) => {
      if (one instanceof Mesh || one instanceof Line) (one.geometry as BufferGeometry).dispose();
    });
    this.limits.clear();
    this.invalidate();
    const stand = this.selected ? this.stands.get(this.selected) : undefined;
    if (joint === null || !stand?.model.joints[joint]) return;
    const q = stand.q ?? stand.model.joints.map((one) => jointLimits(one).home);
    const poses = stand.body.pose(q, stand.q ? platformOf(stand) : undefined);
    const mark = limitMark(stand.model, joint, poses, value ?? q[joint] ?? 0, this.materials);
    if (!mark) return;
    const base = new Group();
    place(base, stand.base);
    base.add(mark);
    this.limits.add(base);
  }

  /** The joint that somebody is asked about, or that moves by itself now. */
  markJoint(robot: string | null, joint: number): void {
    const stand = robot === null ? undefined : this.stands.get(robot);
    if (this.mark && this.mark.robot === robot && this.mark.of.joint === joint) return;
    this.mark?.of.dispose();
    this.mark = null;
    this.invalidate();
    if (!stand || !stand.model.joints[joint]) return;
    const of = new JointMark(stand.model, joint);
    const q = stand.q ?? stand.model.joints.map((one) => jointLimits(one).home);
    of.pose(stand.body.pose(q, stand.q ? platformOf(stand) : undefined));
    stand.group.add(of.group);
    this.mark = { robot: stand.name, of };
  }

  showGhost(ghost: Ghost): void {
    const stand = this.stands.get(ghost.robot);
    if (!stand) return;
    if (this.ghost?.robot !== ghost.robot) this.hideGhost();
    if (!this.ghost) {
      const body = new Body(stand.model, ghostLook(this.materials.ghost), false).withoutStand();
      const path = new Line(new BufferGeometry(), this.materials.path);
      path.frustumCulled = false;
      stand.group.add(body.group, path);
      this.ghost = { body, robot: ghost.robot, path };
    }
    const material = ghost.refused ? this.materials.ghostRefused : this.materials.ghost;
    this.ghost.body.group.traverse((one) => {
      if (one instanceof Mesh) one.material = material;
    });
    this.ghost.body.pose(ghost.joints, ghost.platform);
    const points = (ghost.path ?? []).map((row) => new Vector3(row[0], row[1], row[2]));
    this.ghost.path.geometry.dispose();
    this.ghost.path.geometry = new BufferGeometry().setFromPoints(points);
    this.ghost.path.visible = points.length > 1;
    this.invalidate();
  }

  hideGhost(): void {
    if (!this.ghost) return;
    this.ghost.body.dispose();
    this.ghost.path.geometry.dispose();
    this.ghost.path.removeFromParent();
    this.ghost = null;
    this.invalidate();
  }

  showGizmo(wish: GizmoWish | null): void {
    const stand = wish ? this.stands.get(wish.robot) : undefined;
    if (!wish && this.gizmoRobot === null) return;
    if (!wish || !stand) {
      this.gizmo.detach();
      this.gizmoTarget.removeFromParent();
      this.gizmoRobot = null;
      this.invalidate();
      return;
    }
    if (this.gizmoRobot !== wish.robot) stand.group.add(this.gizmoTarget);
    this.gizmoRobot = wish.robot;
    const { position, quaternion } = this.gizmoTarget;
    const before = [...position, ...quaternion];
    if (!this.gizmo.dragging) place(this.gizmoTarget, wish.pose);
    const moved = [...position, ...quaternion].some((one, i) => Math.abs(one - before[i]!) > kStill);
    const same = this.gizmo.object === this.gizmoTarget && this.gizmo.mode === wish.mode && this.gizmo.space === wish.space;
    if (same && !moved) return;
    this.gizmo.setMode(wish.mode);
    this.gizmo.setSpace(wish.space);
    const all = wish.mode === 'translate' || !wish.upright;
    this.gizmo.showX = this.gizmo.showY = all;
    if (this.gizmo.object !== this.gizmoTarget) this.gizmo.attach(this.gizmoTarget);
    this.invalidate();
  }

  private tellGizmo(done: boolean): void {
    if (!this.gizmoRobot) return;
    const { position: p, quaternion: q } = this.gizmoTarget;
    this.options.onGizmo(this.gizmoRobot, { p: [p.x, p.y, p.z], q: [q.w, q.x, q.y, q.z] }, done);
  }

  /** Looks at the whole cell from a known side. */
  showAll(preset: Preset): void {
    this.lookAt(preset, undefined);
  }
  /** .. or at the selected robot. */
  show(preset: Preset): void {
    this.lookAt(preset, this.selected ? this.stands.get(this.selected) : undefined);
  }

  /** Goes nearer to the selected robot, from where one looks now. */
  focus(): void {
    const stand = this.selected ? this.stands.get(this.selected) : undefined;
    const way = this.camera.position.clone().sub(this.orbit.target);
    if (stand && this.camera === this.drawing) this.lookOblique([stand], 1.5);
    else if (stand) this.lookFrom(way, [stand], 1.5);
  }

  private lookAt(preset: Preset, stand: Stand | undefined): void {
    const all = stand ? [stand] : [...this.stands.values()];
    const wider = stand ? 1.5 : 1.08;
    if (preset === 'oblique') return this.lookOblique(all, wider);
    const ways: Record<Exclude<Preset, 'oblique'>, [number, number, number]> = {
      iso: [0.62, -0.95, 0.62],
      front: [0, -1, 0.16],
      side: [1, 0, 0.16],
      top: [0, -0.001, 1],
    };
    // From above a long lens draws nearly parallel, as a plan does.
    this.perspective.fov = preset === 'top' ? 12 : 38;
    this.lookFrom(new Vector3(...ways[preset]), all, wider);
  }

  /** A drawing has one side that it is seen from: what turns other views moves this one. */
  private lookThrough(camera: PerspectiveCamera | ObliqueCamera): void {
    const turns = camera === this.perspective;
    this.camera = camera;
    this.orbit.object = camera;
    this.orbit.enableRotate = turns;
    this.orbit.mouseButtons.LEFT = turns ? MOUSE.ROTATE : MOUSE.PAN;
    this.orbit.touches.ONE = turns ? TOUCH.ROTATE : TOUCH.PAN;
    this.gizmo.camera = camera;
  }

  private lookOblique(all: Stand[], wider: number): void {
    if (all.length === 0) return;
    const { centre, corners } = roomOf(all);
    this.lookThrough(this.drawing);
    const { clientWidth: width, clientHeight: height } = this.options.host;
    const aspect = width > 0 && height > 0 ? width / height : 1;
    let tall = 0.1;
    for (const corner of corners) {
      const [x, y] = oblique([corner.x, corner.y, corner.z]);
      tall = Math.max(tall, Math.abs(y), Math.abs(x) / aspect);
    }
    const away = 12;
    this.drawing.lookAtCentre(centre, away, tall * wider);
    this.drawing.fit(aspect);
    this.aimAt(centre, away);
  }

  private aimAt(centre: Vector3, away: number): void {
    const fog = this.scene.fog as Fog;
    fog.near = away + 4;
    fog.far = away + 14;
    this.orbit.target.copy(centre);
    this.orbit.update();
    this.invalidate();
  }

  /** As near as all of them fit. @param wider  room around them */
  private lookFrom(way: Vector3, all: Stand[], wider: number): void {
    if (all.length === 0) return;
    const { centre, corners } = roomOf(all);
    this.lookThrough(this.perspective);
    const back = way.clone().normalize();
    const right = new Vector3(0, 0, 1).cross(back).normalize();
    const up = back.clone().cross(right);
    const camera = this.perspective;
    const tall = Math.tan((camera.fov * Math.PI) / 360);
    const wide = tall * camera.aspect;
    let away = 0.3;
    for (const corner of corners) {
      const across = Math.max(Math.abs(corner.dot(right)) / wide, Math.abs(corner.dot(up)) / tall);
      away = Math.max(away, corner.dot(back) + across * wider);
    }
    camera.position.copy(centre).addScaledVector(back, away);
    camera.near = Math.max(0.01, away / 200);
    camera.far = away + 40;
    camera.updateProjectionMatrix();
    this.aimAt(centre, away);
  }

  private aimSun(): void {
    const box = new Box3();
    for (const stand of this.stands.values()) {
      stand.group.updateMatrixWorld(true);
      box.expandByObject(stand.body.group);
    }
    const centre = box.getCenter(new Vector3());
    const radius = Math.max(1, box.getSize(new Vector3()).length() * 0.6);
    this.sun.target.position.copy(centre);
    this.sun.position.copy(centre).add(new Vector3(-0.5, -0.75, 1.5).multiplyScalar(radius));
    const camera = this.sun.shadow.camera;
    camera.left = camera.bottom = -radius;
    camera.right = camera.top = radius;
    camera.near = 0.1;
    camera.far = radius * 4;
    camera.updateProjectionMatrix();
    this.renderer.shadowMap.needsUpdate = true;
  }

  private pickOnClick(): void {
    const down = new Vector2();
    const canvas = this.renderer.domElement;
    canvas.addEventListener('pointerdown', (event) => down.set(event.clientX, event.clientY));
    canvas.addEventListener('click', (event) => {
      if (down.distanceTo(new Vector2(event.clientX, event.clientY)) > 4 || this.gizmo.dragging) return;
      const bounds = canvas.getBoundingClientRect();
      const at = new Vector2(
        ((event.clientX - bounds.left) / bounds.width) * 2 - 1,
        1 - ((event.clientY - bounds.top) / bounds.height) * 2,
      );
      const ray = new Raycaster();
      ray.setFromCamera(at, this.camera);
      const bodies = [...this.stands.values()].map((stand) => stand.body.group);
      const robot = ray.intersectObjects(bodies, true)[0]?.object.userData['robot'] as string | undefined;
      if (robot) this.options.onPick(robot);
    });
  }

  /** A view that grew or shrank under a drag would put another place beneath the same pointer. */
  private holdSize(held: boolean): void {
    const { domElement: canvas } = this.renderer;
    const { clientWidth: width, clientHeight: height } = this.options.host;
    Object.assign(canvas.style, held ? { width: `${width}px`, height: `${height}px` } : { width: '', height: '' });
    if (!held) this.fitToHost();
  }

  private fitToHost(): void {
    const { clientWidth: width, clientHeight: height } = this.options.host;
    if (width === 0 || height === 0 || this.gizmo.dragging) return;
    this.renderer.setSize(width, height, false);
    this.perspective.aspect = width / height;
    this.perspective.updateProjectionMatrix();
    this.drawing.fit(width / height);
    this.invalidate();
  }

  private draw(): void {
    const begin = performance.now();
    this.dirty = false;
    this.renderer.render(this.scene, this.camera);
    this.placeLabels();
    const cost = performance.now() - begin;
    this.notBefore = begin + (this.plain ? Math.max(200, 6 * cost) : 3 * cost);
    this.frames.push(cost);
    if (this.frames.length > 120) this.frames.shift();
    if (!this.helpless) return;
    const gl = this.renderer.getContext() as WebGL2RenderingContext;
    const done = gl.fenceSync(gl.SYNC_GPU_COMMANDS_COMPLETE, 0);
    if (done) this.asked = { begin, done };
    gl.flush();
  }

  /** Drawn without help, a frame takes processors from the page and from who controls: a third, no more. */
  private lookForEnd(): void {
    const { begin, done } = this.asked!;
    const gl = this.renderer.getContext() as WebGL2RenderingContext;
    const took = performance.now() - begin;
    if (gl.getSyncParameter(done, gl.SYNC_STATUS) !== gl.SIGNALED && took < 2000) return;
    gl.deleteSync(done);
    this.asked = null;
    this.notBefore = Math.max(this.notBefore, begin + 3 * took);
  }

  private placeLabels(): void {
    const { clientWidth: width, clientHeight: height } = this.options.host;
    const p = new Vector3();
    for (const stand of this.stands.values()) {
      const label = this.labels.get(stand.name)!;
      p.set(stand.base.p[0], stand.base.p[1], stand.base.p[2] + footOf(stand.model));
      p.project(this.camera);
      const seen = p.z < 1 && Math.abs(p.x) < 1.1 && Math.abs(p.y) < 1.1;
      label.hidden = !seen;
      if (seen) {
        const x = ((p.x + 1) / 2) * width;
        const y = ((1 - p.y) / 2) * height;
        label.style.transform = `translate(-50%, 14px) translate(${x.toFixed(1)}px, ${y.toFixed(1)}px)`;
      }
    }
  }
}

/** A browser without a graphics processor draws in software, slowly. */
function drawsWithoutHelp(): boolean {
  const gl = document.createElement('canvas').getContext('webgl2');
  const info = gl?.getExtension('WEBGL_debug_renderer_info');
  const name = info ? String(gl!.getParameter(info.UNMASKED_RENDERER_WEBGL)) : '';
  gl?.getExtension('WEBGL_lose_context')?.loseContext();
  return /swiftshader|llvmpipe|software|softpipe/i.test(name);
}

/** The middle of what is looked at, and the corners of each of its boxes, from there. One alone may stand up, too. */
function roomOf(all: readonly Stand[]): { centre: Vector3; corners: Vector3[] } {
  const boxes = all.map((one) => {
    one.group.updateMatrixWorld(true);
    const box = new Box3().setFromObject(one.body.group);
    return all.length === 1 ? box.union(homeBox(one)) : box;
  });
  const centre = boxes.reduce((whole, box) => whole.union(box), new Box3()).getCenter(new Vector3());
  const corners = boxes.flatMap(({ min, max }) =>
    [0, 1, 2, 3, 4, 5, 6, 7].map((k) =>
      new Vector3(k & 1 ? max.x : min.x, k & 2 ? max.y : min.y, k & 4 ? max.z : min.z).sub(centre),
    ),
  );
  return { centre, corners };
}

/** Where its links are at home, in the world. */
function homeBox(stand: Stand): Box3 {
  const box = new Box3();
  const home = stand.model.joints.map((joint) => jointLimits(joint).home);
  for (const pose of linkPoses(stand.model, home)) {
    box.expandByPoint(new Vector3(...compose(stand.base, pose).p));
  }
  return box;
}

function platformOf(stand: Stand): Pose | undefined {
  const { position: p, quaternion: q } = stand.tool;
  return stand.model.kind === 'hexapod' ? { p: [p.x, p.y, p.z], q: [q.w, q.x, q.y, q.z] } : undefined;
}

/** Where its stand ends, m in base B. */
function footOf(model: RobotModel): number {
  const boxes = model.shapes.filter((shape) => shape.link === 0 && shape.form === 'box');
  const bottoms = boxes.map((box) => box.pose!.xyz_m[2] - box.half_m![2]);
  return Math.min(0, ...bottoms);
}

function footRadius(model: RobotModel): number {
  const box = model.shapes.find((shape) => shape.link === 0 && shape.form === 'box');
  return box ? Math.hypot(box.half_m![0], box.half_m![1]) * 1.05 : 0.1;
}
