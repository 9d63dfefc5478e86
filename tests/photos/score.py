#!/usr/bin/env python3
"""How well `sinew detect` finds the cubes in photos whose cubes are marked.

score.py SINEW [FOLDER...]: each FOLDER, or SINEW_PHOTOS, has photos and a groundtruth.json:
{"images": [{"file", "match_tol_px", "roi": [x0, y0, x1, y1] or null,
             "cubes": [{"color", "center_px", "alt": [colors], "stacked": bool}],
             "cube_px": [least, most]}]}

Where "view" is "oblique" the middle of a cube's silhouette is marked: it is half an upright edge, as
the shape of the top shows it, below the middle of the top, which is what a detection has.

A detection is right where a cube of its color (or one of `alt`) is within match_tol_px, each once,
the nearest first. What is outside of `roi`, or beside a stack, does not count. Without FOLDER it
says so and ends with 77. No photo is part of this project: each has an owner.
"""

import json
import math
import os
import statistics
import subprocess
import sys
from pathlib import Path

SKIPPED = 77


def detect(sinew, path):
    done = subprocess.run([sinew, "detect", str(path), "--json"], capture_output=True, text=True,
                          check=False)
    if done.returncode != 0:
        raise SystemExit(f"{path}: {done.stderr}")
    return json.loads(done.stdout)["cubes"]


def counts(image, cube):
    """Whether a detection is about anything that was marked."""
    x, y = cube["center_px"]
    if image.get("roi"):
        x0, y0, x1, y1 = image["roi"]
        if not (x0 <= x <= x1 and y0 <= y <= y1):
            return False
    return True


def beside_a_stack(image, cube):
    reach = 2.5 * max(image.get("cube_px", [0]))
    return any(one.get("stacked") and math.dist(one["center_px"], cube["center_px"]) < reach
               for one in image["cubes"])


def silhouette_of(cube):
    """Middle of the silhouette of a cube by its top: a square seen aside, whose shorter axis points
    down the upright edges.
    """
    corners = cube["top_px"]
    across = [(corners[1][i] - corners[0][i] + corners[2][i] - corners[3][i]) / 2 for i in (0, 1)]
    down = [(corners[3][i] - corners[0][i] + corners[2][i] - corners[1][i]) / 2 for i in (0, 1)]
    xx, xy, yy = (across[i] * across[k] + down[i] * down[k] for i, k in ((0, 0), (0, 1), (1, 1)))
    longer = (xx + yy) / 2 + math.hypot((xx - yy) / 2, xy)
    shorter = max(0.0, xx + yy - longer)
    angle = math.atan2(2 * xy, xx - yy) / 2 + math.pi / 2
    upright = math.sqrt(longer - shorter)
    x, y = cube["center_px"]
    sign = 1 if math.sin(angle) >= 0 else -1
    return [x + sign * math.cos(angle) * upright / 2, y + sign * math.sin(angle) * upright / 2]


def place_of(image, cube):
    return silhouette_of(cube) if image.get("view") == "oblique" else cube["center_px"]


def score(image, cubes):
    """(right, wrong, missed, errors in shares of an edge)"""
    left = list(image["cubes"])
    pairs = sorted(((math.dist(place_of(image, seen), one["center_px"]), i, k)
                    for i, seen in enumerate(cubes) for k, one in enumerate(left)
                    if seen["color"] in [one["color"], *one.get("alt", [])]),
                   key=lambda pair: pair[0])
    found, taken, errors = set(), set(), []
    for distance, i, k in pairs:
        if distance > image["match_tol_px"] or i in found or k in taken:
            continue
        found.add(i)
        taken.add(k)
        errors.append(distance / cubes[i]["size_px"])
    wrong = [cube for i, cube in enumerate(cubes)
             if i not in found and counts(image, cube) and not beside_a_stack(image, cube)]
    missed = [one for k, one in enumerate(left) if k not in taken]
    return len(found), wrong, missed, errors


def main():
    folders = sys.argv[2:] or [os.environ.get("SINEW_PHOTOS", "")]
    if folders == [""]:
        print("no photos: SINEW_PHOTOS names no folder that has some; skipped")
        return SKIPPED
    right, wrong, missed, errors = 0, 0, 0, []
    for folder in map(Path, folders):
        truth = json.loads((folder / "groundtruth.json").read_text(encoding="utf-8"))
        for image in truth["images"]:
            found, extra, lost, off = score(image, detect(sys.argv[1], folder / image["file"]))
            print(f"{folder.name}/{image['file']}: {found} of {len(image['cubes'])}, "
                  f"missed {[one['color'] for one in lost]}, "
                  f"wrong {[(one['color'], one['center_px']) for one in extra]}")
            right, wrong, missed = right + found, wrong + len(extra), missed + len(lost)
            errors += off
    recall = right / max(1, right + missed)
    precision = right / max(1, right + wrong)
    middle = statistics.median(errors) if errors else 1
    print(f"recall {recall:.2f}, precision {precision:.2f}, "
          f"middle off by {100 * middle:.1f} % of an edge (median)")
    # A rough guard; docs/vision.md has what it reaches.
    return 0 if recall >= 0.85 and precision >= 0.9 else 1


if __name__ == "__main__":
    sys.exit(main())
