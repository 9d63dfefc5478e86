#!/usr/bin/env python3
"""The weights of src/sinew/vision/top_belief.cc: belief.py CUBE_TOPS PICTURES.

PICTURES is what cube_pictures wrote, with other seeds than those that the network was trained on.
Logistic regression of whether a top is one of a cube; prints the weights, and what recall and
precision each least belief has on the half of the pictures that it was not fitted to.
"""

import glob
import math
import os
import subprocess
import sys

import numpy as np

from score import read_marks


def labels(tops, marks):
    """1: a cube's, 0: none, -1: neither (mostly hidden, white); each mark once, the surest first."""
    left = list(marks)
    out = [0] * len(tops)
    for i in sorted(range(len(tops)), key=lambda i: -tops[i][2]):
        def distance(mark):
            middle = [sum(p[axis] for p in mark[2]) / 4 for axis in (0, 1)]
            return math.dist(middle, tops[i][:2]) / max(1, math.dist(mark[2][0], mark[2][1]))
        best = min(left, key=distance, default=None)
        if best is None or distance(best) > 0.25:
            continue
        left.remove(best)
        out[i] = 1 if best[1] >= 0.6 and best[0] != "pale" else -1
    return out


def fitted(x, y):
    """Newton's method; a little ridge keeps it stable."""
    x = np.c_[x, np.ones(len(x))]
    weights = np.zeros(x.shape[1])
    for _ in range(40):
        p = 1 / (1 + np.exp(-x @ weights))
        slope = x.T @ (p - y) + 1e-2 * weights
        curve = (x * (p * (1 - p))[:, None]).T @ x + 1e-2 * np.eye(len(weights))
        weights -= np.linalg.solve(curve, slope)
    return weights


def main():
    program, folder = sys.argv[1:3]
    marks = read_marks(folder)
    names = sorted(glob.glob(f"{folder}/*.png"))
    tops = {name: [] for name in names}
    for begin in range(0, len(names), 100):
        answer = subprocess.run([program, *names[begin:begin + 100]], capture_output=True, text=True,
                                check=True)
        for line in answer.stdout.splitlines():
            name, *numbers = line.rsplit(" ", 7)
            tops[name].append([float(number) for number in numbers])
    x, y, pale, half, wanted = [], [], [], [], [0, 0]
    for i, name in enumerate(names):
        these = marks[int(os.path.basename(name)[:-4])]
        wanted[i % 2] += sum(mark[1] >= 0.6 and mark[0] != "pale" for mark in these)
        y += labels(tops[name], these)
        x += [top[2:6] for top in tops[name]]
        pale += [top[6] for top in tops[name]]
        half += [i % 2] * len(tops[name])
    x, y, pale, half = np.array(x), np.array(y), np.array(pale), np.array(half)
    print("network, alike, stretch, corners, offset:", fitted(x[y >= 0], y[y >= 0]).round(2))
    weights = fitted(x[(y >= 0) & (half == 0)], y[(y >= 0) & (half == 0)])
    belief = 1 / (1 + np.exp(-np.c_[x, np.ones(len(x))] @ weights))
    for least in (0.4, 0.5, 0.55, 0.6, 0.7):
        taken = (belief > least) & (pale == 0) & (half == 1)
        right, wrong = (taken & (y == 1)).sum(), (taken & (y == 0)).sum()
        print(f"belief {least}: recall {right / wanted[1]:.3f}, "
              f"precision {right / max(1, right + wrong):.3f}")


if __name__ == "__main__":
    main()
