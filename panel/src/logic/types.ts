/** What the server says, as docs/api.md has it: SI and radians, the unit in each name. */

export type Vec3 = [number, number, number];
/** w, x, y, z. */
export type Quat = [number, number, number, number];

export interface Pose {
  p: Vec3;
  q: Quat;
}

export interface FlatPoseJson {
  x_m: number;
  y_m: number;
  z_m: number;
  quaternion_wxyz: Quat;
}

export interface PoseJson {
  xyz_m: Vec3;
  quaternion_wxyz: Quat;
}

export type Quality = 'measured' | 'commanded' | 'uncertain' | 'lost';
export type MachineState =
  | 'off'
  | 'enabling'
  | 'ready'
  | 'moving'
  | 'stopping'
  | 'held'
  | 'fault'
  | 'recovering';

/** Beside these `measured` and `limit`, with their unit in their names (`measured_rad`); null is no number. */
export interface ErrorJson {
  code: string;
  sentence: string;
  joint?: string;
  links?: string;
  link?: string;
  other?: string;
  other_link?: string;
  /** The joint's board is left out by choice. */
  left_out?: boolean;
  line?: number;
  share?: number;
  way_m?: number;
  distance_m?: number;
  margin_m?: number;
  moving?: boolean;
  nearest_behind_m?: number;
  /** Rows that would work instead, each behind its words. */
  remedies?: string[];
}

export interface FaultJson {
  cause: string;
  error: ErrorJson;
  later?: FaultJson[];
}

export interface JointStatus {
  name: string;
  quality: Quality;
  position_rad?: number;
  position_m?: number;
  lower_rad?: number;
  upper_rad?: number;
  lower_m?: number;
  upper_m?: number;
  commanded_rad?: number;
  commanded_m?: number;
}

export interface RobotStatus {
  robot: string;
  at_s: number;
  state: MachineState;
  position: Quality;
  connected: boolean;
  joints: JointStatus[];
  feed: number;
  /** Its motors are off, to guide it by hand; nothing moves before they hold it again. */
  free_drive: boolean;
  progress: number;
  trouble?: string;
  tool?: FlatPoseJson;
  /** Between a gripper's jaws, as they were told last or measured. */
  jaws_m?: number;
  /** Width of what they hold. */
  held_m?: number;
  lease?: { client: number; epoch: number };
  homing?: string;
  fault?: FaultJson;
  last_stop?: string;
  goes_on_s?: number;
  jog?: { reason: string; share: number; joint?: string };
  health: Record<string, number>;
  cycle?: { mean_s: number; longest_s: number };
  /** Goes up whenever something that the controller keeps has changed. */
  kept?: number;
  recording?: { record: string; length_s: number; size_bytes: number };
  job?: JobJson;
}

/** What holds motions back for longest. */
export interface LimitedJson {
  by: string;
  share_of_time: number;
  joint?: string;
}

export type JobPhase =
  | 'opening'
  | 'planned'
  | 'running'
  | 'paused'
  | 'stopping'
  | 'done'
  | 'stopped'
  | 'failed';

export interface JobJson {
  robot: string;
  job: number;
  client: number;
  title: string;
  phase: JobPhase;
  over: boolean;
  line: number;
  predicted_s: number;
  elapsed_s: number;
  progress: number;
  orders?: number;
  orders_done?: number;
  limited?: LimitedJson;
  waits_for?: string;
  /** Its client is gone: whoever has control goes on with it. */
  client_lost?: boolean;
  /** The client that guards the hold. */
  held_by?: number;
  stopped_by?: string;
  error?: ErrorJson;
  /** What was told last. */
  last_notice?: ErrorJson;
  /** Why it paused by itself, while it does. */
  paused_by?: ErrorJson;
  notes?: { line: number; sentence: string }[];
}

export interface CellRobot {
  name: string;
  robot: string;
  title: string;
  port: string;
  simulated: boolean;
  /** Of its own time against ours; 1 where it is real. */
  time_scale: number;
  pose: FlatPoseJson;
  streams: boolean;
  /** Its motors can be switched off to guide it by hand. */
  free_drive?: boolean;
  stop?: { ends_motion: boolean; standstill: string; gravity: string };
  nudge_max_m?: number;
  nudge_max_rad?: number;
  position_journal?: { found: string; way_out: string };
}

export interface CellObject {
  name: string;
  x_m: number;
  y_m: number;
  z_m: number;
  quaternion_wxyz: Quat;
  length_m: number;
  width_m: number;
  height_m: number;
}

export interface CellCamera {
  name: string;
  device: string;
  /** Edge of the cubes on its table. */
  cube_m: number;
  table: FlatPoseJson;
  /** Where its calibration is kept, and why what is kept there does not count. */
  calibration?: { file: string; refused?: string };
  /** It moves with an arm: its pictures say where it was. */
  on_arm?: boolean;
  /** Of a calibrated one. */
  lens?: {
    /** Not where its arm's position is unknown. */
    pose?: FlatPoseJson;
    width_px: number;
    height_px: number;
    fx_px: number;
    fy_px: number;
    cx_px: number;
    cy_px: number;
    /** k1, k2, p1, p2, k3 */
    distortion: [number, number, number, number, number];
    accuracy_m: number;
  };
}
/** A box without a lid; its place is the middle of its floor. */
export interface BasketJson extends FlatPoseJson {
  name: string;
  length_m: number;
  width_m: number;
  height_m: number;
}
export interface SeenCubeJson {
  color: string;
  confidence: number;
  top_px: [number, number][];
  /** The middle of its top in the cell, where the camera is calibrated. */
  x_m?: number;
  y_m?: number;
  z_m?: number;
  yaw_rad?: number;
  edge_m?: number;
  /** Its name. */
  in_basket?: string;
}
/** What can happen to a simulated camera. */
export const cameraTroubles = ['none', 'hand', 'covered', 'unplugged', 'frozen'] as const;
export type CameraTrouble = (typeof cameraTroubles)[number];
/** What camera.look tells; number 0: there is no picture yet. */
export interface CameraShot {
  camera: string;
  number: number;
  width_px?: number;
  height_px?: number;
  fault?: ErrorJson;
  /** What happens to a simulated camera; not there of any other. */
  trouble?: CameraTrouble;
  /** Of a camera on an arm. */
  pose?: FlatPoseJson;
  /** A JPEG as base64. */
  picture?: string;
  cubes?: SeenCubeJson[];
  refused?: { why: string; outline_px: [number, number][] }[];
  baskets?: BasketJson[];
  /** Where they were asked for. */
  tags?: { id: number; corners_px: [number, number][] }[];
}
/** Whether a robot can pick a cube as it lies. */
export interface CubeVerdictJson {
  color: string;
  x_m: number;
  y_m: number;
  z_m: number;
  fine: boolean;
  tilt_rad?: number;
  error?: ErrorJson;
}
/** Letters of a grid's points: s straight down, t tilted, - not, . not known yet. */
export interface CubeReachJson {
  robot: string;
  edge_m: number;
  z_m: number;
  step_m: number;
  x_m: number;
  y_m: number;
  columns: number;
  done: number;
  rows: string[];
}
/** A view of the board, or of the sheet on the table: the corners of each tag. */
export interface CalibrationView {
  view: number;
  tags: number;
  corners_px: [number, number][][];
  /** Rms. */
  residual_px?: number;
}
/** A mark of the sheet that a tool can touch, from its middle. */
export interface SheetMark {
  mark: string;
  x_m: number;
  y_m: number;
}
/** Where the sheet lies, by the marks that a robot's tool has touched. */
export interface TouchJson {
  robot: string;
  marks: { mark: string; off_m?: number }[];
  trouble?: string;
  too_few?: boolean;
  rms_m?: number;
  /** 95 %, at the corner of the sheet where it is largest. */
  error_m?: number;
  moved_m?: number;
  next?: { mark: string; error_m: number };
}
/** What camera.calibration.status tells; what is missing where none is under way is optional. */
export interface Calibration {
  camera: string;
  under_way: boolean;
  simulated: boolean;
  file?: string;
  session?: number;
  step?: 'board' | 'sheet' | 'touch';
  paper?: string;
  width_px?: number;
  height_px?: number;
  views_least?: number;
  views_enough?: number;
  views?: CalibrationView[];
  sheet?: CalibrationView;
  /** Rows of the picture from above. */
  coverage?: boolean[][];
  better?: string;
  trouble?: string;
  result?: {
    table_error_m: number;
    reprojection_px: number;
    ambiguous: boolean;
    left_out: number;
    pose: FlatPoseJson;
    fx_px: number;
    fy_px: number;
  };
  /** Of the sheet, from its middle. */
  marks?: SheetMark[];
  paper_m?: [number, number];
  touch?: TouchJson;
  /** Which has measured where the sheet lies, in what is saved now. */
  table_robot?: string;
  taken?: number;
  saved?: { file: string; table_error_m: number; sheet_stays: boolean };
}
export interface CellDescription {
  title: string;
  version: string;
  time_scale: number;
  robots: CellRobot[];
  objects: CellObject[];
  cameras: CellCamera[];
  baskets?: BasketJson[];
}

export interface JointJson {
  name: string;
  kind: 'revolute' | 'prismatic';
  lower_rad?: number;
  upper_rad?: number;
  home_rad?: number;
  velocity_max_rad_s?: number;
  lower_m?: number;
  upper_m?: number;
  home_m?: number;
  velocity_max_m_s?: number;
}

export interface DhRow {
  d_m: number;
  a_m: number;
  alpha_rad: number;
  theta_offset_rad: number;
  slides?: boolean;
}

export interface SerialGeometry {
  dh: DhRow[];
  tool: PoseJson;
  /** `width_m` is how wide the jaws are now; open where nobody knows. */
  gripper?: { width_max_m: number; reach_open_m: number; reach_closed_m: number; width_m?: number };
}

export interface PalletizerGeometry {
  base_height_m: number;
  shoulder_offset_m: number;
  upper_arm_m: number;
  forearm_m: number;
  tool_offset_m: number;
  base_front_rad: number;
  radius_min_m: number;
}

export interface HexapodGeometry {
  base_anchors_m: Vec3[];
  platform_anchors_m: Vec3[];
  platform_radius_m: number;
  home: PoseJson;
}

export interface ShapeJson {
  link: number;
  form: 'capsule' | 'box' | 'leg' | 'finger' | 'held';
  from_m?: Vec3;
  to_m?: Vec3;
  radius_m?: number;
  pose?: PoseJson;
  half_m?: Vec3;
}

export type JogFrame = 'joint' | 'base' | 'tool' | 'platform';
export type TaskSpace = 'pose' | 'yaw' | 'pitch_roll' | 'approach' | 'point';

interface ModelBase {
  robot: string;
  title: string;
  task: TaskSpace;
  joints: JointJson[];
  links: { name: string; home?: PoseJson }[];
  shapes: ShapeJson[];
  margin_m: number;
  table_height_m?: number;
  jog: Partial<Record<JogFrame, number>>;
  takes_speed: boolean;
}

export type RobotModel = ModelBase &
  (
    | { kind: 'serial'; geometry: SerialGeometry }
    | { kind: 'palletizer'; geometry: PalletizerGeometry }
    | { kind: 'hexapod'; geometry: HexapodGeometry }
  );

/** x, y, z, w, x, y, z. */
export type ToolRow = [number, number, number, number, number, number, number];

export interface PreviewJson {
  robot: string;
  text: string;
  duration_s: number;
  homing_at_most_s: number;
  first_move: boolean;
  limited?: LimitedJson;
  from?: number[];
  to: { positions: number[] | null; tool: ToolRow | null };
  samples: PreviewSamples;
}

export interface PreviewSamples {
  t_s: number[];
  position_rad?: number[][];
  position_m?: number[][];
  /** Of joints of both kinds: each in its own unit. */
  position_rad_m?: number[][];
  velocity_rad_s?: number[][];
  velocity_m_s?: number[][];
  velocity_rad_m_s?: number[][];
  acceleration_rad_s2?: number[][];
  acceleration_m_s2?: number[][];
  acceleration_rad_m_s2?: number[][];
  jerk_rad_s3?: number[][];
  jerk_m_s3?: number[][];
  jerk_rad_m_s3?: number[][];
  tool: ToolRow[];
}

export interface RefusalData extends ErrorJson {
  would_work?: { what: string; positions: number[]; left_m?: number };
}

/** Of `program.check`: the rows of the program and of those that it calls, in the order in which they are run. */
export interface CheckRow {
  line: number;
  column: number;
  /** The called program that it stands in. */
  file?: string;
  verdict: 'fine' | 'refused' | 'not_checked';
  time_min_s?: number;
  time_max_s?: number;
  /** It is one motion with the row of this line. */
  motion_of_line?: number;
  sentence?: string;
  /** Of a file of points, dotted. */
  key?: string;
  refusal?: RefusalData;
  round?: number;
  because?: { line: number; column: number; file?: string };
}

export interface CheckJson {
  fine: boolean;
  /** None of a text that cannot be read. */
  duration_min_s?: number;
  duration_max_s?: number;
  homing_at_most_s?: number;
  rows: CheckRow[];
  broken_off?: { sentence: string; refusal?: RefusalData; file?: string };
}

export interface EventJson {
  number: number;
  at_ms: number;
  robot: string;
  kind: 'state' | 'lease' | 'stop' | 'fault' | 'notice' | 'record' | 'job' | 'declared' | 'declaration_refused' | 'procedure' | 'demonstration' | 'begun';
  version?: string;
  runs?: boolean;
  procedure?: string;
  state?: MachineState;
  cause?: string;
  error?: ErrorJson;
  client?: number | null;
  title?: string;
  phase?: JobPhase;
  over?: boolean;
  job?: number;
  predicted_s?: number;
  limited?: LimitedJson;
  path?: string;
  lost?: number;
  trouble?: string;
  full?: boolean;
  reason?: string;
}
