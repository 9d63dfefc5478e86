"""A client of a running Sinew cell: `sinew serve`, docs/api.md.

    import sinew

    with sinew.connect() as cell:
        arm = cell.robot("learm")
        arm.run("joint base=30deg")
"""

from .cell import Cell, Refused, Robot, connect
from .types import CellDescription, Joint, Job, JointTruth, Pose, RobotDescription, Status, Truth

__all__ = ["Cell", "CellDescription", "Job", "Joint", "JointTruth", "Pose", "Refused", "Robot",
           "RobotDescription", "Status", "Truth", "connect"]
