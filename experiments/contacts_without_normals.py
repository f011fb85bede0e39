# SPDX-License-Identifier: Apache-2.0
"""Poses from contacts with normals, without, and from groups of which one point touches.

Contacts lie anywhere on the surface, 1 mm and 10 deg off; the pose is any. Each group has three
points, up to 12 mm from the contact. Prints, for each number of contacts, how many poses are within
5 deg and 10 mm (95 % Wilson interval), and how many were stated with more than .9 and wrong.

usage: contacts_without_normals.py [--contacts N...] [TRIALS] [OBJECT...]
"""

import argparse

import numpy as np

import palpate

FIRST_SEED = 9000  # fresh ones for reports


def random_rotation(random):
    q = random.standard_normal(4)
    w, x, y, z = q / np.linalg.norm(q)
    return np.array([
        [1 - 2 * (y * y + z * z), 2 * (x * y - w * z), 2 * (x * z + w * y)],
        [2 * (x * y + w * z), 1 - 2 * (x * x + z * z), 2 * (y * z - w * x)],
        [2 * (x * z - w * y), 2 * (y * z + w * x), 1 - 2 * (x * x + y * y)],
    ])  # fmt: skip


def surface_points(mesh, count, random):
    """Points and normals drawn uniformly over the mesh's area."""
    corners = mesh.vertices[mesh.triangles]
    cross = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    area = np.linalg.norm(cross, axis=1)
    chosen = random.choice(len(area), count, p=area / area.sum())
    a, b = np.sort(random.uniform(size=(2, count)), axis=0)
    weights = np.stack([a, b - a, 1 - b], axis=1)
    return np.einsum("ij,ijk->ik", weights, corners[chosen]), cross[chosen] / area[chosen, None]


def tilted(normals, sigma, random):
    noise = sigma * random.standard_normal(normals.shape)
    return normals + noise - normals * np.sum(normals * noise, axis=1, keepdims=True)


def contacts_of(kind, points, normals, random):
    points = points + 0.001 * random.standard_normal(points.shape)
    if kind == "points":
        return palpate.Contacts(points)
    normals = tilted(normals, np.radians(10), random)
    if kind == "normals":
        return palpate.Contacts(points, normals)
    groups = palpate.Contacts(np.empty((0, 3)))
    for p, n in zip(points, normals):
        ways = random.standard_normal((2, 3))
        ways /= np.linalg.norm(ways, axis=1, keepdims=True)
        candidates = np.vstack([p, p + 0.006 * ways[0], p + 0.012 * ways[1]])
        groups = groups + palpate.Contacts(candidates, np.tile(n, (3, 1))).candidates()
    return groups


def wilson(successes, trials, z=1.96):
    p = successes / trials
    middle = (p + z * z / (2 * trials)) / (1 + z * z / trials)
    half = z * np.sqrt(p * (1 - p) / trials + z * z / (4 * trials**2)) / (1 + z * z / trials)
    return f"{p:.2f} [{max(0, middle - half):.2f}, {min(1, middle + half):.2f}]"


def main(trials, objects, counts):
    models = [palpate.ObjectModel(palpate.load_known_object(name)) for name in objects]
    print(f"{'contacts':>8} {'kind':>8}  within 5 deg and 10 mm   sure and wrong")
    for count in counts:
        for kind in ("normals", "points", "groups"):
            right = wrong = 0
            for model in models:
                for seed in range(FIRST_SEED, FIRST_SEED + trials):
                    random = np.random.default_rng(seed)
                    truth = np.eye(4)
                    truth[:3, :3], truth[:3, 3] = random_rotation(random), random.normal(0, 0.1, 3)
                    surface = surface_points(model.object.mesh, count, random)
                    contacts = contacts_of(kind, *surface, random).transformed(truth)
                    posterior = palpate.localize(model, contacts, seed=seed)
                    error = posterior.error(truth)
                    ok = error is not None and error[0] < np.radians(5) and error[1] < 0.010
                    right += ok
                    wrong += not ok and posterior.probability > 0.9
            total = trials * len(models)
            print(f"{count:>8} {kind:>8}  {wilson(right, total):<24} {wrong} of {total}", flush=True)


if __name__ == "__main__":
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("trials", nargs="?", type=int, default=30)
    parser.add_argument("objects", nargs="*", default=["mug", "bottle", "box", "bracket"])
    parser.add_argument("--contacts", nargs="+", type=int, default=[5, 10, 20, 40])
    given = parser.parse_args()
    main(given.trials, given.objects, given.contacts)
