"""What a cell says, as types. SI and radians; legs of a platform have _m where others have _rad.

The whole of it stands in what `rpc.discover` answers; a test holds these against that.
"""

from typing import Any, Dict, List, TypedDict


class Pose(TypedDict):
    x_m: float
    y_m: float
    z_m: float
    quaternion_wxyz: List[float]


class Joint(TypedDict, total=False):
    name: str
    quality: str  # measured, commanded, uncertain, lost
    position_rad: float
    lower_rad: float
    upper_rad: float
    commanded_rad: float
    position_m: float
    lower_m: float
    upper_m: float
    commanded_m: float


class Error(TypedDict, total=False):
    """With its numbers besides, `measured` and `limit`, their unit in the name."""
    code: str
    sentence: str
    joint: str
    link: str
    links: str
    left_out: bool
    line: int
    share: float
    way_m: float
    other: str
    other_link: str
    distance_m: float
    margin_m: float
    moving: bool
    nearest_behind_m: float
    would_work: Dict[str, Any]
    remedies: List[str]


class Limited(TypedDict, total=False):
    """What holds motions back for longest."""
    by: str
    share_of_time: float
    joint: str


class Cycle(TypedDict, total=False):
    """Of the control loop, over its last hundred cycles."""
    mean_s: float
    longest_s: float


class Job(TypedDict, total=False):
    robot: str
    job: int
    client: int
    title: str
    phase: str  # opening, planned, running, paused, stopping, done, stopped, failed
    over: bool
    line: int
    orders_done: int
    orders: int
    predicted_s: float
    homing_at_most_s: float
    elapsed_s: float
    progress: float
    notices: int
    wishes: int
    limited: Limited
    error: Error
    wish_refused: Error
    waits_for: str
    client_lost: bool
    held_by: int
    stopped_by: str
    paused_by: Error
    last_notice: Error
    notes: List[Dict[str, Any]]


class Fault(TypedDict, total=False):
    cause: str
    category: int  # 0 to 2, IEC 60204-1
    error: Error
    later: List["Fault"]


class Status(TypedDict, total=False):
    robot: str
    at_s: float
    state: str  # off, enabling, ready, moving, stopping, held, fault, recovering
    position: str
    connected: bool
    kept: int
    trouble: str
    joints: List[Joint]
    tool: Pose
    jaws_m: float
    held_m: float
    feed: float
    free_drive: bool
    progress: float
    lease: Dict[str, int]
    homing: str
    fault: Fault
    jog: Dict[str, Any]
    last_stop: str
    goes_on_s: float
    health: Dict[str, float]
    cycle: Cycle
    recording: Dict[str, Any]
    job: Job
    procedure: Dict[str, Any]


class DescribedJoint(TypedDict, total=False):
    name: str
    lower_rad: float
    upper_rad: float
    home_rad: float
    velocity_max_rad_s: float
    acceleration_max_rad_s2: float
    lower_m: float
    upper_m: float
    home_m: float
    velocity_max_m_s: float
    acceleration_max_m_s2: float


class RobotDescription(TypedDict, total=False):
    name: str
    robot: str
    title: str
    port: str
    simulated: bool
    time_scale: float
    pose: Pose
    streams: bool
    free_drive: bool
    probes: bool
    joints: List[DescribedJoint]
    stop: Dict[str, Any]
    position_journal: Dict[str, str]
    nudge_max_rad: float
    nudge_max_m: float


class CellDescription(TypedDict, total=False):
    title: str
    version: str
    time_scale: float
    robots: List[RobotDescription]
    objects: List[Dict[str, Any]]
    cameras: List[Dict[str, Any]]
    baskets: List[Dict[str, Any]]


class JointTruth(TypedDict, total=False):
    name: str
    position_rad: float
    position_m: float
    believed_rad: float
    believed_m: float
    stalled: bool
    at_end_stop: bool
    lost_steps: bool


class Truth(TypedDict, total=False):
    joints: List[JointTruth]
    supply_v: float
    moving: bool
    tool: float
    suction: bool
