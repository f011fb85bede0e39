# SPDX-License-Identifier: Apache-2.0
"""Clouds without correspondences: palpate beside KISS-Matcher, refined by small_gicp.

Called by registration_peers.py --scans [SOURCE TARGET ...]. The room of boxes is always among the
pairs; real scans are given as files. Each pair is held against the truth, where that is known, and
palpate is also run from five random poses of the source.
"""

import contextlib
import json
import os
import subprocess
import tempfile
import time

import kiss_matcher
import numpy as np
import open3d as o3d
import small_gicp
from scipy.spatial.transform import Rotation

REPEATS, STARTS = 9, 5


def depth_scan(boxes, camera, look_at, rng):
    """Points that rays of a depth camera (640 x 480, 70 deg wide) meet, in the camera's frame.

    boxes: N x 2 x 3, m, low and high corners; the first one is the room, seen from inside.
    Noise along the ray: 1 mm and 1 mm/m^2. Returns points and T_world_camera.
    """
    forward = (look_at - camera) / np.linalg.norm(look_at - camera)
    right = np.cross(forward, [0, 0, 1])
    right /= np.linalg.norm(right)
    R = np.stack([right, np.cross(forward, right), forward], axis=1)
    focal = 320 / np.tan(np.deg2rad(35))
    u, v = np.meshgrid(np.arange(640) - 319.5, np.arange(480) - 239.5)
    rays = np.stack([u.ravel() / focal, v.ravel() / focal, np.ones(u.size)], axis=1)
    directions = rays @ R.T
    depth = np.full(len(rays), np.inf)
    with np.errstate(divide="ignore"):
        for k, (low, high) in enumerate(boxes):
            a, b = (low - camera) / directions, (high - camera) / directions
            enter, leave = np.minimum(a, b).max(1), np.maximum(a, b).min(1)
            hit = leave if k == 0 else np.where((enter < leave) & (enter > 0), enter, np.inf)
            depth = np.minimum(depth, hit)
    depth += (0.001 + 0.001 * depth**2) * rng.standard_normal(len(depth))
    T = np.eye(4)
    T[:3, :3], T[:3, 3] = R, camera
    return rays * depth[:, None], T


def room(seed=9000):
    """Two scans of a room with 25 boxes in it, some 25 deg apart, and T_target_source."""
    rng = np.random.default_rng(seed)
    boxes = [np.array([[0, 0, 0], [6, 5, 2.6]])]
    for _ in range(25):
        size, at = rng.uniform(0.1, 0.8, 3), rng.uniform([1.5, 0.2, 0], [5.6, 4.6, 0.5])
        at[2] *= rng.random() < 0.5
        boxes.append(np.stack([at, at + size]))
    look_at = np.array([4.5, 2.5, 0.6])
    scans = [depth_scan(boxes, np.array(c), look_at, rng)
             for c in ([0.6, 1.2, 1.5], [0.5, 2.8, 1.6])]
    (source, T_source), (target, T_target) = scans
    return source, target, np.linalg.inv(T_target) @ T_source


def write(path, points):
    cloud = o3d.geometry.PointCloud()
    cloud.points = o3d.utility.Vector3dVector(points)
    o3d.io.write_point_cloud(path, cloud)


def scan_by_kiss(points, cell, threads):
    """KISS-Matcher, then small_gicp, on clouds in units of 20 cells; pose and wall seconds."""
    # The matcher refuses cells of millimetres.
    unit = 20 * cell
    source, target = (p / unit for p in points)
    start = time.perf_counter()
    matcher = kiss_matcher.KISSMatcher(kiss_matcher.KISSMatcherConfig(cell / unit))
    found = matcher.estimate(source.astype(np.float32), target.astype(np.float32))
    guess = np.eye(4)
    guess[:3, :3], guess[:3, 3] = found.rotation, np.ravel(found.translation)
    refined = small_gicp.align(target, source, init_T_target_source=guess,
                               registration_type="GICP", downsampling_resolution=cell / unit / 2,
                               max_correspondence_distance=1.5 * cell / unit, num_threads=threads)
    T = np.array(refined.T_target_source)
    T[:3, 3] *= unit
    return T, time.perf_counter() - start


def scan_by_palpate(program, names, threads):
    # The bound on the inliers of any pose, up to 0.2 s, is no part of what the peers do.
    run = subprocess.run([program, "register", *names, "--json", "--threads", str(threads),
                          "--set", "robust_bound.max_nodes=0"],
                         capture_output=True, text=True, check=False)
    report = json.loads(run.stdout)
    T = report["T_target_source"]
    return None if T is None else np.array(T).reshape(4, 4), report


def hold_to(cores):
    """All threads of this process, and the programs it starts, run on these cores alone."""
    for thread in os.listdir("/proc/self/task"):
        with contextlib.suppress(ProcessLookupError):  # one that has just ended
            os.sched_setaffinity(int(thread), cores)


def apart(T, reference, size):
    """Turn, deg, and shift as a share of the size between two poses; text."""
    if T is None:
        return "no pose | "
    turn = Rotation.from_matrix(T[:3, :3].T @ reference[:3, :3]).magnitude()
    return f"{np.rad2deg(turn):.2f} | {np.linalg.norm(T[:3, 3] - reference[:3, 3]) / size:.4f}"


def compare_pair(program, label, names, truth):
    points = [np.asarray(o3d.io.read_point_cloud(n).points) for n in names]
    size = np.linalg.norm(points[1].max(0) - points[1].min(0))
    cores = sorted(os.sched_getaffinity(0))
    for threads in (2, 1):  # the matcher starts as many as there are cores at its first call
        hold_to(cores[:threads])
        runs = [scan_by_palpate(program, names, threads) for _ in range(REPEATS)]
        ours, report = runs[0]
        reference = ours if truth is None else truth
        seconds = min(r[1]["seconds"] for r in runs)
        print(f"| {label} | palpate | {threads} | {seconds:.3f} | {apart(ours, reference, size)} |")
        for factor in (0.5, 1, 2):
            cell = factor * report["voxel"]
            runs = [scan_by_kiss(points, cell, threads) for _ in range(REPEATS)]
            print(f"| {label} | kiss-matcher {cell:.3g} + small_gicp | {threads} | "
                  f"{min(r[1] for r in runs):.3f} | {apart(runs[0][0], reference, size)} |",
                  flush=True)
    hold_to(cores)
    return reference


def turned_starts(program, folder, label, names, reference):
    """palpate from random poses of the source: how many end within 1 deg and 1 % of the size."""
    source = np.asarray(o3d.io.read_point_cloud(names[0]).points)
    size = np.linalg.norm(source.max(0) - source.min(0))
    right = 0
    for seed in range(STARTS):
        T = np.eye(4)
        T[:3, :3] = Rotation.random(random_state=seed).as_matrix()
        file = os.path.join(folder, "turned.ply")
        write(file, source @ T[:3, :3].T)
        found, _ = scan_by_palpate(program, (file, names[1]), 1)
        if found is None:
            continue
        D = np.linalg.inv(reference) @ found @ T
        right += (Rotation.from_matrix(D[:3, :3]).magnitude() < np.deg2rad(1)
                  and np.linalg.norm(D[:3, 3]) < 0.01 * size)
    print(f"{label}: {right} of {STARTS} from random poses right")


def compare(program, files):
    """Pairs of files, and the room. The peers' cell is palpate's own, half and twice that."""
    print("\nScans without correspondences: wall seconds on as many cores as threads, the shortest "
          f"of {REPEATS}, files read before; difference to the truth (of the room) or to palpate's "
          "pose\n")
    print("| source | program | threads | s | deg | of the size |")
    print("|---|---|---|---|---|---|")
    with tempfile.TemporaryDirectory() as folder:
        source, target, truth = room()
        names = [os.path.join(folder, n) for n in ("room_source.ply", "room_target.ply")]
        write(names[0], source)
        write(names[1], target)
        pairs = [("room of boxes", names, truth)]
        pairs += [(a, (a, b), None) for a, b in zip(files[::2], files[1::2])]
        references = [compare_pair(program, *pair) for pair in pairs]
        print()
        for (label, names, _), reference in zip(pairs, references):
            turned_starts(program, folder, label, names, reference)
