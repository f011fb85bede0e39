# SPDX-License-Identifier: Apache-2.0
"""Each argument of each registration function in turn becomes many other things.

usage: hostile_registration.py [CALL..]

Every call is a process of its own with 25 s. What is no finite answer, ValueError or TypeError is
printed, and what takes more than 5 s; counts at the end.
"""

import multiprocessing
import sys
import time
import warnings

import numpy as np
import palpate

LIMIT, SLOW = 25, 5  # s
NAN, INF, COUNT = float("nan"), float("inf"), 40
RANDOM = np.random.default_rng(4)
T = np.eye(4)
T[:3, :3], T[:3, 3] = [[0, -1, 0], [1, 0, 0], [0, 0, 1]], [0.1, -0.05, 0.2]
SOURCE, SHAPE = RANDOM.uniform(-0.1, 0.1, (COUNT, 3)), RANDOM.uniform(-0.1, 0.1, (600, 3)) * [1, 0.7, 0.4]
NORMALS = RANDOM.standard_normal((COUNT, 3))
NORMALS /= np.linalg.norm(NORMALS, axis=1, keepdims=True)
TARGET, TURNED = SOURCE @ T[:3, :3].T + T[:3, 3], NORMALS @ T[:3, :3].T
CLOUD = palpate.PointCloud
PAIRS = {"source": SOURCE, "target": TARGET}
CLOUDS = {"source": CLOUD(SHAPE), "target": CLOUD(SHAPE @ T[:3, :3].T + T[:3, 3])}
LIMITS = {"rotation_axis": None, "translation_only": False}
SEARCH = {"initial": None, **LIMITS, "estimate_scale": False, "instances": 1, "max_false_alarms": 0.01,
          "best_effort": False, "seed": 0}  # fmt: skip
WITH_NORMALS = {"source_normals": NORMALS, "target_normals": TURNED}

# The function, how many of its arguments go by their places, and what they are when nothing is odd.
CALLS = {
    "pairs": (palpate.register_correspondences, 2, {
        **PAIRS, **WITH_NORMALS, "weights": np.ones(COUNT), "noise_bound": 0.004,
        "normal_noise_deg": 5.0, "primitive": "point", "bound_nodes": 100, **SEARCH}),
    "planes": (palpate.register_correspondences, 2, {
        **PAIRS, **WITH_NORMALS, "primitive": "plane", "initial": T, "instances": 2}),
    "axis": (palpate.register_correspondences, 2, {**PAIRS, "rotation_axis": [0, 0, 1.0]}),
    "scale": (palpate.register_correspondences, 2, {**PAIRS, "estimate_scale": True, "weights": 1.0}),
    "clouds": (palpate.register_clouds, 2, {
        **CLOUDS, "noise_bound": 0.002, "voxel": 0.01, "primitive": "plane", "threads": 1, **SEARCH}),
    "near": (palpate.register_clouds, 2, {
        **CLOUDS, "initial": T, "rotation_axis": [0, 0, 1], "instances": 2}),
    "described": (palpate.register_described, 4, {
        "source": CLOUD(SOURCE, NORMALS), "source_features": SOURCE, "target": CLOUD(TARGET, TURNED),
        "target_features": SOURCE, "voxel": 0.01, "noise_bound": 0.003, **LIMITS, "seed": 0,
        "threads": 1}),
    "certify": (palpate.certify, 3, {
        "T": T, **PAIRS, **WITH_NORMALS, "weights": np.ones(COUNT), "primitive": "plane"}),
    "cloud": (CLOUD, 2, {"points": SOURCE, "normals": NORMALS}),
}  # fmt: skip


class Odd:
    """Has an array and a number, and gives neither."""

    def __float__(self):
        raise RuntimeError("no number")

    def __array__(self, *arguments, **named):
        raise RuntimeError("no array")

    def __len__(self):
        return -1


NUMBERS = [None, True, False, 0, 1, -1, 2, 3, 7, 1000, 2**31 - 1, 2**31, -(2**31), 2**63, 2**64, -(2**63),
           10**400, 0.0, -0.0, 0.5, 1e-320, 1e-300, 1e-12, 1e12, 1e150, 1e300, -1e300, NAN, INF, -INF, 1j,
           np.float32(3), np.int8(-3), np.datetime64("2026-01-01")]  # fmt: skip
THINGS = ["", "plane", "point", "scan.ply", "1", b"1", bytearray(3), [], [[]], [[[]]], (), {}, {"a": 1}, set(),
          range(3), range(120), [1, 2], [1, 2, 3], [0, 0, 0], [0, 0, 1e-320], [1e200] * 3, [NAN] * 3,
          object(), Odd(), np, int, np.float64, len]  # fmt: skip
ARRAYS = [np.zeros(0), np.array(1.0), np.eye(3), np.eye(4), -np.eye(4), np.diag([1.0, 1, -1, 1]), 2 * np.eye(4),
          NAN * np.eye(4), 1e300 * np.eye(4), np.zeros((4, 4)), np.zeros((COUNT, 3)), np.ones((COUNT, 3)),
          np.full((COUNT, 3), 1e300), np.full((COUNT, 3), 1e-300), np.full((COUNT, 3), NAN),
          np.zeros((COUNT, 0)), np.zeros((0, 3)), np.zeros((0, 7)), *[np.zeros((n, 3)) for n in (1, 2, 3)],
          RANDOM.standard_normal((COUNT, 100)), np.zeros((COUNT, 3, 3))]  # fmt: skip
MANY = RANDOM.standard_normal((300, 3))
POINTS = [CLOUD(points) for points in (
    [[0, 0, 0]], np.zeros((0, 3)), np.zeros((50, 3)), np.outer(np.arange(50), [1, 0, 0]), 1e150 * MANY,
    1e-150 * MANY, MANY + 1e15)]  # fmt: skip


def changed(array):
    """The same array, spoilt or laid out in other ways."""
    a = np.asarray(array, float)
    yield from (factor * a for factor in (1e300, 1e150, 1e30, 1e-30, 1e-300, -1, 0, NAN, INF))
    yield from (a + 1e15, a.T, a[:-1], a[1:], a[::-1], np.concatenate([a, a]), a[..., None], a[None], a.ravel())
    yield from (a.astype(kind) for kind in ("f4", "f2", ">f8", int, object, str, complex, bool))
    yield from (a.tolist(), np.asfortranarray(a), np.repeat(a, 2, axis=0)[::2])
    yield np.ma.masked_array(a, mask=a > a.mean())
    yield from (RANDOM.permutation(a), RANDOM.standard_normal(a.shape), np.broadcast_to(a[:1], a.shape))
    for index, value in ((0, NAN), (-1, INF), (1, 1e308)):
        one = a.copy()
        one.flat[index] = value
        yield one


def values_for(normal):
    yield from (*NUMBERS, *THINGS, *ARRAYS, *POINTS, palpate.load_known_object("box"))
    if isinstance(normal, (np.ndarray, list)):
        yield from changed(normal)
    if isinstance(normal, CLOUD):
        for points in changed(normal.points):
            try:
                yield CLOUD(points)
            except (ValueError, TypeError):
                pass


def is_finite(answer):
    result = getattr(answer, "result", answer)
    pose = getattr(result, "T_target_source", None)
    numbers = [getattr(result, name, 0) for name in ("cost", "scale", "covariance")]
    return pose is None or all(np.isfinite(value).all() for value in (pose, *numbers))


def call(name, argument, value, answers):
    function, places, normal = CALLS[name]
    given = normal | {argument: value}
    placed = [given.pop(word) for word in list(given)[:places]]
    try:
        answer = function(*placed, **given)
        answers.put(("answered" if is_finite(answer) else "NOT FINITE", repr(answer)[:100]))
    except Exception as error:
        answers.put((type(error).__name__, str(error).split("\n")[0][:100]))


def outcome(name, argument, value):
    """What became of a call, in a word; what it said; and its seconds."""
    context = multiprocessing.get_context("fork")
    answers = context.SimpleQueue()
    process = context.Process(target=call, args=(name, argument, value, answers))
    begin = time.monotonic()
    process.start()
    process.join(LIMIT)
    seconds = time.monotonic() - begin
    if process.is_alive():
        process.kill()
        process.join()
        return "HUNG", "", seconds
    if process.exitcode:
        return f"ENDED BY {-process.exitcode}", "", seconds
    return *answers.get(), seconds


def main():
    counts = {}
    for name in sys.argv[1:] or CALLS:
        for argument, normal in CALLS[name][2].items():
            for value in values_for(normal):
                kind, text, seconds = outcome(name, argument, value)
                counts[kind] = counts.get(kind, 0) + 1
                if kind not in ("answered", "ValueError", "TypeError") or seconds > SLOW:
                    shown = " ".join(repr(value)[:60].split())
                    print(f"{name}, {argument} = {shown}: {kind} {text} ({seconds:.1f} s)", flush=True)
    print(f"{sum(counts.values())} calls: {counts}")


if __name__ == "__main__":
    warnings.simplefilter("ignore")
    main()
