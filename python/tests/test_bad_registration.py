# SPDX-License-Identifier: Apache-2.0
"""Registration by whatever it is given: it refuses by name, or what it answers is finite."""

import pathlib
import tempfile
import unittest

import numpy as np
import palpate

NAN, INF = float("nan"), float("inf")
COUNT = 40


def rigid():
    T = np.eye(4)
    T[:3, :3] = [[0, -1, 0], [1, 0, 0], [0, 0, 1]]
    T[:3, 3] = [0.1, -0.05, 0.2]
    return T


def masked(values):
    return np.ma.masked_array(values, mask=np.eye(*np.shape(values), dtype=bool))


class BadRegistration(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        random = np.random.default_rng(4)
        cls.T = rigid()
        cls.source = random.uniform(-0.1, 0.1, (COUNT, 3))
        cls.target = cls.source @ cls.T[:3, :3].T + cls.T[:3, 3]
        cls.normals = random.standard_normal((COUNT, 3))
        cls.normals /= np.linalg.norm(cls.normals, axis=1, keepdims=True)
        cls.turned = cls.normals @ cls.T[:3, :3].T
        cls.cloud = palpate.PointCloud(cls.source, cls.normals)
        cls.moved = palpate.PointCloud(cls.target, cls.turned)

    def pairs(self, **changed):
        given = {"source": self.source, "target": self.target} | changed
        return palpate.register_correspondences(given.pop("source"), given.pop("target"), **given)

    def clouds(self, **changed):
        given = {"source": self.cloud, "target": self.moved, "noise_bound": 0.002, "voxel": 0.01}
        given |= changed
        return palpate.register_clouds(given.pop("source"), given.pop("target"), **given)

    def described(self, **changed):
        given = {"source": self.cloud, "source_features": self.source, "target": self.moved,
                 "target_features": self.source, "voxel": 0.01} | changed  # fmt: skip
        names = ("source", "source_features", "target", "target_features")
        return palpate.register_described(*[given.pop(name) for name in names], **given)

    def certified(self, **changed):
        given = {"T_target_source": self.T, "source": self.source, "target": self.target} | changed
        names = ("T_target_source", "source", "target")
        return palpate.certify(*[given.pop(name) for name in names], **given)

    def refuses(self, call, cases):
        for text, changed in cases:
            with self.subTest(text), self.assertRaisesRegex(ValueError, text):
                call(**changed)

    def test_pairs(self):
        some = self.source.copy()
        some[7, 1] = NAN
        self.refuses(
            self.pairs,
            [
                (r"source has shape \(40,\), not \(N, 3\)", {"source": self.source[:, 0]}),
                (r"target has shape \(40, 2\), not \(N, 3\)", {"target": self.target[:, :2]}),
                ("source point 7 is .*nan.*, not finite", {"source": some}),
                ("target point 7 is .*nan.*, not finite", {"target": some}),
                (r"source point 0 is .*, farther than 1e\+100 m", {"source": 1e300 + self.source}),
                ("40 source points (but|for) 39 target points", {"target": self.target[:39]}),
                ("source: complex128 is no real", {"source": self.source + 0j}),
                ("target: some values are masked", {"target": masked(self.target)}),
                ("source: could not convert string", {"source": "scan.ply"}),
                ("39 source normals for 40 points", {"source_normals": self.normals[:39]}),
                ("normal 0 is .*, not a unit vector", {"target_normals": 0 * self.normals}),
                ("normal 0 is .*nan.*, not a unit vector", {"target_normals": NAN * self.normals}),
                (r"weights has shape \(3,\), not \(\) or \(40,\)", {"weights": [1, 1, 1]}),
                ("weight 0 is -1, not a number >= 0", {"weights": -1}),
                ("weight 0 is nan, not a number >= 0", {"weights": NAN}),
                ("noise bound 0 m is not positive", {"noise_bound": 0}),
                ("noise bound nan m", {"noise_bound": NAN}),
                ("noise bound inf m", {"noise_bound": INF}),
                ("normal noise 91 deg is not within 0..90", {"normal_noise_deg": 91}),
                ("normal noise nan deg", {"normal_noise_deg": NAN}),
                ("'line' is neither 'point' nor 'plane'", {"primitive": "line"}),
                ("plane primitive needs target normals", {"primitive": "plane"}),
                ("0 tolerated false alarms", {"max_false_alarms": 0}),
                ("nan tolerated false alarms", {"max_false_alarms": NAN}),
                (r"initial has shape \(3, 3\), not \(4, 4\)", {"initial": np.eye(3)}),
                ("initial: .*rotation", {"initial": 2 * np.eye(4)}),
                ("initial: element 0 of a pose is nan", {"initial": NAN * np.eye(4)}),
                ("no rotation axis", {"rotation_axis": [0, 0, 0]}),
                ("no rotation axis", {"rotation_axis": [0, INF, 0]}),
                ("no rotation axis", {"rotation_axis": [0, 1e300, 0]}),
                (r"rotation_axis has shape \(2,\), not \(3,\)", {"rotation_axis": [0, 1]}),
                ("exclude one another", {"rotation_axis": [0, 0, 1], "translation_only": True}),
                ("0 instances", {"instances": 0}),
                ("-2 instances", {"instances": -2}),
            ],
        )

    def test_clouds(self):
        self.refuses(
            self.clouds,
            [
                ("noise bound 0 m", {"noise_bound": 0}),
                ("noise bound nan m", {"noise_bound": NAN}),
                ("voxel -1 m", {"voxel": -1}),
                ("voxel nan m", {"voxel": NAN}),
                ("'Plane' is neither 'point' nor 'plane'", {"primitive": "Plane"}),
                ("initial: .*rotation", {"initial": np.zeros((4, 4))}),
                ("no rotation axis", {"rotation_axis": [0, 0, 0]}),
                ("no rotation axis", {"rotation_axis": [1e200, 0, 1]}),
                ("exclude one another", {"rotation_axis": [0, 0, 1], "translation_only": True}),
                ("0 instances", {"instances": 0}),
                ("excludes instances", {"instances": 2, "estimate_scale": True}),
                ("-1 tolerated false alarms", {"max_false_alarms": -1}),
            ],
        )
        for odd in ({"seed": -1}, {"threads": 1.5}, {"nois_bound": 1}):
            with self.assertRaises(TypeError):
                self.clouds(**odd)
        for target in (None, "scan.ply", 7, palpate):
            with self.assertRaises((TypeError, ValueError)):
                self.clouds(target=target)

    def test_clouds_by_features(self):
        features = self.source.copy()
        features[3, 0] = NAN
        self.refuses(
            self.described,
            [
                ("39 features and 40 normals for 40 points", {"source_features": self.source[:39]}),
                (r"target_features has shape \(40,\)", {"target_features": self.source[:, 0]}),
                ("source_features: row 3 holds", {"source_features": features}),
                ("target_features: row 0 holds", {"target_features": 1e300 * self.source}),
                ("features .*3.*2", {"target_features": self.source[:, :2]}),
                ("voxel 0 m is not positive", {"voxel": 0}),
                ("voxel inf m is not positive", {"voxel": INF}),
                ("noise bound -1 m", {"noise_bound": -1}),
                ("no rotation axis", {"rotation_axis": [0, NAN, 0]}),
                ("exclude one another", {"rotation_axis": [0, 0, 1], "translation_only": True}),
            ],
        )

    def test_certificates(self):
        mirrored = np.diag([1.0, 1, -1, 1])
        self.refuses(
            self.certified,
            [
                (r"T_target_source has shape \(3, 4\)", {"T_target_source": self.T[:3]}),
                ("T_target_source: .*determinant", {"T_target_source": mirrored}),
                ("T_target_source: ", {"T_target_source": NAN * self.T}),
                ("40 source points (but|for) 39 target points", {"target": self.target[:39]}),
                ("source point 0 is .*inf", {"source": INF + self.source}),
                ("weight 0 is -1", {"weights": -1}),
                ("target normals", {"primitive": "plane"}),
                ("39 target normals for 40", {"target_normals": self.turned[:39], "primitive": "plane"}),
            ],
        )

    def test_files_of_clouds(self):
        with tempfile.TemporaryDirectory() as folder:
            for name, text in {"a.ply": "ply\nformat ascii 1.0\nelement vertex 9\nend_header\n",
                               "a.pcd": "", "a.xyz": "0 0\n", "a.obj": "v 0 0\n"}.items():  # fmt: skip
                file = pathlib.Path(folder) / name
                file.write_text(text)
                with self.assertRaisesRegex(ValueError, name):
                    palpate.load_cloud(file)
            with self.assertRaisesRegex(ValueError, "nothing.ply"):
                palpate.load_cloud(f"{folder}/nothing.ply")


if __name__ == "__main__":
    unittest.main()
