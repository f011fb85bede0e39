# SPDX-License-Identifier: Apache-2.0
"""Descriptions and kinematics of arms."""

import unittest

import numpy as np
import palpate


def six_axes(**others):
    """An arm like a UR10, as plain data."""
    offsets = [[0, 0, 0.18], [0, 0.15, 0], [0.6, -0.12, 0], [0.56, 0.1, 0], [0, 0.02, 0],
               [0, 0, -0.12]]  # fmt: skip
    frames = np.tile(np.eye(4), (6, 1, 1))
    frames[:, :3, 3] = offsets
    axes = np.eye(3)[[2, 1, 1, 1, 2, 1]]
    names = ["pan", "lift", "elbow", "wrist_1", "wrist_2", "wrist_3"]
    joints = [palpate.ArmJoint(name, (-6.28, 6.28)) for name in names]
    behind = np.eye(4)  # the flange's y axis is the hand's x axis
    behind[:3, :3] = [[0, -1, 0], [1, 0, 0], [0, 0, 1]]
    behind[:3, 3] = [0, 0.1, 0]
    stand = np.eye(4)
    stand[:3, 3] = [-0.6, -0.35, 0]
    return palpate.ArmDescription("six_axes", joints, frames, axes, T_world_stand=stand,
                                  T_flange_mount=behind, **others)  # fmt: skip


class ArmKinematics(unittest.TestCase):
    def setUp(self):
        self.arm = six_axes()
        self.joints = np.array([0.3, -1.2, 1.5, -0.4, 0.5, 0.2])

    def test_inverse_kinematics_undoes_the_mount_pose(self):
        T = self.arm.mount_pose(self.joints)
        found = self.arm.inverse_kinematics(T, self.joints + 0.1)
        np.testing.assert_allclose(self.arm.mount_pose(found), T, atol=3e-5)
        branches = self.arm.inverse_kinematics_branches(T)
        self.assertGreater(len(branches), 1)
        for branch in branches:
            np.testing.assert_allclose(self.arm.mount_pose(branch), T, atol=3e-5)
        T[:3, 3] = [5, 0, 0]
        self.assertIsNone(self.arm.inverse_kinematics(T, self.joints))

    def test_jacobian_is_the_derivative(self):
        J = self.arm.mount_jacobian(self.joints)
        step = 1e-6
        for i in range(6):
            moved = self.arm.mount_pose(self.joints + step * np.eye(6)[i])
            v = (moved - self.arm.mount_pose(self.joints))[:3, 3] / step
            np.testing.assert_allclose(J[3:, i], v, atol=1e-5)

    def test_the_follower_keeps_to_speeds(self):
        follower = palpate.ArmFollower(self.arm)
        T = self.arm.mount_pose(self.joints)
        before = follower.reset(T)
        np.testing.assert_allclose(self.arm.mount_pose(before), T, atol=3e-5)
        T[:3, 3] += [0, 0.1, 0.05]
        fastest = 0
        for _ in range(200):
            joints = follower.follow(T)
            fastest = max(fastest, np.max(np.abs(joints - before)) / 0.01)
            before = joints
        self.assertLessEqual(fastest, 2 + 1e-9)
        np.testing.assert_allclose(self.arm.mount_pose(before), T, atol=1e-4)
        np.testing.assert_array_equal(follower.joints, before)

    def test_a_way_out_of_reach_is_reported(self):
        follower = palpate.ArmFollower(self.arm)
        follower.reset(self.arm.mount_pose(self.joints))
        start = palpate.MountPosition.at(self.arm.mount_pose(self.joints))
        way = [palpate.MountPosition(start.xyz + [0.02 * i, 0, 0], start.ypr) for i in range(200)]
        checked = follower.check_path(way)
        self.assertIn("out of reach of the arm", checked.obstacle)
        self.assertTrue(0 < checked.feasible < 200)
        self.assertEqual(follower.check_path(way[:1]).obstacle, "")

    def test_surfaces_meet_the_table(self):
        self.assertEqual(six_axes(spheres=np.zeros((0, 5))).collision(self.joints), "")
        ball = six_axes(spheres=[[5, 0, 0, 0, 0.05]])
        self.assertEqual(ball.collision(self.joints), "")
        self.assertIn("wrist_3 would meet the table", ball.collision([0, 1.0, 0.5, 0, 0, 0]))

    def test_another_mounting(self):
        moved = np.eye(4)
        moved[:3, 3] = [0, 0, 0.5]
        other = self.arm.with_mounting(T_world_stand=moved @ self.arm.T_world_stand)
        np.testing.assert_allclose(other.mount_pose(self.joints),
                                   moved @ self.arm.mount_pose(self.joints))  # fmt: skip
        np.testing.assert_array_equal(other.T_flange_mount, self.arm.T_flange_mount)

    def test_bad_arms_are_named(self):
        joint, frame = palpate.ArmJoint("a", (-1, 1)), np.eye(4)[None]
        for bad, text in [
            (lambda: palpate.ArmJoint("a", (1, 1)), "range is 1 to 1 rad"),
            (lambda: palpate.ArmJoint("a", (0, 1), max_speed=0), "max_speed is 0"),
            (lambda: palpate.ArmDescription("x", [], [], []), "1 to 8 joints, not 0"),
            (lambda: palpate.ArmDescription("x", [joint] * 2, frame, np.eye(3)[:2]), "1 for 2"),
            (lambda: palpate.ArmDescription("x", [joint], frame, [[0, 0, 0]]), "axis 0"),
            (lambda: palpate.ArmDescription("x", [joint], frame, [[0, 0, 1]], spheres=[[0.0] * 4]),
             r"spheres has shape \(1, 4\)"),
            (lambda: palpate.ArmDescription("x", [joint], frame, [[0, 0, 1]], spheres=[[0.5, 0, 0, 0, 1]]),
             "sphere 0 is on link 0.5 of 1"),
            (lambda: self.arm.mount_pose([0] * 5), "5 values for 6 joints"),
            (lambda: self.arm.mount_pose([np.nan] * 6), "not finite"),
            (lambda: palpate.PathFeasibility(stretch=0), "stretch is 0"),
            (lambda: palpate.ArmFollower(self.arm).reset(9 * np.eye(4) - np.diag([8, 8, 8, 8])
                                                         + 9 * np.eye(4)[:, [1, 2, 0, 3]]), "T_world"),
        ]:  # fmt: skip
            with self.assertRaisesRegex(ValueError, text):
                bad()
        with self.assertRaisesRegex(RuntimeError, r"reset\(\)"):
            palpate.ArmFollower(self.arm).follow(np.eye(4))


if __name__ == "__main__":
    unittest.main()
