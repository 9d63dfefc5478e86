#!/usr/bin/env python3
"""Turns the first joint of a robot for a second, there and back, as a held key would."""

from math import degrees, radians

import common
import sinew


def run() -> None:
    parser = common.parser(__doc__, "learm")
    parser.add_argument("--speed", type=float, default=10, metavar="DEG_S", help="%(default)s deg/s")
    arguments = parser.parse_args()
    with sinew.connect(arguments.cell) as cell:
        arm = cell.robot(arguments.robot)
        joints = len(arm.status()["joints"])
        with arm.lease() as lease:
            lease.enable()
            for way in (1, -1):
                velocity = [way * radians(arguments.speed)] + [0.0] * (joints - 1)
                lease.jog("joint", velocity, duration_s=1)
                at = arm.status()["joints"][0]["position_rad"]
                print(f"now at {degrees(at):.1f} deg")


if __name__ == "__main__":
    common.main(run)
