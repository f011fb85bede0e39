# SPDX-License-Identifier: Apache-2.0
"""Registration by palpate and by its peers on the same problems, in one run.

usage: registration_peers.py PALPATE BUNNY_PLY [--runs N] [--shares [SHARE ...]]
       [--scans [SOURCE TARGET ...]]

Each peer runs with five settings and is reported at its best: most successes, then least error.
Times are of the registration alone: palpate's own, the peers' by the processor time of their calls,
so that a machine with other work to do does not count against them.
"""

import argparse
import importlib
import json
import os
import resource
import subprocess
import sys
import tempfile
import time

os.environ["OMP_NUM_THREADS"] = "1"

import clarabel
import kiss_matcher
import numpy as np
import open3d as o3d
import registration_scans
import scipy.sparse as sparse
import small_gicp
from scipy.spatial.transform import Rotation

SHARES = (0.1, 0.5, 0.9, 0.95, 0.98, 0.99)
PAIRS, SIGMA, NORMAL_DEG = 1000, 0.001, 5.0


def bunny_surface(path, seed, count):
    """Points and normals, uniform over the area, of the bunny scaled to 0.11 m and centred."""
    mesh = o3d.io.read_triangle_mesh(path)
    vertices = np.asarray(mesh.vertices)
    low, high = vertices.min(0), vertices.max(0)
    vertices = 0.11 / (high - low).max() * (vertices - (low + high) / 2)
    corners = vertices[np.asarray(mesh.triangles)]
    cross = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    double_area = np.linalg.norm(cross, axis=1)
    rng = np.random.default_rng(seed)
    chosen = rng.choice(len(corners), count, p=double_area / double_area.sum())
    a, b = np.sqrt(rng.random(count)), rng.random(count)
    weights = np.stack([1 - a, a * (1 - b), a * b], axis=1)
    points = np.einsum("nk,nkc->nc", weights, corners[chosen])
    return points, cross[chosen] / double_area[chosen, None], rng


def pose_of(rng, degrees=None):
    T = np.eye(4)
    if degrees is None:
        T[:3, :3] = Rotation.random(random_state=rng).as_matrix()
    else:
        axis = rng.standard_normal(3)
        axis *= np.deg2rad(degrees) / np.linalg.norm(axis)
        T[:3, :3] = Rotation.from_rotvec(axis).as_matrix()
    T[:3, 3] = 0.1 * rng.standard_normal(3) if degrees is None else 0.005 * rng.standard_normal(3)
    return T


def tilted(normals, rng):
    noisy = normals + np.deg2rad(NORMAL_DEG) * rng.standard_normal(normals.shape)
    return noisy / np.linalg.norm(noisy, axis=1, keepdims=True)


def problem_of(path, seed, share):
    points, normals, rng = bunny_surface(path, seed, PAIRS)
    T = pose_of(rng)
    target = points @ T[:3, :3].T + T[:3, 3] + SIGMA * rng.standard_normal(points.shape)
    target_normals = tilted(normals @ T[:3, :3].T, rng)
    wrong = rng.permutation(PAIRS)[: int(share * PAIRS)]
    other = rng.integers(0, PAIRS, len(wrong))
    clean, clean_normals = target.copy(), target_normals.copy()
    target[wrong], target_normals[wrong] = clean[other], clean_normals[other]
    return dict(s=points, t=target, sn=normals, tn=target_normals, truth=T)


def errors(T, truth):
    turn = Rotation.from_matrix(T[:3, :3].T @ truth[:3, :3]).magnitude()
    return np.rad2deg(turn), 1e3 * np.linalg.norm(T[:3, 3] - truth[:3, 3])


def palpate(program, problem, *options):
    with tempfile.NamedTemporaryFile("w", suffix=".csv") as file:
        file.write("sx,sy,sz,tx,ty,tz,snx,sny,snz,tnx,tny,tnz\n")
        rows = np.hstack([problem[k] for k in ("s", "t", "sn", "tn")])
        np.savetxt(file, rows, delimiter=",", fmt="%.17g")
        file.flush()
        run = subprocess.run([program, "register", "--correspondences", file.name, "--json",
                              "--noise-bound", str(4 * SIGMA), "--repeats", "5",
                              "--set", "robust_bound.max_nodes=0", *options],
                             capture_output=True, text=True, check=False)
    report = json.loads(run.stdout)
    T = report["T_target_source"]
    return None if T is None else np.array(T).reshape(4, 4), report["seconds"], report


def run_kiss(problem, bound):
    # The matcher clamps small bounds and works in single precision: millimetres.
    config = kiss_matcher.KISSMatcherConfig(1e3 * bound, enable_noise_bound_clamping=False)
    matcher = kiss_matcher.KISSMatcher(config)
    source, target = (list((1e3 * problem[k]).astype(np.float32)) for k in "st")
    start = time.process_time()
    solution = matcher.prune_and_solve(source, target)
    seconds = time.process_time() - start
    T = np.eye(4)
    T[:3, :3], T[:3, 3] = solution.rotation, 1e-3 * np.asarray(solution.translation)
    return T, seconds


def warm(run, problem, setting):
    """The shorter of two runs, as palpate's time is the shortest of five; slow ones run once."""
    first = run(problem, setting)
    if first[1] > 0.05:
        return first
    second = run(problem, setting)
    return first if first[1] < second[1] else second


def clouds_of(problem):
    clouds = []
    for points in (problem["s"], problem["t"]):
        cloud = o3d.geometry.PointCloud()
        cloud.points = o3d.utility.Vector3dVector(points)
        clouds.append(cloud)
    return clouds, o3d.utility.Vector2iVector(np.stack([np.arange(PAIRS)] * 2, axis=1))


def run_ransac(problem, setting):
    bound, iterations = setting
    (source, target), pairs = clouds_of(problem)
    registration = o3d.pipelines.registration
    o3d.utility.random.seed(0)
    start = time.process_time()
    result = registration.registration_ransac_based_on_correspondence(
        source, target, pairs, bound, registration.TransformationEstimationPointToPoint(False), 3,
        [registration.CorrespondenceCheckerBasedOnEdgeLength(0.9)],
        registration.RANSACConvergenceCriteria(iterations, 0.999))
    return result.transformation, time.process_time() - start


def run_fgr(problem, bound):
    (source, target), pairs = clouds_of(problem)
    registration = o3d.pipelines.registration
    option = registration.FastGlobalRegistrationOption(
        maximum_correspondence_distance=bound, iteration_number=64, tuple_test=True)
    start = time.process_time()
    result = registration.registration_fgr_based_on_correspondence(source, target, pairs, option)
    return result.transformation, time.process_time() - start


def run_teaser(problem, setting):
    bound, exact = setting
    params = teaserpp_python.RobustRegistrationSolver.Params()
    modes = teaserpp_python.InlierSelectionMode
    params.inlier_selection_mode = modes.PMC_EXACT if exact else modes.PMC_HEU
    params.max_clique_time_limit = 1  # s; without it dense graphs take minutes
    params.noise_bound, params.cbar2, params.estimate_scaling = bound, 1, False
    params.rotation_gnc_factor, params.rotation_max_iterations = 1.4, 100
    params.rotation_cost_threshold = 1e-12
    solver = teaserpp_python.RobustRegistrationSolver(params)
    start = time.process_time()
    solver.solve(problem["s"].T, problem["t"].T)
    seconds = time.process_time() - start
    solution = solver.getSolution()
    T = np.eye(4)
    T[:3, :3], T[:3, 3] = solution.rotation, solution.translation
    return T, seconds


def run_clipper(problem, bound):
    params = clipperpy.invariants.EuclideanDistanceParams()
    params.sigma, params.epsilon = bound / 2, bound
    matcher = clipperpy.CLIPPER(clipperpy.invariants.EuclideanDistance(params), clipperpy.Params())
    pairs = np.stack([np.arange(PAIRS)] * 2, axis=1).astype(np.int32)
    start = time.process_time()
    matcher.score_pairwise_consistency(problem["s"].T, problem["t"].T, pairs)
    matcher.solve()
    chosen = matcher.get_selected_associations()[:, 0]
    T = kabsch(problem["s"][chosen], problem["t"][chosen])
    return T, time.process_time() - start


def kabsch(s, t):
    U, _, V = np.linalg.svd((t - t.mean(0)).T @ (s - s.mean(0)))
    T = np.eye(4)
    T[:3, :3] = U @ np.diag([1, 1, np.linalg.det(U @ V)]) @ V
    T[:3, 3] = t.mean(0) - T[:3, :3] @ s.mean(0)
    return T


PEERS = {
    "kiss-matcher": (run_kiss, [0.001, 0.002, 0.003, 0.004, 0.006]),
    "open3d RANSAC": (run_ransac, [(0.002, 100000), (0.003, 100000), (0.004, 100000),
                                   (0.004, 200000), (0.006, 100000)]),
    "open3d FGR": (run_fgr, [0.001, 0.002, 0.004, 0.008, 0.016]),
}
# Neither has a wheel; they take part where their own build put the module on the path.
for module, name, run_peer, settings in (
        ("teaserpp_python", "TEASER++", run_teaser,
         [(0.002, False), (0.004, False), (0.006, False), (0.003, True), (0.004, True)]),
        ("clipperpy", "CLIPPER", run_clipper, [0.001, 0.002, 0.003, 0.004, 0.006])):
    try:
        globals()[module] = importlib.import_module(module)
        PEERS[name] = (run_peer, settings)
    except ImportError:
        print(f"{name} is not installed ({module}): it has no wheel on PyPI", file=sys.stderr)


def summary(results, problems):
    """Success rate, median degrees over successes and median seconds."""
    degrees, successes = [], 0
    for (T, _), problem in zip(results, problems):
        if T is None:
            continue
        deg, mm = errors(np.asarray(T), problem["truth"])
        if deg < 5 and mm < 10:
            successes += 1
            degrees.append(deg)
    return (successes / len(problems), float(np.median(degrees)) if degrees else float("inf"),
            float(np.median([seconds for _, seconds in results])))


def compare_correspondences(program, bunny, runs, shares):
    print(f"\n{PAIRS} correspondences, {runs} problems a row; time: median ms; "
          "ratio: the peer's time over palpate's\n")
    print("| outliers | program | best setting | success | median deg | ms | ratio |")
    print("|---|---|---|---|---|---|---|")
    for share in shares:
        problems = [problem_of(bunny, 9000 + k, share) for k in range(runs)]
        ours = {}
        for name, options in (("palpate", []), ("palpate, normals", ["--normal-noise-deg", "5"])):
            ours[name] = summary([palpate(program, p, *options)[:2] for p in problems], problems)
            success, degrees, seconds = ours[name]
            print(f"| {100 * share:g} % | {name} | default | {success:.2f} | {degrees:.3f} | "
                  f"{1e3 * seconds:.3f} | 1 |")
        reference = ours["palpate"][2]
        for name, (run, settings) in PEERS.items():
            best = max(((summary([warm(run, p, s) for p in problems], problems), s) for s in settings),
                       key=lambda scored: (scored[0][0], -scored[0][1]))
            (success, degrees, seconds), setting = best
            print(f"| {100 * share:g} % | {name} | {setting} | {success:.2f} | {degrees:.3f} | "
                  f"{1e3 * seconds:.3f} | {seconds / reference:.0f} |", flush=True)


def constraints():
    """The 21 homogeneous constraints r' A r = 0 of r = [columns of R; y], and e e'."""
    index = lambda row, column: 3 * column + row
    found = []

    def add(terms):
        A = np.zeros((10, 10))
        for i, j, value in terms:
            A[i, j] += value / 2
            A[j, i] += value / 2
        found.append(A)

    for i in range(3):
        for j in range(i, 3):
            last = [(9, 9, -1.0)] if i == j else []
            add([(index(k, i), index(k, j), 1.0) for k in range(3)] + last)
            add([(index(i, k), index(j, k), 1.0) for k in range(3)] + last)
    for i in range(3):
        j, k = (i + 1) % 3, (i + 2) % 3
        for m in range(3):
            n, o = (m + 1) % 3, (m + 2) % 3
            add([(index(n, i), index(o, j), 1.0), (index(o, i), index(n, j), -1.0),
                 (index(m, k), 9, -1.0)])
    e = np.zeros((10, 10))
    e[9, 9] = 1
    return found, e


def svec(M):
    """Upper triangle, column by column, off the diagonal times sqrt 2, as Clarabel orders it."""
    return np.array([M[i, j] * (1 if i == j else np.sqrt(2))
                     for j in range(10) for i in range(j + 1)])


def marginal_form(s, t, n):
    """10x10 form of thesis eq. 6.25 for planes, and its translation at the best."""
    s, t = s - s.mean(0), t - t.mean(0)
    rows = np.hstack([s[:, :1] * n, s[:, 1:2] * n, s[:, 2:] * n, -np.sum(n * t, 1)[:, None]])
    cross, tt = n.T @ rows, n.T @ n
    return rows.T @ rows - cross.T @ np.linalg.solve(tt, cross)


def solve_dual(Q, tolerance):
    matrices, e = constraints()
    columns = [-svec(A) for A in matrices] + [svec(e)]
    A = sparse.csc_matrix(np.stack(columns, axis=1))
    c = np.zeros(len(columns))
    c[-1] = -1
    settings = clarabel.DefaultSettings()
    settings.verbose = False
    settings.tol_gap_abs = settings.tol_gap_rel = settings.tol_feas = tolerance
    start = time.process_time()
    solver = clarabel.DefaultSolver(sparse.csc_matrix((len(c), len(c))), c, A, svec(Q),
                                    [clarabel.PSDTriangleConeT(10)], settings)
    solution = solver.solve()
    return -solution.obj_val, time.process_time() - start


def compare_dual(program, bunny, runs):
    print("\nLast solve and certificate (planes, the inliers of 50 % outliers), against a conic "
          "solver on the dual\n")
    print("| Clarabel's tolerance | Clarabel ms | palpate's last solve ms | ratio | "
          "largest difference of the optimum, in max(f*, tr/10) |")
    print("|---|---|---|---|---|")
    problems = [problem_of(bunny, 9000 + k, 0.5) for k in range(runs)]
    reports = [palpate(program, p, "--primitive", "plane")[2] for p in problems]
    ours = np.median([r["solve_seconds"] for r in reports])
    for tolerance in (1e-6, 1e-7, 1e-8, 1e-9, 1e-10):
        times, differences = [], []
        for problem, report in zip(problems, reports):
            inliers = report["inliers"]
            Q = marginal_form(problem["s"][inliers], problem["t"][inliers], problem["tn"][inliers])
            scale = np.trace(Q) / 10
            value, seconds = solve_dual(Q / scale, tolerance)
            times.append(seconds)
            differences.append(abs(scale * value - report["cost"]) / max(report["cost"], scale))
        print(f"| {tolerance:g} | {1e3 * np.median(times):.3f} | {1e3 * ours:.3f} | "
              f"{np.median(times) / ours:.0f} | {max(differences):.1e} |")


def compare_local(program, bunny, runs):
    """small_gicp is local: clouds 20 deg and some mm apart, without correspondences."""
    print("\nClouds of 5000 points, turned by 20 deg (palpate is not given that; its time is that of "
          "the whole program)\n")
    print("| program | setting | success | median deg | ms | ratio |")
    print("|---|---|---|---|---|---|")
    problems, files = [], []
    folder = tempfile.TemporaryDirectory()
    for k in range(runs):
        points, _, rng = bunny_surface(bunny, 9000 + k, 10000)
        T = pose_of(rng, 20)
        source = points[:5000] + 0.0003 * rng.standard_normal((5000, 3))
        target = points[5000:] @ T[:3, :3].T + T[:3, 3]
        problems.append(dict(s=source, t=target, truth=T))
        names = [os.path.join(folder.name, f"{k}{side}.xyz") for side in "st"]
        np.savetxt(names[0], source)
        np.savetxt(names[1], target)
        files.append(names)
    results = []
    for names in files:
        before = resource.getrusage(resource.RUSAGE_CHILDREN).ru_utime
        run = subprocess.run([program, "register", *names, "--primitive", "plane", "--json"],
                             capture_output=True, text=True, check=False)
        seconds = resource.getrusage(resource.RUSAGE_CHILDREN).ru_utime - before
        T = json.loads(run.stdout)["T_target_source"]
        results.append((None if T is None else np.array(T).reshape(4, 4), seconds))
    success, degrees, reference = summary(results, problems)
    print(f"| palpate | fpfh, plane | {success:.2f} | {degrees:.3f} | {1e3 * reference:.1f} | 1 |")
    scored = []
    for kind, reach in (("ICP", 0.03), ("PLANE_ICP", 0.03), ("GICP", 0.03), ("PLANE_ICP", 0.06),
                        ("GICP", 0.06)):
        results = []
        for p in problems:
            start = time.process_time()
            result = small_gicp.align(p["t"], p["s"], registration_type=kind,
                                      downsampling_resolution=0.002,
                                      max_correspondence_distance=reach, num_threads=1,
                                      max_iterations=100, translation_epsilon=1e-6,
                                      rotation_epsilon=1e-5)
            results.append((result.T_target_source, time.process_time() - start))
        scored.append((summary(results, problems), (kind, reach)))
    (success, degrees, seconds), setting = max(scored, key=lambda s: (s[0][0], -s[0][1]))
    print(f"| small_gicp | {setting} | {success:.2f} | {degrees:.3f} | {1e3 * seconds:.1f} | "
          f"{seconds / reference:.2g} |")


def main():
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("palpate")
    parser.add_argument("bunny")
    parser.add_argument("--runs", type=int, default=20)
    parser.add_argument("--shares", nargs="*", type=float,
                        help="of wrong pairs, compared alone; none: all but correspondences")
    parser.add_argument("--scans", nargs="*", metavar="FILE",
                        help="pairs of clouds, source and target, and a room of boxes: compare "
                             "these alone")
    arguments = parser.parse_args()
    if arguments.scans is not None:
        registration_scans.compare(arguments.palpate, arguments.scans)
        return
    shares = SHARES if arguments.shares is None else arguments.shares
    compare_correspondences(arguments.palpate, arguments.bunny, arguments.runs, shares)
    if arguments.shares:
        return
    compare_dual(arguments.palpate, arguments.bunny, arguments.runs)
    compare_local(arguments.palpate, arguments.bunny, arguments.runs)


if __name__ == "__main__":
    main()
