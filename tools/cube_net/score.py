#!/usr/bin/env python3
"""How well `sinew detect` finds the cubes of rendered tables: score.py SINEW PICTURES.

PICTURES is what cube_pictures wrote, with other seeds than those that were trained on. A cube counts
where 0.6 of its top is shown; one that shows less may be found or not. Right is a detection whose
middle is within a quarter of an edge.
"""

import collections
import glob
import json
import math
import os
import statistics
import subprocess
import sys

COLORS = ["red", "orange", "yellow", "green", "blue", "purple", "pink", "black", "wood", "pale"]


def read_marks(folder):
    marks = collections.defaultdict(list)
    for name in glob.glob(f"{folder}/*.txt"):
        with open(name, encoding="utf-8") as lines:
            for line in lines:
                number, color, seen, *corners = (float(part) for part in line.split())
                if color >= len(COLORS):
                    continue
                quad = list(zip(corners[0::2], corners[1::2]))
                marks[int(number)].append((COLORS[int(color)], seen, quad))
    return marks


def main():
    sinew, folder = sys.argv[1:3]
    marks = read_marks(folder)
    counts = collections.Counter()
    off, turns = [], []
    for name in sorted(glob.glob(f"{folder}/*.png")):
        answer = subprocess.run([sinew, "detect", name, "--json"], capture_output=True, text=True,
                                check=True)
        cubes = json.loads(answer.stdout)["cubes"]
        left = list(marks[int(os.path.basename(name)[:-4])])
        for cube in cubes:
            def distance(mark):
                middle = [sum(p[i] for p in mark[2]) / 4 for i in (0, 1)]
                edge = math.dist(mark[2][0], mark[2][1])
                return math.dist(middle, cube["center_px"]) / max(edge, 1)
            best = min(left, key=distance, default=None)
            if best is None or distance(best) > 0.25:
                counts["wrong"] += 1
                continue
            left.remove(best)
            if best[1] < 0.6:
                continue
            off.append(distance(best))
            counts["found"] += 1
            counts["color"] += best[0] == cube["color"]
            if "yaw_deg" in cube:
                side = [best[2][1][i] - best[2][0][i] for i in (0, 1)]
                turn = math.degrees(math.atan2(side[1], side[0])) - cube["yaw_deg"]
                turns.append(abs((turn + 45) % 90 - 45))
        counts["missed"] += sum(mark[1] >= 0.6 and mark[0] != "pale" for mark in left)
    found, missed, wrong = counts["found"], counts["missed"], counts["wrong"]
    print(f"recall {found / max(1, found + missed):.3f} of {found + missed}, "
          f"precision {found / max(1, found + wrong):.3f}, color right "
          f"{counts['color'] / max(1, found):.3f}, middle off by {100 * statistics.median(off):.1f} "
          f"% of an edge (median)" + (f", yaw by {statistics.median(turns):.1f} deg" if turns else ""))


if __name__ == "__main__":
    sys.exit(main())
