"""What a cell says, as types. SI and radians; legs of a platform have _m where others have _rad."""

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


class Job(TypedDict, total=False):
    robot: str
    job: int
    title: str
    phase: str  # opening, running, paused, stopping, done, stopped, failed
    over: bool
    line: int
    orders_done: int
    orders: int
    predicted_s: float
    elapsed_s: float
    progress: float
    error: Dict[str, Any]
    stopped_by: str


class Status(TypedDict, total=False):
    robot: str
    at_s: float
    state: str
    position: str
    connected: bool
    trouble: str
    joints: List[Joint]
    tool: Pose
    feed: float
    progress: float
    lease: Dict[str, int]
    fault: Dict[str, Any]
    health: Dict[str, float]
    job: Job


class RobotDescription(TypedDict, total=False):
    name: str
    robot: str
    title: str
    port: str
    simulated: bool
    streams: bool
    pose: Pose
    joints: List[Dict[str, Any]]


class CellDescription(TypedDict, total=False):
    title: str
    version: str
    time_scale: float
    robots: List[RobotDescription]
    objects: List[Dict[str, Any]]


class JointTruth(TypedDict, total=False):
    name: str
    position_rad: float
    position_m: float
    stalled: bool


class Truth(TypedDict, total=False):
    joints: List[JointTruth]
    moving: bool
    tool: float
    suction: bool
