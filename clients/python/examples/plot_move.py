#!/usr/bin/env python3
"""Moves a LeArm and draws how its joints went: PLOT.csv, and PLOT.png (matplotlib) or PLOT.svg."""

import csv
from math import degrees

import common
import sinew

PROGRAM = """
joint base=-20deg shoulder=20deg elbow=40deg wrist=40deg roll=0deg
joint base=25deg elbow=60deg speed=60%
"""
COLOURS = ["#0072b2", "#d55e00", "#009e73", "#cc79a7", "#e69f00", "#56b4e9"]


def write_csv(path: str, names, rows) -> None:
    with open(path, "w", newline="") as file:
        table = csv.writer(file)
        table.writerow(["time_s"] + [f"{name}_deg" for name in names])
        table.writerows([[f"{value:.4f}" for value in row] for row in rows])


def write_svg(path: str, names, rows) -> None:
    """Without any library: a line a joint, and its name at its end."""
    width, height, edge = 800, 400, 60
    values = [value for row in rows for value in row[1:]]
    low, high = min(values) - 5, max(values) + 5
    span = max(rows[-1][0], 1e-3)

    def x(time_s: float) -> float:
        return edge + (width - 2 * edge) * time_s / span

    def y(value: float) -> float:
        return height - edge - (height - 2 * edge) * (value - low) / (high - low)

    parts = [f'<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 {width} {height}" '
             'font-family="sans-serif" font-size="12">',
             f'<rect width="{width}" height="{height}" fill="white"/>',
             f'<text x="{edge}" y="{height - 20}">0 s</text>',
             f'<text x="{width - edge - 30}" y="{height - 20}">{span:.1f} s</text>',
             f'<text x="5" y="{edge}">{high:.0f} deg</text>',
             f'<text x="5" y="{height - edge}">{low:.0f} deg</text>']
    for j, name in enumerate(names):
        points = " ".join(f"{x(row[0]):.1f},{y(row[j + 1]):.1f}" for row in rows)
        colour = COLOURS[j % len(COLOURS)]
        parts.append(f'<polyline points="{points}" fill="none" stroke="{colour}"/>')
        parts.append(f'<text x="{width - edge + 5}" y="{y(rows[-1][j + 1]):.1f}" '
                     f'fill="{colour}">{name}</text>')
    with open(path, "w") as file:
        file.write("\n".join(parts + ["</svg>\n"]))


def write_picture(stem: str, names, rows) -> str:
    try:
        import matplotlib
        matplotlib.use("Agg")
        from matplotlib import pyplot
    except ImportError:
        write_svg(stem + ".svg", names, rows)
        return stem + ".svg"
    for j, name in enumerate(names):
        pyplot.plot([row[0] for row in rows], [row[j + 1] for row in rows], label=name)
    pyplot.xlabel("time in s")
    pyplot.ylabel("joint in deg")
    pyplot.legend()
    pyplot.savefig(stem + ".png", dpi=120)
    return stem + ".png"


def run() -> None:
    parser = common.parser(__doc__, "learm")
    parser.add_argument("--plot", default="move", help="name of the files (%(default)s)")
    arguments = parser.parse_args()
    with sinew.connect(arguments.cell) as cell:
        arm = cell.robot(arguments.robot)
        names = [joint["name"] for joint in arm.description()["joints"]]
        rows = []
        for status in arm.samples(PROGRAM, rate_hz=50):
            if all("position_rad" in joint for joint in status["joints"]):
                rows.append([status["at_s"]] +
                            [degrees(joint["position_rad"]) for joint in status["joints"]])
    start = rows[0][0]
    rows = [[row[0] - start] + row[1:] for row in rows]
    write_csv(arguments.plot + ".csv", names, rows)
    picture = write_picture(arguments.plot, names, rows)
    print(f"{len(rows)} samples in {rows[-1][0]:.1f} s: {arguments.plot}.csv, {picture}")


if __name__ == "__main__":
    common.main(run)
