# SPDX-License-Identifier: Apache-2.0
"""The package as a user meets it: documented, typed, frozen, in numpy's terms."""

import inspect
import pathlib
import threading
import unittest

import numpy as np
import palpate
from box_contacts import BOX, box_points
from palpate import _core

try:
    from palpate import sim as _sim
except ImportError:
    _sim = None


class Documentation(unittest.TestCase):
    """Every public name says what it is, in the units it is in, and what it refuses."""

    def public(self):
        for name in palpate.__all__:
            yield name, getattr(palpate, name)

    def test_every_name_has_a_docstring(self):
        for name, value in self.public():
            self.assertTrue((inspect.getdoc(value) or "").strip(), name)
            if inspect.isclass(value):
                for member, attribute in vars(value).items():
                    if not member.startswith("_"):
                        self.assertTrue((attribute.__doc__ or "").strip(), f"{name}.{member}")

    def test_what_takes_arrays_says_shapes_and_errors(self):
        takers = [(name, value) for name, value in self.public() if callable(value)]
        takers += [(n, v.__init__) for n, v in takers if inspect.isclass(v)]
        documented = 0
        for name, value in takers:
            text = inspect.getdoc(value) or ""
            if "ArrayLike" in text or "ArrayLike" in str(getattr(value, "__nb_signature__", "")):
                self.assertRegex(text, r"\(\w+,? ?\w*\)", f"{name} says no shape")
                self.assertIn("Raises ValueError", text, name)
                documented += 1
        self.assertGreater(documented, 10)

    @unittest.skipUnless(_sim, "built without the simulator")
    def test_the_simulators_names_say_what_they_are_and_refuse(self):
        for name in set(_sim.__all__) - {"IDEAL"}:  # a dictionary
            value = getattr(_sim, name)
            self.assertTrue((inspect.getdoc(value) or "").strip(), name)
            members = vars(value).items() if inspect.isclass(value) else []
            for member, attribute in members:
                if not member.startswith("_"):
                    self.assertTrue((attribute.__doc__ or "").strip(), f"{name}.{member}")
                    self.says_errors(f"{name}.{member}", attribute)
            self.says_errors(name, value)
        stub = (pathlib.Path(palpate.__file__).parent / "_sim.pyi").read_text()
        for name in set(_sim.__all__) - {"IDEAL"}:
            self.assertRegex(stub, rf"(class|def) {name}\b")

    def says_errors(self, name, value):
        text = f"{inspect.getdoc(value) or ''} {getattr(value, '__nb_signature__', '')}"
        if "ArrayLike" in text or "options" in text:
            self.assertRegex(text, r"Raises \w+Error", name)

    def test_numbers_have_units(self):
        """What of a result holds numbers says in which unit, but for what has none."""
        unit = r"\b(m|mm|rad|deg|s|N|kg|kg m\^2|m\^2|m\^3|N m/rad|N m s/rad|m/s|nats?)\b"
        without = {
            "probability", "probabilities", "other", "weight", "weights", "residual_mass", "scale",
            "false_alarms", "false_inliers", "stretch", "direction", "normal", "R_table_object",
            "symmetries"}  # fmt: skip
        poses = {"T_frame_object", "T_world_base", "T_parent_link", "T_target_source", "residual_set"}
        several = {"joints", "resolution_deg"}  # a matrix of ratios; the name says it
        found = 0
        for name, value in self.public():
            for member, attribute in vars(value).items() if inspect.isclass(value) else []:
                signature = str(getattr(getattr(attribute, "fget", None), "__nb_signature__", ""))
                if "float" in signature and member not in without | poses | several:
                    self.assertRegex(attribute.__doc__ or "", unit, f"{name}.{member}")
                    found += 1
        self.assertGreater(found, 40)

    def test_stub_and_marker_are_there(self):
        folder = pathlib.Path(palpate.__file__).parent
        self.assertTrue((folder / "py.typed").exists())
        stub = (folder / "_core.pyi").read_text()
        for name in palpate.__all__:
            if name != "envs":
                self.assertRegex(stub, rf"(class|def) {name}\b|{name}:")
        self.assertIn("numpy.typing.ArrayLike", stub)

    def test_all_public_names_of_the_core_are_exported(self):
        core = {name for name in dir(_core) if not name.startswith("_")}
        self.assertEqual(core, set(palpate.__all__) - {"envs"})


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
