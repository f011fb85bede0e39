# SPDX-License-Identifier: Apache-2.0
"""The package as a user meets it: typed, frozen, in numpy's terms."""

import pathlib
import signal
import subprocess
import sys
import tempfile
import threading
import time
import unittest

import numpy as np
import palpate
from box_contacts import BOX, box_points

class Geometry(unittest.TestCase):
    def test_closest_points(self):
        box = palpate.load_known_object("box")
        closest = box.mesh.closest_points([[0.1, 0, 0], [0, 0.2, 0]])
        np.testing.assert_allclose(closest.points, [[0.025, 0, 0], [0, 0.047, 0]], atol=1e-6)
        np.testing.assert_allclose(closest.normals, [[1, 0, 0], [0, 1, 0]], atol=1e-6)
        np.testing.assert_allclose(closest.distances, [0.075, 0.153], atol=1e-6)
        np.testing.assert_allclose(box.mesh.signed_distance([[0, 0, 0]]), [-0.025], atol=1e-6)

    def test_mesh_goes_in_and_out(self):
        box = palpate.load_known_object("box").mesh
        again = palpate.Mesh(box.vertices, box.triangles)
        np.testing.assert_array_equal(again.vertices, box.vertices)
        self.assertAlmostEqual(again.area, box.area)
        with self.assertRaisesRegex(ValueError, "vertices 0, 1, 99 of 8"):
            palpate.Mesh(box.vertices[:8], [[0, 1, 99]])

    def test_object(self):
        box = palpate.load_known_object("box")
        self.assertAlmostEqual(box.volume, np.prod(BOX), places=8)
        self.assertEqual(box.T_mesh_object.shape, (4, 4))
        self.assertTrue(box.T_mesh_object.flags.c_contiguous)
        self.assertEqual(len(box.symmetries), 4)
        self.assertAlmostEqual(sum(pose.probability for pose in box.stable_poses), 1)
        with self.assertRaisesRegex(ValueError, "nothing_like_it"):
            palpate.load_known_object("nothing_like_it")


    def test_a_mesh_is_saved_as_what_its_name_says(self):
        mesh = palpate.load_known_object("box").mesh
        with tempfile.TemporaryDirectory() as folder:
            for name in ("box.ply", "box.PLY", "box"):
                mesh.save(f"{folder}/{name}")
            saved = palpate.load_mesh(f"{folder}/box.ply").vertices
            np.testing.assert_array_equal(saved, mesh.vertices)
            with self.assertRaisesRegex(ValueError, "a mesh is saved as PLY, not as '.stl'"):
                mesh.save(f"{folder}/box.stl")
            self.assertFalse(pathlib.Path(folder, "box.stl").exists())


class Contacts(unittest.TestCase):
    def test_refuses_with_the_value(self):
        for arguments, words in (
            (([[0, 0]],), r"points has shape \(1, 2\), not \(N, 3\)"),
            (([[0, 0, np.inf]],), "contact 0: point is"),
            (([[0, 0, 0]], [[1, 0, 0], [0, 1, 0]]), "normals: 2 for 1 points"),
            (([[0, 0, 0]], None, None, -0.5), "contact 0: point_sigma is -0.5"),
            (([[0, 0, 0]], None, None, [1, 2]), r"point_sigma has shape \(2,\)"),
            (("far",), "points: could not convert string to float: 'far'"),
        ):
            with self.assertRaisesRegex(ValueError, words):
                palpate.Contacts(*arguments)

    def test_rows_of_nan_are_unknown_normals(self):
        contacts = palpate.Contacts(np.zeros((2, 3)), [[0, 0, 2], [np.nan] * 3])
        np.testing.assert_array_equal(contacts.normals, [[0, 0, 1], [np.nan] * 3])
        self.assertEqual(len(contacts), 2)

    def test_is_indexed_as_an_array(self):
        contacts = palpate.Contacts(np.arange(15).reshape(5, 3) / 100, point_sigma=np.arange(1, 6) / 1e3)
        for key in (2, -1, slice(1, 4), slice(None, None, -2), [4, 0], np.arange(5) % 2 == 0, []):
            part = contacts[key]
            np.testing.assert_array_equal(part.points, np.atleast_2d(contacts.points[key]).reshape(-1, 3))
            np.testing.assert_array_equal(part.point_sigma, np.ravel(contacts.point_sigma[key]))
        self.assertEqual([len(contact) for contact in contacts], [1] * 5)
        for key in (5, -6, [7], "x"):
            with self.assertRaises(IndexError):
                contacts[key]

    def test_height_map_of_a_ball(self):
        radius, press, pixel = 0.02, 0.001, 5e-5
        y, x = (np.indices((240, 320)).T - [119.5, 159.5]).T * pixel
        depth = np.maximum(0, press - radius + np.sqrt(radius**2 - x**2 - y**2))
        contacts = palpate.contacts_of_height_map(depth, pixel)
        arms = contacts.points - [0, 0, radius - press]
        np.testing.assert_allclose(np.linalg.norm(arms, axis=1), radius, atol=3e-5)
        self.assertGreater(np.min(np.sum(contacts.normals * arms, axis=1) / radius), 0.999)

    def test_taxels_and_wrench(self):
        skin = palpate.contacts_of_taxels([[0, 0, 0], [0, 0.01, 0]], [[1, 0, 0]] * 2, [0, 0.5])
        np.testing.assert_allclose(skin.points, [[0, 0.01, 0]])
        np.testing.assert_allclose(skin.forces, [[0.5, 0, 0]])
        p, f = np.array([0.008, 0, 0.01]), np.array([-2.0, 0.1, 0])
        tip = palpate.contact_of_wrench(f, np.cross(p, f), a=[0, 0, 0], b=[0, 0, 0.02], radius=0.008)
        np.testing.assert_allclose(tip.points, [p], atol=1e-9)
        np.testing.assert_allclose(tip.normals, [[-1, 0, 0]], atol=1e-6)
        none = palpate.contact_of_wrench([0, 0, 0.01], [0, 0, 0], a=[0] * 3, b=[0] * 3, radius=0.01)
        self.assertEqual(len(none), 0)

    def test_normal_estimator_follows_a_plane(self):
        estimator = palpate.NormalEstimator("s2")
        random = np.random.default_rng(4)
        for tick in range(100):
            point = [0.0005 * tick, 0.0003 * tick * np.sin(0.2 * tick), 0]
            force = [0.1, 0, -1] + 0.02 * random.standard_normal(3)
            estimate = estimator.update(0.01 * tick, [point], [force])
        self.assertEqual(estimate.status, "tracked")
        self.assertGreater(estimate.normal[2], np.cos(np.radians(15)))
        with self.assertRaisesRegex(ValueError, "no_such_estimator"):
            palpate.NormalEstimator("no_such_estimator")


class Results(unittest.TestCase):
    def test_everything_shows_itself(self):
        contacts = palpate.Contacts(*box_points(3))
        self.assertEqual(repr(contacts), "Contacts(3 points, 3 with normals)")
        touch = palpate.TouchAction([0.2, 0, 0], [-1, 0, 0])
        model = palpate.ObjectModel(palpate.load_known_object("box"))
        met = palpate.predict_touch(model, np.eye(4), touch)
        for shown in (touch, met, model, model.object, model.object.mesh):
            self.assertIn(type(shown).__name__, repr(shown))
        stub = (pathlib.Path(palpate.__file__).parent / "_core.pyi").read_text()
        self.assertNotIn("std::", stub)

    def test_results_are_frozen_and_show_themselves(self):
        model = palpate.ObjectModel(palpate.load_known_object("box"))
        posterior = palpate.localize(model, palpate.Contacts(*box_points(18)))
        with self.assertRaises(AttributeError):
            posterior.status = "certain"
        with self.assertRaises(AttributeError):
            posterior.best.weight = 1.0
        self.assertIn("certain", repr(posterior))
        self.assertRegex(repr(posterior.best), r"deg, translation .* mm")
        html = posterior._repr_html_()
        self.assertGreater(html.count("<circle"), 100)
        self.assertIn("within 5 deg and 10 mm", html)

    def test_a_posterior_outlives_the_model_that_it_came_from(self):
        model = palpate.ObjectModel(palpate.load_known_object("box"))
        posterior = palpate.localize(model, palpate.Contacts(*box_points(18)))
        del model
        self.assertIn("<circle", posterior._repr_html_())

    def test_a_program_ends_while_its_daemon_threads_search(self):
        """CPython would end them by unwinding their stacks, at which C++ aborts."""
        program = """
import threading, time
import palpate
from box_contacts import box_points

model = palpate.ObjectModel(palpate.load_known_object("box"))
contacts = palpate.Contacts(*box_points(18))

def search():
    while True:
        palpate.localize(model, contacts)

for _ in range(3):
    threading.Thread(target=search, daemon=True).start()
time.sleep(0.3)
"""
        ended = subprocess.run([sys.executable, "-c", program], capture_output=True, text=True,
                               timeout=300, cwd=pathlib.Path(__file__).parent)  # fmt: skip
        self.assertEqual((ended.returncode, ended.stderr), (0, ""))

    @unittest.skipUnless(hasattr(signal, "setitimer"), "no timer here")
    def test_ctrl_c_ends_a_choice_among_objects(self):
        """After the object at hand: not all of these are searched, which would take long."""
        model = palpate.ObjectModel(palpate.load_known_object("box"))
        contacts = palpate.Contacts(*box_points(4))
        start = time.monotonic()
        palpate.identify([model], contacts)
        one = time.monotonic() - start

        def interrupt(number, frame):
            raise KeyboardInterrupt

        before = signal.signal(signal.SIGALRM, interrupt)
        try:
            signal.setitimer(signal.ITIMER_REAL, 0.1)
            start = time.monotonic()
            with self.assertRaises(KeyboardInterrupt):
                palpate.identify([model] * 20, contacts)
        finally:
            signal.signal(signal.SIGALRM, before)
        self.assertLess(time.monotonic() - start, 0.1 + 10 * one)

    def test_threads_run_at_the_same_time(self):
        """The GIL is free while the search runs: another thread gets on."""
        model = palpate.ObjectModel(palpate.load_known_object("box"))
        contacts = palpate.Contacts(*box_points(4))
        done, counted = threading.Event(), 0

        def search():
            palpate.localize(model, contacts, method="full")
            done.set()

        thread = threading.Thread(target=search)
        thread.start()
        while not done.is_set():
            counted += 1
        thread.join()
        self.assertGreater(counted, 1000)


if __name__ == "__main__":
    unittest.main()
