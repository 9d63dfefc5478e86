#!/usr/bin/env python3
"""Marked photos as other cameras and lamps would have taken them: vary.py FOLDER OUT.

FOLDER has photos and a groundtruth.json (score.py says of what form). Writes a folder for each
variation into OUT, with marks that were moved along. A few photos are too few to develop on; these
show what a change of the detection does to pictures of another size, light or tint.
`score.py SINEW OUT/*` scores all. Needs python3-opencv. Points are px from the picture's corner.
"""

import copy
import json
import sys
from pathlib import Path

import cv2
import numpy as np


def pixels(change):
    """A variation of values (0 to 255, blue, green, red), without a motion."""
    def varied(photo):
        return np.clip(change(photo.astype(np.float32)), 0, 255).astype(np.uint8), np.eye(3)
    return varied


def gains(blue, green, red):
    return pixels(lambda v: v * np.array([blue, green, red], np.float32))


def gamma(power):
    return pixels(lambda v: 255 * (v / 255) ** power)


def saturation(factor):
    def change(v):
        grey = v @ np.array([0.114, 0.587, 0.299], np.float32)
        return grey[..., None] + factor * (v - grey[..., None])
    return pixels(change)


def noisy(photo):
    noise = np.random.default_rng(5).normal(0, 9, photo.shape)
    return np.clip(photo + noise, 0, 255).astype(np.uint8), np.eye(3)


def shaded(photo):
    light = np.linspace(0.55, 1.1, photo.shape[1])[None, :, None]
    return np.clip(photo * light, 0, 255).astype(np.uint8), np.eye(3)


def compressed(photo):
    _, data = cv2.imencode(".jpg", photo, [cv2.IMWRITE_JPEG_QUALITY, 30])
    return cv2.imdecode(data, 1), np.eye(3)


def blurred(photo):
    return cv2.GaussianBlur(photo, (0, 0), 1.3), np.eye(3)


def scaled(factor):
    def varied(photo):
        how = cv2.INTER_AREA if factor < 1 else cv2.INTER_CUBIC
        return (cv2.resize(photo, None, fx=factor, fy=factor, interpolation=how),
                np.diag([factor, factor, 1.0]))
    return varied


def mirrored(photo):
    return cv2.flip(photo, 1), np.array([[-1, 0, photo.shape[1]], [0, 1, 0], [0, 0, 1.0]])


def turned(photo):
    height, width = photo.shape[:2]
    turn = np.vstack([cv2.getRotationMatrix2D((width / 2, height / 2), 15, 1), [0, 0, 1]])
    return warped(photo, turn)


def tilted(photo):
    height, width = photo.shape[:2]
    corners = np.float32([[0, 0], [width, 0], [width, height], [0, height]])
    inward = np.float32([[width, height], [-width, height], [0, 0], [0, 0]])
    return warped(photo, cv2.getPerspectiveTransform(corners, corners + 0.1 * inward))


def warped(photo, motion):
    """Grey where the photo has nothing. cv2 counts from the middle of the first pixel."""
    half = np.array([[1, 0, 0.5], [0, 1, 0.5], [0, 0, 1]])
    return cv2.warpPerspective(photo, motion, photo.shape[1::-1], flags=cv2.INTER_CUBIC,
                               borderValue=(114, 114, 114)), half @ motion @ np.linalg.inv(half)


VARIATIONS = {
    "plain": pixels(lambda v: v),
    "half": scaled(0.5), "three-quarters": scaled(0.75), "larger": scaled(1.5), "double": scaled(2),
    "mirrored": mirrored, "turned": turned, "tilted": tilted,
    "dark": gamma(1.6), "light": gamma(0.65), "dim": gains(0.5, 0.5, 0.5),
    "bright": gains(1.3, 1.3, 1.3), "shaded": shaded,
    "warm": gains(0.88, 0.97, 1.07), "very-warm": gains(0.7, 0.95, 1.15),
    "cold": gains(1.08, 1, 0.9), "very-cold": gains(1.2, 1, 0.8), "greenish": gains(0.9, 1.1, 0.9),
    "pale": saturation(0.7), "vivid": saturation(1.4),
    "noisy": noisy, "blurred": blurred, "compressed": compressed,
}


def moved(point, motion):
    x, y, w = motion @ np.array([*point, 1.0])
    return [x / w, y / w]


def move_marks(image, motion, shape):
    """The marks of one photo, those that are still in it; sizes by the scale in its middle."""
    height, width = shape[:2]
    for cube in image["cubes"]:
        cube["center_px"] = moved(cube["center_px"], motion)
    image["cubes"] = [cube for cube in image["cubes"]
                      if 0 <= cube["center_px"][0] < width and 0 <= cube["center_px"][1] < height]
    middle = moved((width / 2, height / 2), np.linalg.inv(motion))
    here, right, down = (np.array(moved(np.add(middle, step), motion))
                         for step in ((0, 0), (1, 0), (0, 1)))
    scale = abs(np.linalg.det(np.stack([right - here, down - here]))) ** 0.5
    image["match_tol_px"] *= scale
    image["cube_px"] = [scale * size for size in image.get("cube_px", [0])]
    if image.get("roi"):  # the part of it that stays a rectangle
        x0, y0, x1, y1 = image["roi"]
        corners = np.array([moved(p, motion) for p in ((x0, y0), (x1, y0), (x0, y1), (x1, y1))])
        low, high = np.sort(corners, axis=0)[1:3]
        image["roi"] = [*low.tolist(), *high.tolist()]
    image["file"] = str(Path(image["file"]).with_suffix(".png"))


def main():
    if len(sys.argv) != 3:
        sys.exit("usage: vary.py FOLDER OUT")
    folder, out = Path(sys.argv[1]), Path(sys.argv[2])
    truth = json.loads((folder / "groundtruth.json").read_text(encoding="utf-8"))
    for name, variation in VARIATIONS.items():
        (out / name).mkdir(parents=True, exist_ok=True)
        marks = copy.deepcopy(truth)
        for image in marks["images"]:
            photo = cv2.imread(str(folder / image["file"]))
            if photo is None:
                sys.exit(f"{folder / image['file']}: cannot be read")
            varied, motion = variation(photo)
            move_marks(image, motion, varied.shape)
            if not cv2.imwrite(str(out / name / image["file"]), varied):
                sys.exit(f"{out / name / image['file']}: cannot be written")
        (out / name / "groundtruth.json").write_text(json.dumps(marks), encoding="utf-8")


if __name__ == "__main__":
    main()
