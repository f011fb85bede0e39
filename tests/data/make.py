# SPDX-License-Identifier: Apache-2.0
"""Makes the made-up data that the tests read: what sensors, trackers and others' programs write,
with the faults that such files have. The same bytes every time; no number in it was measured.

usage: make.py [FOLDER]     (by default the folder of this script)
"""

import json
import math
import pathlib
import random
import sys

# Knuckles from the wrist and bones of each finger, m: not the lengths of the project's own hand.
FINGERS = (
    ((0.027, 0.0, 0.088), (0.039, 0.025, 0.024)),
    ((0.003, 0.0, 0.093), (0.042, 0.026, 0.024)),
    ((-0.019, 0.0, 0.085), (0.038, 0.025, 0.025)),
    ((-0.037, 0.0, 0.073), (0.030, 0.020, 0.021)),
)
THUMB = ((0.023, -0.011, 0.025), (0.041, 0.032, 0.028))
FRAMES, RATE = 122, 30  # of the hand's sequence; per second


def turned(axis, angle, v):
    """v turned about the axis 0, 1 or 2 by the right-hand rule."""
    b, c = (axis + 1) % 3, (axis + 2) % 3
    cos, sin = math.cos(angle), math.sin(angle)
    result = list(v)
    result[b], result[c] = cos * v[b] - sin * v[c], sin * v[b] + cos * v[c]
    return result


def added(a, b):
    return [x + y for x, y in zip(a, b)]


def finger(knuckle, bones, bend):
    """Four points of a finger whose joints bend about x, towards the palm at -y."""
    points, angle = [list(knuckle)], 0.0
    for bone, share in zip(bones, (1.0, 1.1, 0.6)):
        angle += share * bend
        points.append(added(points[-1], turned(0, angle, (0, 0, bone))))
    return points


def thumb(bend):
    base, bones = THUMB
    points, angle = [list(base)], 0.0
    for bone, share in zip(bones, (0.3, 0.5, 0.6)):
        angle += share * bend
        straight = turned(2, -0.8, turned(0, angle, (0, 0, bone)))
        points.append(added(points[-1], turned(1, 1.0, straight)))
    return points


def placed(point, time):
    """Into the camera's frame, in which the hand moves to the side and turns."""
    point = turned(0, 2.2, turned(2, 0.4 + 0.1 * time, point))
    return added(point, (0.05 + 0.03 * time, 0.10 - 0.01 * time, 1.1))


def hand_joints(rng):
    """21 keypoints a frame of a hand that closes; two gaps and one wrong joint, as trackers have."""
    names = [f"j{joint}_{axis}" for joint in range(21) for axis in "xyz"]
    rows = [",".join(["frame", *names])]
    for frame in range(FRAMES):
        time = frame / RATE
        bend = 0.15 + 0.45 * (1 - math.cos(math.pi * frame / (FRAMES - 1))) / 2
        points = [[0.0, 0.0, 0.0], *thumb(bend)]
        for knuckle, bones in FINGERS:
            points += finger(knuckle, bones, bend)
        points = [[x + rng.gauss(0, 4e-4) for x in placed(p, time)] for p in points]
        if frame in (40, 41):
            points[8] = [math.nan] * 3
        if frame == 70:
            points[12][1] += 0.2
        rows.append(",".join([str(frame), *(f"{x:.6f}" for p in points for x in p)]))
    return rows


def object_pose():
    """Poses 3x4 of the object; one frame more than the hand's, as from a second camera."""
    rows = ["frame," + ",".join(f"T{r}{c}" for r in range(3) for c in range(4))]
    for frame in range(FRAMES + 1):
        angle = 0.3 + 0.004 * frame
        columns = [turned(2, angle, turned(0, 1.2, axis)) for axis in ((1, 0, 0), (0, 1, 0), (0, 0, 1))]
        columns.append([0.08 + 0.001 * frame, -0.12, 0.81])
        cells = [f"{columns[c][r]:.9f}" for r in range(3) for c in range(4)]
        rows.append(",".join([str(frame), *cells]))
    return rows


def contacts(rng):
    """A log of four fingers that slide on a plate, 10 Hz: rows without a touch hold the force
    (0, -1, 0), and the first finger's readings are repeated, for it was read too fast."""
    rows = [",finger,t,px,py,pz,fx,fy,fz"]
    for number, name in enumerate(("FF", "MF", "RF", "TH")):
        last = None
        for tick in range(157):
            point = (0.09 + 0.02 * number + 2e-4 * tick, -0.33, 1.03 - 1e-4 * tick)
            force = [rng.gauss(0, 0.02), -0.4 + rng.gauss(0, 0.05), 0.1 + rng.gauss(0, 0.02)]
            if tick < 25:
                force = [0.0, -1.0, 0.0]
            elif name == "FF" and tick % 18 and last:
                point, force = last
            last = (point, force)
            cells = [f"{x:.9g}" for x in (*point, *force)]
            rows.append(",".join([str(len(rows) - 1), name, f"{tick / 10:.1f}", *cells]))
    return rows


def policy(rng):
    """A network of the shape and the keys in which the relocate task's policies are published."""
    sizes = (39, 32, 32, 30)
    made = {}
    for layer, (width, height) in enumerate(zip(sizes, sizes[1:])):
        made[f"W{layer}"] = [[round(rng.gauss(0, 0.1), 4) for _ in range(width)] for _ in range(height)]
        made[f"b{layer}"] = [0.0] * height
    for name, size in (("in", sizes[0]), ("out", sizes[-1])):
        made |= {f"{name}_shift": [0.0] * size, f"{name}_scale": [1.0] * size}
    return [json.dumps(made | {"log_std": [-1.0] * sizes[-1]})]


def main(folder):
    makers = {
        "hand_joints.csv": lambda: hand_joints(random.Random(1)),
        "object_pose.csv": object_pose,
        "contacts.csv": lambda: contacts(random.Random(2)),
        "policy.json": lambda: policy(random.Random(3)),
    }
    for name, maker in makers.items():
        (pathlib.Path(folder) / name).write_text("\n".join(maker()) + "\n")


if __name__ == "__main__":
    main(*(sys.argv[1:] or [pathlib.Path(__file__).parent]))
