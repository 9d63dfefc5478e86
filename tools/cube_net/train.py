#!/usr/bin/env python3
"""Trains the network that finds the tops of cubes (src/sinew/vision/cube_net.weights) from nothing.

train.py PICTURES OUT.weights [--minutes 60] [--begin BEFORE.weights]: PICTURES is what cube_pictures
wrote, or still writes. Saves OUT.weights every few minutes; a later run may go on from there. Needs
python3-torch, python3-numpy and python3-opencv. docs/vision.md says what the outputs mean.
"""

import argparse
import collections
import copy
import glob
import math
import os
import time

import cv2
import numpy as np
import torch
import torch.nn.functional as F
from torch import nn

STRIDE = 4
COLORS = 10  # nine names, and white or grey
OTHERS = 5  # kinds of things that are no cubes
UNNAMED = 99  # instead of a color: a top that is burnt out
SIDE = 256  # px, of what is trained on
SEEN = 0.6  # share of a top that must be seen
UNSURE = 0.25  # between: neither right nor wrong


def conv(inside, outside, stride=1):
    return nn.Sequential(nn.Conv2d(inside, outside, 3, stride, 1, bias=False),
                         nn.BatchNorm2d(outside), nn.ReLU(inplace=True))


def point(inside, outside):
    return nn.Sequential(nn.Conv2d(inside, outside, 1, bias=False), nn.BatchNorm2d(outside),
                         nn.ReLU(inplace=True))


class Block(nn.Module):
    """A 3 x 3 filter for each channel, then a mix of them, beside what came in."""

    def __init__(self, size):
        super().__init__()
        self.body = nn.Sequential(nn.Conv2d(size, size, 3, 1, 1, groups=size, bias=False),
                                  nn.BatchNorm2d(size), nn.ReLU(inplace=True),
                                  nn.Conv2d(size, size, 1, bias=False), nn.BatchNorm2d(size))

    def forward(self, x):
        return F.relu(x + self.body(x))


def take_norms_in(module):
    """Each norm becomes a part of the layer before it: the same sums, and half the time of a step."""
    for name, child in module.named_children():
        if not isinstance(child, nn.Sequential):
            take_norms_in(child)
            continue
        layers = []
        for layer in child:
            if not isinstance(layer, nn.BatchNorm2d):
                layers.append(layer)
                continue
            weight, offset = folded(layers[-1], layer)
            layers[-1].weight.data.copy_(weight)
            layers[-1].bias = nn.Parameter(offset)
        setattr(module, name, nn.Sequential(*layers))
        take_norms_in(getattr(module, name))


class CubeNet(nn.Module):
    """Picture (RGB, 0 to 1) -> 24 numbers for each 4 x 4 px.

    0: a top's middle is here (logit); 1, 2: where, from the cell's middle (cells); 3 to 7: affine();
    8 to 17: color (logits); 18: something else has its middle here; 19 to 23: which kind (logits).
    """

    def __init__(self):
        super().__init__()
        sizes = [24, 40, 64, 96]
        self.stem = conv(3, 12, 2)
        self.down = nn.ModuleList()
        before = 12
        for size, blocks in zip(sizes, [1, 3, 4, 4]):
            self.down.append(nn.Sequential(conv(before, size, 2),
                                           *[Block(size) for _ in range(blocks)]))
            before = size
        self.up = nn.ModuleList(point(sizes[i + 1], sizes[i]) for i in range(3))
        self.mix = nn.ModuleList([nn.Sequential(Block(24), point(24, 32), Block(32)),
                                  nn.Sequential(Block(40), Block(40)),
                                  nn.Sequential(Block(64), Block(64))])
        self.head = nn.Conv2d(32, 9 + COLORS + OTHERS, 1)
        nn.init.constant_(self.head.bias, 0)
        with torch.no_grad():
            self.head.bias[0] = self.head.bias[8 + COLORS] = -4

    def forward(self, x):
        x = self.stem(x - 0.45)
        levels = []
        for down in self.down:
            x = down(x)
            levels.append(x)
        for i in (2, 1, 0):
            x = levels[i] + F.interpolate(self.up[i](x), scale_factor=2, mode="nearest")
            x = self.mix[i](x)
        return self.head(x)


def load(folder, known=()):
    """Number -> picture and its marks, of all that are not known yet."""
    marks = collections.defaultdict(list)
    for name in glob.glob(f"{folder}/*.txt"):
        with open(name, encoding="utf-8") as lines:
            for line in lines:
                part = line.split()
                if len(part) != 11:  # still being written
                    continue
                marks[int(part[0])].append([float(v) for v in part[1:]])
    pictures = {}
    for name in glob.glob(f"{folder}/*.png"):
        number = int(os.path.basename(name)[:-4])
        picture = cv2.imread(name) if number in marks and number not in known else None
        if picture is None:  # still being written, too
            continue
        pictures[number] = (np.ascontiguousarray(picture[:, :, ::-1]),
                            np.array(marks[number], np.float32))
    return pictures


def affine(quad):
    """(log edge, two of the shape, two of the turn): the square behind a nearly affine quad."""
    u = ((quad[1] - quad[0]) + (quad[2] - quad[3])) / 2
    v = ((quad[3] - quad[0]) + (quad[2] - quad[1])) / 2
    m = np.stack([u, v], 1)
    s = m @ m.T
    edge = math.sqrt(max(1e-6, abs(np.linalg.det(m))))
    values, vectors = np.linalg.eigh(s)
    root = vectors @ np.diag(1 / np.sqrt(np.maximum(values, 1e-9))) @ vectors.T
    turn = root @ m
    phi = math.atan2(turn[1, 0], turn[0, 0])
    trace = s[0, 0] + s[1, 1]
    return [math.log(edge / 32), (s[0, 0] - s[1, 1]) / trace, 2 * s[0, 1] / trace,
            math.cos(4 * phi), math.sin(4 * phi)]


def recolored(rng, value):
    """Other exposure, white balance, saturation and haze; colors keep their names."""
    if rng.random() < 0.8:
        value = value ** math.exp(rng.uniform(-0.4, 0.4)) * rng.uniform(0.8, 1.2)
        value = value * rng.uniform(0.91, 1.09, 3).astype(np.float32)
    if rng.random() < 0.4:
        grey = value @ np.array([0.3, 0.59, 0.11], np.float32)
        value = grey[:, :, None] + rng.uniform(0.65, 1.35) * (value - grey[:, :, None])
    if rng.random() < 0.15:
        share = rng.uniform(0, 0.35)
        value = (1 - share) * value + share * rng.uniform(0.2, 0.9, 3)
    return np.clip(value, 0, 1).astype(np.float32)


def shaded(rng, value):
    """With a shadow or a patch of light that has a straight or a round edge."""
    mask = np.zeros((SIDE, SIDE), np.float32)
    if rng.random() < 0.5:
        cv2.fillConvexPoly(mask, cv2.convexHull(rng.integers(-80, SIDE + 80, (5, 2), np.int32)), 1)
    else:
        cv2.circle(mask, tuple(int(v) for v in rng.integers(0, SIDE, 2)),
                   int(rng.uniform(20, 160)), 1, -1)
    mask = cv2.GaussianBlur(mask, (0, 0), math.exp(rng.uniform(0, 4)))
    return value * (1 + rng.uniform(-0.55, 0.5) * mask)[:, :, None]


def degraded(rng, value):
    """As a lens out of focus, a noisy sensor and a camera's processing leave it."""
    if rng.random() < 0.3:
        small = rng.uniform(0.4, 0.9)
        value = cv2.resize(cv2.resize(value, None, fx=small, fy=small,
                                      interpolation=cv2.INTER_AREA), (SIDE, SIDE))
    elif rng.random() < 0.15:
        value = cv2.GaussianBlur(value, (0, 0), rng.uniform(0.4, 1.6))
    elif rng.random() < 0.1:  # moved
        size = int(rng.integers(2, 8))
        line = np.zeros((size, size), np.float32)
        ends = rng.integers(0, size, 4)
        cv2.line(line, (int(ends[0]), int(ends[1])), (int(ends[2]), int(ends[3])), 1)
        value = cv2.filter2D(value, -1, line / line.sum())
    if rng.random() < 0.4:
        noise = rng.normal(0, rng.uniform(0.003, 0.035), value.shape).astype(np.float32)
        if rng.random() < 0.5:  # in blots, as from a camera in the dark
            noise = 2 * cv2.GaussianBlur(noise, (0, 0), rng.uniform(0.5, 1.5))
        value = value + noise
    if rng.random() < 0.3:
        value = value + rng.uniform(0.2, 1) * (value - cv2.GaussianBlur(value, (0, 0), 1.2))
    value = np.clip(value, 0, 1)
    if rng.random() < 0.6:
        _, data = cv2.imencode(".jpg", (value[:, :, ::-1] * 255).astype(np.uint8),
                               [cv2.IMWRITE_JPEG_QUALITY, int(rng.uniform(20, 95))])
        value = cv2.imdecode(data, 1)[:, :, ::-1].astype(np.float32) / 255
    return value


def covered(rng, value, other, quads, marks):
    """Things in front of the picture: strips and shapes, in one color or with another picture."""
    mask = np.zeros((SIDE, SIDE), np.uint8)
    for _ in range(rng.integers(1, 4)):
        kind = rng.integers(3)
        at = rng.integers(0, SIDE, 2)
        if kind == 0:
            cv2.line(mask, tuple(map(int, at)), tuple(map(int, rng.integers(-80, SIDE + 80, 2))), 1,
                     int(rng.uniform(3, 40)))
        elif kind == 1:
            points = at + rng.integers(-60, 61, (4, 2))
            cv2.fillConvexPoly(mask, cv2.convexHull(points.astype(np.int32)), 1)
        else:
            cv2.ellipse(mask, tuple(map(int, at)), tuple(map(int, rng.integers(4, 50, 2))),
                        float(rng.uniform(0, 180)), 0, 360, 1, -1)
    front = rng.uniform(0, 1, 3).astype(np.float32)
    if rng.random() < 0.4 and min(other.shape[:2]) >= SIDE:
        y = rng.integers(other.shape[0] - SIDE + 1)
        x = rng.integers(other.shape[1] - SIDE + 1)
        front = other[y:y + SIDE, x:x + SIDE].astype(np.float32) / 255
        front = cv2.GaussianBlur(front, (0, 0), 6)  # no cube is left in it
    soft = cv2.GaussianBlur(mask.astype(np.float32), (0, 0), rng.uniform(0.4, 1))[:, :, None]
    value = np.clip((1 - soft) * value + soft * front, 0, 1)
    marks = marks.copy()
    for quad, mark in zip(quads, marks):
        top = np.zeros((SIDE, SIDE), np.uint8)
        cv2.fillConvexPoly(top, np.round(quad).astype(np.int32), 1)
        area = int(top.sum())
        if area:
            mark[1] *= 1 - float((top & mask).sum()) / area
    return value, marks


def shows_color(value, quad):
    """Whether the middle of a top is not burnt out to white."""
    middle = quad.mean(0)
    reach = 0.25 * np.linalg.norm(quad[2] - quad[0]) / math.sqrt(2)
    x0, y0 = np.maximum(0, middle - reach).astype(int)
    x1, y1 = np.maximum(0, middle + reach + 1).astype(int)
    part = value[y0:y1, x0:x1]
    return part.size == 0 or part.mean((0, 1)).min() < 0.9


def sample(rng, pictures):
    picture, marks = pictures[rng.integers(len(pictures))]
    height, width = picture.shape[:2]
    quads = marks[:, 2:].reshape(-1, 4, 2).copy() if len(marks) else np.zeros((0, 4, 2))
    # Scale, turn, mirror, and a part of it.
    scale = math.exp(rng.uniform(math.log(0.55), math.log(1.6)))
    across = quads[:, 2] - quads[:, 0]
    down = quads[:, 3] - quads[:, 1]
    areas = np.abs(across[:, 0] * down[:, 1] - across[:, 1] * down[:, 0])[marks[:, 0] < COLORS] / 2
    if len(areas):  # larger ones are found in a smaller picture
        scale = min(scale, max(0.5, 150 / math.sqrt(max(1, areas.max()))))
    if scale < 0.8:  # warpAffine takes no mean of what it shrinks
        small = cv2.resize(picture, None, fx=scale, fy=scale, interpolation=cv2.INTER_AREA)
        factor = np.array([small.shape[1] / width, small.shape[0] / height])
        picture, quads, scale = small, quads * factor, 1
        height, width = picture.shape[:2]
    turn = rng.choice([0, 90, 180, 270]) if rng.random() < 0.5 else 0
    turn = turn + (rng.uniform(-20, 20) if rng.random() < 0.5 else 0)
    m = cv2.getRotationMatrix2D((width / 2, height / 2), turn, scale)
    if rng.random() < 0.5:
        m = m @ np.array([[-1, 0, width], [0, 1, 0], [0, 0, 1]], float)
    room_x = max(0, width * scale - SIDE) / 2 + 20
    room_y = max(0, height * scale - SIDE) / 2 + 20
    m[0, 2] += SIDE / 2 - width / 2 + rng.uniform(-room_x, room_x)
    m[1, 2] += SIDE / 2 - height / 2 + rng.uniform(-room_y, room_y)
    out = cv2.warpAffine(picture, m, (SIDE, SIDE), flags=cv2.INTER_LINEAR,
                         borderMode=cv2.BORDER_REFLECT_101)
    # What the border mirrors is no picture: it is cut off below by the mask.
    inside = cv2.warpAffine(np.full((height, width), 255, np.uint8), m, (SIDE, SIDE))
    quads = quads @ m[:, :2].T + m[:, 2]
    # cv2 counts from the middle of the first pixel, the marks from its corner.
    quads = quads + (m[:, :2] @ np.array([-0.5, -0.5]) + 0.5)
    value = out.astype(np.float32) / 255
    if rng.random() < 0.2:
        other = pictures[rng.integers(len(pictures))][0]
        value, marks = covered(rng, value, other, quads, marks)
    if rng.random() < 0.25:
        value = shaded(rng, value)
    value = degraded(rng, recolored(rng, value)).astype(np.float32)
    marks = marks.copy()
    for quad, mark in zip(quads, marks):
        if mark[0] < COLORS - 1 and not shows_color(value, quad):
            mark[0] = UNNAMED
    return np.ascontiguousarray(value.transpose(2, 0, 1)), targets(quads, marks, inside)


def targets(quads, marks, inside):
    """Per cell: heat of tops and of others, its weight, then 2 offsets and 5 of affine(); color and
    kind, or -1.
    """
    cells = SIDE // STRIDE
    heat = np.zeros((2, cells, cells), np.float32)
    weight = (cv2.resize(inside, (cells, cells), interpolation=cv2.INTER_AREA) > 200)
    weight = weight.astype(np.float32)
    about = np.zeros((7, cells, cells), np.float32)
    kinds = np.full((2, cells, cells), -1, np.int64)
    ys, xs = np.mgrid[0:cells, 0:cells].astype(np.float32) + 0.5
    for quad, mark in sorted(zip(quads, marks), key=lambda pair: pair[1][1]):
        middle = quad.mean(0) / STRIDE
        if not (0 <= middle[0] < cells and 0 <= middle[1] < cells) or mark[1] < 0.05:
            continue
        form = affine(quad)
        edge = 32 * math.exp(form[0]) / STRIDE
        d2 = (xs - middle[0]) ** 2 + (ys - middle[1]) ** 2
        if mark[1] < SEEN or edge * STRIDE < 8:
            if mark[1] > UNSURE:
                weight[d2 < (0.5 * edge) ** 2] = 0
            continue
        x, y = int(middle[0]), int(middle[1])
        other = int(COLORS <= mark[0] < UNNAMED)
        sigma = min(8, max(0.55, 0.11 * edge))
        bell = np.exp(-d2 / (2 * sigma * sigma))
        bell[y, x] = 1
        heat[other] = np.maximum(heat[other], bell)
        near = max(0, min(2, int(0.2 * edge)))
        for v in range(max(0, y - near), min(cells, y + near + 1)):
            for u in range(max(0, x - near), min(cells, x + near + 1)):
                kinds[other, v, u] = -1 if mark[0] == UNNAMED else int(mark[0]) - other * COLORS
                if not other:
                    about[0:2, v, u] = middle - (u + 0.5, v + 0.5)
                    about[2:, v, u] = form
    return heat, weight, about, kinds


def loss_of_heat(out, heat, weight):
    p = torch.sigmoid(out).clamp(1e-5, 1 - 1e-5)
    is_top = (heat > 0.999).float()
    right = is_top * (1 - p) ** 2 * torch.log(p)
    wrong = (1 - is_top) * (1 - heat) ** 4 * p ** 2 * torch.log(1 - p)
    return -((right + wrong) * weight).sum() / (is_top * weight).sum().clamp(min=1)


def loss_of_kind(out, kinds):
    at = kinds >= 0
    if not at.any():
        return out.sum() * 0
    return F.cross_entropy(out.permute(0, 2, 3, 1)[at], kinds[at], label_smoothing=0.02)


def loss_of(out, heat, weight, about, kinds):
    at = kinds[:, 0] >= 0
    off = (out[:, 1:8] - about).abs()
    # Most tops are seen from nearly above: without a square near 0 the many small errors of their
    # shapes hide the few large ones, and every shape is taken for none.
    shape = off[:, 3:5]
    shape = torch.where(shape < 0.2, shape ** 2 / 0.4, shape - 0.1)
    off = torch.cat([off[:, :3], shape, off[:, 5:]], 1)
    off = (off * torch.tensor([1, 1, 2, 8, 8, 1, 1.0]).view(1, 7, 1, 1)).sum(1)
    other = 8 + COLORS
    return (loss_of_heat(out[:, 0], heat[:, 0], weight),
            off[at].sum() / at.sum().clamp(min=1),
            loss_of_kind(out[:, 8:other], kinds[:, 0]),
            0.2 * loss_of_heat(out[:, other], heat[:, 1], weight)
            + 0.2 * loss_of_kind(out[:, other + 1:], kinds[:, 1]))


def folded(layer, norm=None):
    """A layer's weights and offsets, with the norm that follows it taken in."""
    weight = layer.weight.detach()
    offset = layer.bias.detach() if layer.bias is not None else torch.zeros(len(weight))
    if norm is not None:
        factor = norm.weight.detach() / torch.sqrt(norm.running_var + norm.eps)
        weight = weight * factor.view(-1, 1, 1, 1)
        offset = (offset - norm.running_mean) * factor + norm.bias.detach()
    return weight, offset


def layers_of(net):
    """Every convolution and the norm that follows it (or None), in the order in which
    src/sinew/vision/cube_net.cc takes their weights.
    """
    def pairs(module):
        for first, second in zip([*module, None], [*module, None][1:]):
            if isinstance(first, nn.Conv2d):
                yield first, second if isinstance(second, nn.BatchNorm2d) else None
            elif isinstance(first, Block):
                yield from pairs(first.body)
            elif isinstance(first, nn.Sequential):
                yield from pairs(first)

    yield from pairs(net.stem)
    for down in net.down:
        yield from pairs(down)
    for i in (2, 1, 0):
        yield from pairs(net.up[i])
        yield from pairs(net.mix[i])
    yield net.head, None


def export(net, path):
    """All weights and offsets as half floats; the file is whole at any time."""
    parts = [part.numpy().astype("<f2").tobytes() for layer, norm in layers_of(net)
             for part in folded(layer, norm)]
    with open(path + ".part", "wb") as file:
        file.write(b"".join(parts))
    os.replace(path + ".part", path)


def begin_from(net, path):
    """The weights of export(), in a net that has no norms any more."""
    take_norms_in(net)
    numbers = torch.from_numpy(np.fromfile(path, "<f2").astype(np.float32))
    needed = sum(value.numel() for value in net.parameters())
    if needed != len(numbers):
        raise SystemExit(f"{path} holds {len(numbers)} weights, not {needed}")
    at = 0
    for layer, _ in layers_of(net):
        for value in (layer.weight, layer.bias):
            value.data.copy_(numbers[at:at + value.numel()].view(value.shape))
            at += value.numel()


class Samples(torch.utils.data.IterableDataset):
    """Samples without end of all pictures in a folder, also of those that come later."""

    def __init__(self, folder, seed):
        self.folder = folder
        self.rng = np.random.default_rng(seed)

    def __iter__(self):
        cv2.setNumThreads(1)
        found = {}
        while True:
            found.update(load(self.folder, found))
            pictures = list(found.values())
            for _ in range(5000):
                yield sample(self.rng, pictures)


class Training:
    """A net, its optimizer, and the mean of its weights over the last steps: that is what is kept."""

    def __init__(self, net, rate):
        self.net = net
        self.mean = copy.deepcopy(net)
        self.rate = rate
        self.optimizer = torch.optim.AdamW(net.parameters(), lr=rate, weight_decay=1e-4)
        self.steps = 0
        self.losses = np.zeros(4)

    def step(self, batch, spent):
        # Up within the first percents, then down to nothing along half a cosine.
        rate = self.rate * min(1, spent / 0.03 + 0.02) * 0.5 * (1 + math.cos(math.pi * spent))
        for group in self.optimizer.param_groups:
            group["lr"] = rate
        x, marks = batch
        losses = loss_of(self.net(x.to(memory_format=torch.channels_last)), *marks)
        self.optimizer.zero_grad()
        sum(losses).backward()
        nn.utils.clip_grad_norm_(self.net.parameters(), 10)
        self.optimizer.step()
        self.steps += 1
        self.losses = 0.98 * self.losses + 0.02 * np.array([float(v.detach()) for v in losses])
        share = max(0.002, 1 / self.steps)
        with torch.no_grad():
            means, nows = self.mean.state_dict(), self.net.state_dict()
            for name, value in means.items():
                if value.is_floating_point():
                    value.lerp_(nows[name], share)

    def __str__(self):
        heat, shape, color, others = self.losses / (1 - 0.98 ** self.steps)
        return (f"step {self.steps}: heat {heat:.3f}, shape {shape:.3f}, color {color:.3f}, "
                f"others {others:.3f}")


def main():
    parser = argparse.ArgumentParser()
    parser.add_argument("pictures")
    parser.add_argument("out")
    parser.add_argument("--minutes", type=float, default=60)
    parser.add_argument("--begin")
    parser.add_argument("--threads", type=int, default=os.cpu_count())
    parser.add_argument("--rate", type=float, default=3e-3)
    args = parser.parse_args()
    # Its process begins before this one has threads.
    batches = iter(torch.utils.data.DataLoader(Samples(args.pictures, 1), 16, num_workers=1))
    batch = next(batches)
    torch.manual_seed(1)
    torch.set_num_threads(args.threads)
    net = CubeNet().to(memory_format=torch.channels_last)
    if args.begin:
        begin_from(net, args.begin)
    training = Training(net, args.rate)
    begin = saved = time.time()
    while (spent := (time.time() - begin) / 60 / args.minutes) < 1:
        training.step(batch, spent)
        batch = next(batches)
        if training.steps % 50 == 0:
            print(f"{spent * args.minutes:.1f} min, {training}", flush=True)
        if time.time() - saved > 180:
            export(training.mean, args.out)
            saved = time.time()
    export(training.mean, args.out)


if __name__ == "__main__":
    main()
