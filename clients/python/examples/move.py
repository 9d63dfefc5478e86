#!/usr/bin/env python3
"""Moves a LeArm to a place where it stands well, and turns its base by 30 degrees."""

from math import degrees

import common
import sinew

PROGRAM = """
joint base=0deg shoulder=20deg elbow=40deg wrist=40deg roll=0deg
joint base=30deg speed=50%
"""


def run() -> None:
    arguments = common.parser(__doc__, "learm").parse_args()
    with sinew.connect(arguments.cell) as cell:
        arm = cell.robot(arguments.robot)
        job = arm.run(PROGRAM)
        base = arm.status()["joints"][0]
        print(f"{job['orders_done']} moves in {job['elapsed_s']:.1f} s; "
              f"{base['name']} at {degrees(base['position_rad']):.1f} deg")


if __name__ == "__main__":
    common.main(run)
