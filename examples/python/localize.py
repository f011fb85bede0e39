# SPDX-License-Identifier: Apache-2.0
"""Find the pose of an object from contacts of your own: points, with normals or without.

usage: localize.py [OBJECT] [--figure FILE]   (OBJECT: a built-in name or a mesh file in metres)
"""

import argparse

import numpy as np

import palpate

arguments = argparse.ArgumentParser()
arguments.add_argument("object", nargs="?", default="bracket")
arguments.add_argument("--figure", help="draw contacts and modes into this file, with matplotlib")
given = arguments.parse_args()
model = palpate.ObjectModel(palpate.load_known_object(given.object))

# Contacts come from your sensor. Here they are made up: 8 points of the surface at a true pose.
random = np.random.default_rng(7)
truth = np.eye(4)
truth[:3, :3] = np.array([[0.0, -1.0, 0.0], [1.0, 0.0, 0.0], [0.0, 0.0, 1.0]])
truth[:3, 3] = [0.4, -0.1, 0.2]
corners = model.object.mesh.vertices[model.object.mesh.triangles]  # of each triangle, (T, 3, 3)
areas = np.linalg.norm(np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]), axis=1)


def touch(count):
    """Points and normals anywhere on the surface, at the true pose, with the sensor's noise."""
    chosen = corners[random.choice(len(corners), count, p=areas / areas.sum())]
    places = np.einsum("ij,ijk->ik", random.dirichlet([1, 1, 1], count), chosen)
    surface = model.object.mesh.closest_points(places)
    points = surface.points @ truth[:3, :3].T + truth[:3, 3]
    normals = surface.normals @ truth[:3, :3].T
    return (points + 0.001 * random.standard_normal((count, 3)),
            normals + np.radians(5) * random.standard_normal((count, 3)))  # fmt: skip


points, normals = touch(8)

# What you know of your sensor's errors goes in with the contacts: m and rad, one number or one each.
contacts = palpate.Contacts(points, normals, point_sigma=0.001, normal_sigma=np.radians(5))
posterior = palpate.localize(model, contacts, seed=0)
print(posterior)
for mode in posterior.modes[:3]:  # several where the contacts leave several poses possible
    print(mode)

# The mode's pose is that of the object's centroid; T_frame_mesh moves the file's own coordinates.
rotation, translation = posterior.error(truth)
print(f"off the truth by {np.degrees(rotation):.1f} deg and {1e3 * translation:.1f} mm")

# A sensor without normals: leave them out. The posterior says that 8 points leave other poses
# possible; it takes more of them.
bare = palpate.localize(model, palpate.Contacts(points), seed=0)
print("8 points without normals:", bare)
more = palpate.localize(model, palpate.Contacts(touch(40)[0]), seed=0)
print("40 points without normals:", more)

# What the two posteriors look like: the object at its heaviest modes, and the contacts.
if given.figure:
    from matplotlib import pyplot

    mesh = model.object.mesh
    figure = pyplot.figure(figsize=(9, 4.5))
    for place, (title, found) in enumerate({"with normals": posterior, "points alone": bare}.items()):
        axes = figure.add_subplot(1, 2, place + 1, projection="3d")
        credible = [mode for mode in found.modes[:3] if mode.weight > 0.02]
        for mode, color in zip(credible, ("tab:blue", "tab:orange", "tab:green")):
            T = mode.T_frame_object
            x, y, z = 1e3 * (mesh.vertices @ T[:3, :3].T + T[:3, 3]).T
            axes.plot_trisurf(x, y, z, triangles=mesh.triangles, color=color, alpha=0.15 + 0.35 * mode.weight)
        axes.scatter(*(1e3 * points.T), color="black", s=12)
        if place == 0:
            axes.quiver(*(1e3 * points.T), *(15 * normals.T), color="black", linewidth=0.8)
        axes.set(title=f"{title}: {found.status}, probability {found.probability:.2f}",
                 xlabel="x, mm", ylabel="y, mm", zlabel="z, mm", aspect="equal")  # fmt: skip
    figure.savefig(given.figure, dpi=120)
