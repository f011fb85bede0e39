# SPDX-License-Identifier: Apache-2.0
"""What cannot be used is refused by an exception that names it; what numpy knows is taken."""

import copy
import pathlib
import pickle
import tempfile
import threading
import unittest

import numpy as np
import palpate
from box_contacts import box_points

NAN = float("nan")


class BadInput(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.box = palpate.load_known_object("box")
        cls.model = palpate.ObjectModel(cls.box)
        cls.points, cls.normals = box_points(18)
        cls.contacts = palpate.Contacts(cls.points, cls.normals)

    def refuses(self, cases):
        for text, call in cases:
            with self.assertRaisesRegex(ValueError, text):
                call()

    def test_contacts(self):
        one = [[0, 0, 0]]
        self.refuses(
            [
                (r"points has shape \(3,\), not \(N, 3\)", lambda: palpate.Contacts([0, 0, 1])),
                ("could not convert string", lambda: palpate.Contacts("abc")),
                ("contact 0: point is .nan", lambda: palpate.Contacts([[NAN, 0, 0]])),
                ("contact 0: force is .nan", lambda: palpate.Contacts(one, forces=[[NAN, 0, 0]])),
                ("normal 0 is .nan", lambda: palpate.Contacts(one, [[NAN, 0, 1]])),
                ("normals: 3 for 18", lambda: palpate.Contacts(self.points, self.normals[:3])),
                ("point_sigma is -1", lambda: palpate.Contacts(one, point_sigma=-1)),
                ("normal_sigma is 0", lambda: palpate.Contacts(one, normal_sigma=0)),
                ("points: complex128 is no real", lambda: palpate.Contacts(np.full((1, 3), 1j))),
                ("points: some values are masked",
                 lambda: palpate.Contacts(np.ma.masked_less([[0, -1, 0]], 0))),
                (r"points: datetime64\[s\] is no real",
                 lambda: palpate.Contacts(np.zeros((1, 3), "datetime64[s]"))),
                (r"shape \(2,\), not \(\) or \(1,\)",
                 lambda: palpate.Contacts(one, point_sigma=[1, 2])),
                ("points: <U3 is no real number", lambda: palpate.Contacts(np.full((1, 3), "0.1"))),
                ("point_sigma is nan", lambda: palpate.read_contacts("x.csv", point_sigma=NAN)),
                ("normal_sigma is -1", lambda: palpate.read_contacts("x.csv", normal_sigma=-1)),
            ]
        )  # fmt: skip

    def test_localization(self):
        def localize(**options):
            return lambda: palpate.localize(self.model, self.contacts, **options)

        self.refuses(
            [
                ("'best', not 'fast' or 'full'", localize(method="best")),
                ("modes must be within 1..1000, not 0", localize(modes=0)),
                ("proposals must be", localize(proposals=-5)),
                ("particles must be", localize(particles=0)),
                ("false_contact_share is nan", localize(false_contacts=NAN)),
                (r"shape \(1, 3\), not \(N, 4\)", localize(free_space=[[0, 0, 1]])),
                ("radius is -1", localize(free_space=[[0, 0, 1, -1]])),
                ("free sphere 0: a coordinate in m of 1e.20", localize(free_space=[[1e20] * 4])),
                ("free sphere 0: its radius in m of 1e.20",
                 localize(free_space=[[0, 0, 0, 1e20]])),
                ("surface_sigma in m of 1e.300", localize(surface_sigma=1e300)),
                ("contact 0: a coordinate in m of 1e.200",
                 lambda: palpate.localize(self.model, palpate.Contacts([[1e200, 0, 0]]))),
            ]
        )
        self.assertEqual(localize(free_space=[])().status, "certain")

    def test_what_is_known_beforehand(self):
        found = palpate.localize(self.model, self.contacts)
        some = np.ones((2, 2, 2))

        def table(**numbers):
            return lambda: palpate.TableSupport(np.eye(4), **numbers)

        def free(voxels):
            return lambda: palpate.free_space_of_voxels(voxels, 0.01)

        self.refuses(
            [
                ("floor is nan", lambda: palpate.prior_from(found, floor=NAN)),
                ("floor is 1", lambda: palpate.prior_from(found, floor=1)),
                ("half_width is -1, not >= 0", table(half_width=-1)),
                ("tilt_sigma is 0, not positive", table(tilt_sigma=0)),
                ("height_sigma is nan", table(height_sigma=NAN)),
                ("edge_sigma is 1e.300", table(edge_sigma=1e300)),
                ("free holds float64, not bool", free(some * NAN)),
                ("free: some values are masked",
                 free(np.ma.masked_array(some.astype(bool), mask=some))),
            ]
        )  # fmt: skip

    def test_sensors(self):
        depth, tip = np.zeros((32, 32)), {"a": [0, 0, 0], "b": [0, 0, 0.02], "radius": 0.008}

        def taxels(**options):
            return lambda: palpate.contacts_of_taxels([[0] * 3], [[0, 0, 1]], [1], **options)

        self.refuses(
            [
                ("height map: min_depth.* inf, ",
                 lambda: palpate.contacts_of_height_map(depth, 5e-5, min_depth=np.inf)),
                ("height map: .*not finite and positive",
                 lambda: palpate.contacts_of_height_map(depth, 5e-5, slope_sigma=0)),
                ("taxels: min_force.* are inf", taxels(min_force=np.inf)),
                ("wrench: .* and inf, not all positive and finite",
                 lambda: palpate.contact_of_wrench([0] * 3, [0] * 3, **tip, moment_sigma=np.inf)),
                ("contact 0: its point or force is not finite",
                 lambda: palpate.NormalEstimator().update(0, [[NAN, 0, 0]], [[0, 0, 1]])),
                ("time is inf", lambda: palpate.NormalEstimator().update(np.inf, [], [])),
            ]
        )  # fmt: skip

    def test_misspelt_arguments_are_named(self):
        for call in (lambda: palpate.localize(self.model, self.contacts, sed=1),
                     lambda: palpate.Contacts(point=self.points)):  # fmt: skip
            with self.assertRaises(TypeError):
                call()

    def test_what_is_no_model_is_shown(self):
        for other in ("box", self.box):
            with self.assertRaisesRegex(TypeError, r"model is .*box.*, not an ObjectModel"):
                palpate.localize(other, self.contacts)

    def test_touches(self):
        def predict(radius):
            touch = palpate.TouchAction([0.2, 0, 0], [-1, 0, 0])
            return palpate.predict_touch(self.model, np.eye(4), touch, tip_radius=radius)

        self.refuses(
            [
                ("no direction", lambda: palpate.TouchAction([0.2, 0, 0], [0, 0, 0])),
                ("start is not finite", lambda: palpate.TouchAction([NAN, 0, 0], [1, 0, 0])),
                ("reach is -1", lambda: palpate.TouchAction([0] * 3, [1, 0, 0], reach=-1)),
                ("seconds is 0", lambda: palpate.TouchAction([0] * 3, [1, 0, 0], seconds=0)),
                ("tip_radius is nan", lambda: predict(NAN)),
            ]
        )

    def test_meshes_and_masses(self):
        corners = [[0, 0, 0], [1, 0, 0], [0, 1, 0]]
        mesh = self.box.mesh
        self.refuses(
            [
                ("no triangles", lambda: palpate.Mesh([], [])),
                ("names vertices 0, 1, 1.5 of 3", lambda: palpate.Mesh(corners, [[0, 1, 1.5]])),
                ("names vertices 0, 1, nan of 3", lambda: palpate.Mesh(corners, [[0, 1, NAN]])),
                ("vertex 0 .* not finite", lambda: palpate.Mesh([[NAN, 0, 0]] * 3, [[0, 1, 2]])),
                ("mass in kg of -1 is not in 0..1000", lambda: palpate.make_known_object("b", mesh, mass=-1)),
                ("mass in kg of nan", lambda: palpate.make_known_object("b", mesh, mass=NAN)),
                ("mass in kg of 1e\\+300", lambda: palpate.make_known_object("b", mesh, mass=1e300)),
            ]
        )

    def test_forces_for_other_points(self):
        with self.assertRaisesRegex(ValueError, "forces: 2 for 18 points"):
            palpate.NormalEstimator().update(0.0, self.points, self.normals[:2])

    def test_arrays_of_any_kind(self):
        wide = np.repeat(self.points, 2, axis=0)[::2]
        locked = self.points.copy()
        locked.setflags(write=False)
        for other in (np.asfortranarray(self.points), wide, self.points.astype(">f8"), locked,
                      self.points.tolist()):  # fmt: skip
            np.testing.assert_array_equal(palpate.Contacts(other).points, self.points)
        single = palpate.Contacts(self.points.astype(np.float32)).points
        self.assertEqual(single.dtype, np.float64)
        np.testing.assert_allclose(single, self.points, atol=1e-7)

    def test_tensors_of_other_libraries(self):
        """Their types are none of numpy's; numpy makes arrays of them all the same."""

        class Tensor:
            def __init__(self, values):
                self.values, self.dtype = values, "tensor.float32"

            def __array__(self, dtype=None, copy=None):
                return np.asarray(self.values, dtype)

        points = palpate.Contacts(Tensor(self.points)).points
        np.testing.assert_array_equal(points, self.points)
        self.refuses(
            [
                ("complex128 is no real", lambda: palpate.Contacts(Tensor(self.points + 1j))),
                ("points: ", lambda: palpate.Contacts(np)),  # which has a dtype, too
                ("points: ", lambda: palpate.Contacts(np.float64)),
            ]
        )

    def test_a_method_of_the_name_mask_hides_nothing(self):
        """As that of a pandas.Series, which has a dtype, too."""

        class Series:
            dtype = np.dtype(float)

            def __array__(self, dtype=None, copy=None):
                return np.full(18, 0.002, dtype)

            def mask(self, condition):
                raise AssertionError("not to be called")

        contacts = palpate.Contacts(self.points, point_sigma=Series())
        np.testing.assert_array_equal(contacts.point_sigma, np.full(18, 0.002))

    def test_lists_are_looked_into(self):
        row = np.ma.masked_array([1.0, 2, 3], mask=[0, 1, 0])
        self.refuses(
            [
                ("points: <U3 is no real number", lambda: palpate.Contacts([["0.1"] * 3])),
                (r"points: datetime64\[D\] is no real",
                 lambda: palpate.Contacts([[np.datetime64("2020-01-01")] * 3])),
                ("points: some values are masked", lambda: palpate.Contacts([row])),
                ("points: some values are masked", lambda: palpate.Contacts(([1, 2, 3], row))),
            ]
        )  # fmt: skip
        self.assertEqual(len(palpate.Contacts([np.ma.masked_array([1.0, 2, 3])])), 1)

    def test_errors_in_other_units(self):
        one = [[0, 0, 0]]
        self.refuses(
            [
                ("contact 0: point_sigma is 1 m, more than 0.1; is it in mm?",
                 lambda: palpate.Contacts(one, point_sigma=1)),
                ("contact 0: normal_sigma is 10 rad, more than pi/2; is it in deg?",
                 lambda: palpate.Contacts(one, [[0, 0, 1]], normal_sigma=10)),
                ("point_sigma is 1, not positive and at most 0.1",
                 lambda: palpate.read_contacts("x.csv", point_sigma=1)),
                ("normal_sigma is 10, not positive and at most 1.571",
                 lambda: palpate.read_contacts("x.csv", normal_sigma=10)),
            ]
        )  # fmt: skip
        palpate.Contacts(one, point_sigma=0.1, normal_sigma=np.pi / 2)

    def test_a_normal_of_any_length_is_one(self):
        for length in (1e-3, 5, 1e200):
            normals = palpate.Contacts([[0, 0, 0]], [[0, 0, length]]).normals
            np.testing.assert_array_equal(normals, [[0, 0, 1]])

    def test_an_object_s_file_may_be_a_path(self):
        missing = pathlib.Path("nothing") / "like_it.stl"
        with self.assertRaisesRegex(ValueError, "like_it.stl"):
            palpate.load_known_object(missing)


class Words(unittest.TestCase):
    def test_an_object_says_whether_it_is_symmetric(self):
        self.assertIn("4 symmetric orientations", repr(palpate.load_known_object("box")))
        self.assertIn("no symmetry, 5 stable", repr(palpate.load_known_object("bracket")))


class Copies(unittest.TestCase):
    def test_contacts_are_pickled_and_copied(self):
        points, normals = box_points(5)
        normals[2] = NAN
        some = palpate.Contacts(points, normals, np.ones((5, 3)), point_sigma=0.002)
        both = some + palpate.Contacts(points).candidates()
        for other in (pickle.loads(pickle.dumps(both)), copy.deepcopy(both)):
            for name in ("points", "normals", "forces", "point_sigma", "normal_sigma", "groups"):
                np.testing.assert_array_equal(getattr(other, name), getattr(both, name))

    def test_groups_of_joined_contacts_are_numbers_that_there_are(self):
        with tempfile.TemporaryDirectory() as folder:
            path = pathlib.Path(folder) / "last.csv"
            path.write_text("x,y,z,group\n0,0,0,2147483647\n")
            last = palpate.read_contacts(path)
        self.assertEqual(list((last + palpate.Contacts([[0, 0, 1]])).groups), [2147483647, -1])
        with self.assertRaisesRegex(ValueError, "would be group 2147483648"):
            last + palpate.Contacts([[0, 0, 1]]).candidates()

    def test_meshes_and_clouds_are_pickled(self):
        mesh = palpate.load_known_object("box").mesh
        other = pickle.loads(pickle.dumps(mesh))
        np.testing.assert_array_equal(other.vertices, mesh.vertices)
        np.testing.assert_array_equal(other.triangles, mesh.triangles)
        for cloud in (palpate.PointCloud(*box_points(9)), palpate.PointCloud(box_points(9)[0])):
            again = pickle.loads(pickle.dumps(cloud))
            np.testing.assert_array_equal(again.points, cloud.points)
            self.assertEqual(again.normals is None, cloud.normals is None)


class Threads(unittest.TestCase):
    def test_threads_may_share_a_tracker(self):
        model = palpate.ObjectModel(palpate.load_known_object("box"))
        contacts = palpate.Contacts(*box_points(18))
        tracker = palpate.Tracker(model, palpate.localize(model, contacts))

        def follow():
            for tick in range(20):
                tracker.update(0.01 * tick, contacts, np.zeros((18, 3)))

        threads = [threading.Thread(target=follow) for _ in range(4)]
        for thread in threads:
            thread.start()
        for thread in threads:
            thread.join()
        self.assertEqual(len(tracker.update(1.0, contacts, np.zeros((18, 3))).modes), 1)


if __name__ == "__main__":
    unittest.main()
