#!/usr/bin/env python3
"""A MaxArm sucks a part, lifts it, and puts it down 80 mm beside, so many times."""

import common
import sinew

ABOVE = "joint base=90deg shoulder=110deg forearm=30deg"
PICK = """
move x={x:.0f}mm y=-180mm z=140mm
line z=110mm speed=40mm/s
suction on
wait 0.5s
line z=140mm
"""
PLACE = """
move x={x:.0f}mm y=-180mm z=140mm
line z=110mm speed=40mm/s
suction release
wait 0.3s
suction off
line z=140mm
"""


def run() -> None:
    parser = common.parser(__doc__, "maxarm")
    parser.add_argument("--parts", type=int, default=2, help="how many (%(default)s)")
    arguments = parser.parse_args()
    with sinew.connect(arguments.cell) as cell:
        arm = cell.robot(arguments.robot)
        arm.run(ABOVE)
        for part in range(arguments.parts):
            here, there = (-40, 40) if part % 2 == 0 else (40, -40)
            arm.run(PICK.format(x=here))
            held = arm.truth()["suction"] if arm.description()["simulated"] else True
            if not held:
                raise sinew.Refused({"message": "the pump does not run"})
            arm.run(PLACE.format(x=there))
            print(f"part {part + 1}: from x = {here} mm to x = {there} mm")


if __name__ == "__main__":
    common.main(run)
