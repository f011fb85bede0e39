# SPDX-License-Identifier: Apache-2.0
"""palpate ros2 against an independent node: estimator, simulated robot, and pick."""

import json
import math
import os
import random
import signal
import subprocess
import unittest

import cli
from cli import BAD_INPUT, DONE, QUICK, USAGE, CliTest, main

try:
    import ros2_stream
    import ros2_peer
    from ros2_loopback import LOOPBACK
    from ros2_peer import Peer, wait_until
except ImportError:
    ros2_peer = None

START = 1_700_000_000_000_000_000  # ns
TICK = 10_000_000  # ns


def position(pose):
    return [pose.position.x, pose.position.y, pose.position.z]


@unittest.skipUnless(ros2_peer, "requirements/ros2.txt is not installed; ./dev test tries to")
class Ros2(CliTest):
    def setUp(self):
        super().setUp()
        os.environ["CYCLONEDDS_URI"] = LOOPBACK
        self.domain = random.SystemRandom().randrange(1, 230)
        self.peer = Peer(self.domain)

    def start(self, *arguments):
        environment = dict(os.environ, PALPATE_CACHE=str(self.cache))
        program = subprocess.Popen(
            [cli.PROGRAM, "ros2", *arguments, "--domain", str(self.domain), "--json", "--quiet"],
            cwd=self.folder, env=environment, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True,
        )  # fmt: skip
        self.addCleanup(program.stdout.close)
        self.addCleanup(program.stderr.close)
        self.addCleanup(program.kill)
        return program

    def end(self, program, code=DONE):
        """The report of a program that is interrupted."""
        program.send_signal(signal.SIGINT)
        stdout, stderr = program.communicate(timeout=120)
        self.assertEqual(program.returncode, code, stderr)
        return json.loads(stdout)


class Estimator(Ros2):
    @classmethod
    def setUpClass(cls):
        """One pick, the end of which all tests send again."""
        cls.kept = CliTest("run_program")
        cls.kept.setUp()
        cls.addClassCleanup(cls.kept.doCleanups)
        cls.kept.run_json("pick", "--object", "box", "--seed", "7", "--out", "run", "--no-belief", *QUICK)
        cls.kept.run_json("export", "mcap", "run/recording.h5", "--out", "box.mcap")

    def setUp(self):
        super().setUp()
        self.stream = ros2_stream.HeldStream(self.kept.folder / "box.mcap")

    def begin(self, *more):
        program = self.start("estimate", "--object", "box", "--set", "first.proposals=10000",
                             "--set", "first.particles=200", *more)  # fmt: skip
        self.stream.advertise(self.peer)
        self.peer.listen("/palpate/estimate", ros2_peer.PoseWithCovarianceStamped)
        self.peer.listen("/palpate/modes", ros2_peer.PoseArray)
        self.assertTrue(wait_until(lambda: self.peer.is_heard() and self.peer.hears()), "no node")
        return program

    def send_until_estimated(self, now, least=300):
        """Sends at about 100 Hz, until there is an estimate. @return messages, poses, time"""
        sent, poses, modes = 0, [], []
        while sent < least or not modes:
            self.assertLess(sent, 20000, "no estimate")
            self.stream.send(self.peer, now)
            sent, now = sent + 1, now + TICK
            wait_until(lambda: False, 0.01)
            poses += self.peer.take("/palpate/estimate")
            modes += self.peer.take("/palpate/modes")
        return sent, poses, now

    def test_a_stream_gives_the_pose_and_nothing_is_lost(self):
        program = self.begin()
        sent, poses, now = self.send_until_estimated(START)
        for _ in range(2000):  # joint states alone, at about 1 kHz
            now += TICK // 10
            self.stream.send_joints(self.peer, now)
            wait_until(lambda: False, 0.001)
        wait_until(lambda: self.stream.acknowledged(self.peer))
        poses += self.peer.take("/palpate/estimate")
        report = self.end(program)
        self.assertEqual(report["received"]["joint_states"], sent + 2000)
        self.assertEqual(report["lost"], 0)
        self.assertEqual(report["received"]["malformed"], 0)
        self.assertEqual(report["received"]["out_of_order"], 0)
        self.assertGreaterEqual(report["estimates"], 1)
        self.assertGreater(len(poses), 0)
        truth = self.stream.estimated  # by the pick, from all that it had sensed
        for pose in poses:
            self.assertEqual(pose.header.frame_id, "world")
            self.assertTrue(ros2_peer.is_finite_pose(pose.pose.pose))
        # The contacts alone may leave several poses open, but none of them far from the hand.
        self.assertLess(math.dist(position(poses[-1].pose.pose), truth), 0.1)

    def test_raw_values_of_taxels_give_the_pose(self):
        self.stream.report_as_taxels(self.folder / "taxels.csv")
        program = self.begin("--taxel-layout", "taxels.csv")
        sent, poses, _ = self.send_until_estimated(START)
        report = self.end(program)
        arrays = sum(topic.startswith("/taxels/") for topic in self.stream.messages)
        self.assertGreaterEqual(arrays, 2)
        self.assertEqual(report["received"]["contacts"], arrays * sent)
        self.assertEqual(report["received"]["malformed"], 0)
        self.assertLess(math.dist(position(poses[-1].pose.pose), self.stream.estimated), 0.1)

    def test_wrenches_on_fingertips_give_the_pose(self):
        self.stream.report_as_wrenches()
        program = self.begin()
        sent, poses, _ = self.send_until_estimated(START)
        report = self.end(program)
        wrenches = sum(topic.startswith("/fingertip_wrenches/") for topic in self.stream.messages)
        self.assertGreaterEqual(wrenches, 2)
        self.assertEqual(report["received"]["contacts"], wrenches * sent)
        self.assertEqual(report["received"]["malformed"], 0)
        self.assertLess(math.dist(position(poses[-1].pose.pose), self.stream.estimated), 0.1)

    def test_all_that_it_publishes(self):
        kinds = {"/palpate/mode_weights": ros2_peer.Float64MultiArray, "/palpate/status": ros2_peer.String,
                 "/palpate/markers": ros2_peer.MarkerArray, "/tf": ros2_peer.TFMessage,
                 "/diagnostics": ros2_peer.DiagnosticArray}  # fmt: skip
        program = self.begin()
        for topic, kind in kinds.items():
            self.peer.listen(topic, kind)
        self.peer.listen("/palpate/object", ros2_peer.MarkerArray, latched=True)
        self.assertTrue(wait_until(self.peer.hears))
        received = {topic: [] for topic in [*self.peer.readers]}
        for i in range(20000):
            self.stream.send(self.peer, START + i * TICK)
            wait_until(lambda: False, 0.01)
            for topic, messages in received.items():
                messages += self.peer.take(topic)
            counts = [{value.key: int(value.value) for value in status.values}
                      for message in received["/diagnostics"] for status in message.status]  # fmt: skip
            heard = counts and counts[-1]["readings"] > 10  # the first ones may be older than the stream
            if heard and received["/palpate/markers"] and received["/palpate/status"]:
                break
        self.end(program)
        pose, modes = received["/palpate/estimate"][-1], received["/palpate/modes"][-1]
        self.assertEqual(len(received["/palpate/mode_weights"][-1].data), len(modes.poses))
        self.assertLessEqual(sum(received["/palpate/mode_weights"][-1].data), 1.001)
        self.assertIn(received["/palpate/status"][-1].data, ("certain", "ambiguous", "no_pose"))
        self.assertGreater(pose.pose.covariance[0], 0)
        kinds = {marker.ns for marker in received["/palpate/markers"][-1].markers}
        self.assertGreaterEqual(len(kinds), 2, kinds)
        mesh = received["/palpate/object"][0].markers[0]  # for who came after it was sent
        self.assertEqual((mesh.type, len(mesh.points) % 3), (11, 0))
        self.assertGreater(len(mesh.points), 30)
        frames = [t for message in received["/tf"] for t in message.transforms if t.child_frame_id == "palpate_object"]
        self.assertEqual(frames[-1].header.frame_id, "world")
        self.assertGreater(counts[-1]["readings"], 10)
        self.assertEqual(counts[-1]["malformed"], 0)

    def test_best_effort_senders_are_named_and_heard_if_asked(self):
        self.peer = Peer(self.domain, reliable=False)
        program = self.start("estimate", "--object", "box")
        self.peer.listen("/diagnostics", ros2_peer.DiagnosticArray)
        self.stream.advertise(self.peer)
        self.assertTrue(wait_until(self.peer.hears))
        said = []
        wait_until(lambda: said.extend(s.message for d in self.peer.take("/diagnostics") for s in d.status)
                   or any("/joint_states" in text for text in said))  # fmt: skip
        report = self.end(program)
        self.assertIn("/joint_states", said[-1])
        self.assertIn("/joint_states", report["refused"])
        self.assertEqual(report["received"]["readings"], 0)

        asked = self.start("estimate", "--object", "box", "--best-effort")
        self.assertTrue(wait_until(self.peer.is_heard))
        for i in range(50):
            self.stream.send(self.peer, START + i * TICK)
            wait_until(lambda: False, 0.01)
        report = self.end(asked)
        self.assertEqual(report["refused"], "")
        self.assertGreater(report["received"]["readings"], 0)

    def test_a_layout_of_taxels_that_cannot_be_is_refused(self):
        layout = self.folder / "taxels.csv"
        for text, word in (("finger,x,y,z\nTH,0,0,0\n", "nx"), ("x,y,z,nx,ny,nz\n0,0,0,0,0,1\n", "finger"),
                           ("finger,x,y,z,nx,ny,nz\nTH,0,0,0,0,0,0\n", "taxels.csv:2"),
                           ("finger,x,y,z,nx,ny,nz\nTAIL,0,0,0,0,0,1\n", "TAIL")):  # fmt: skip
            layout.write_text(text)
            self.assert_refused(BAD_INPUT, ["ros2", "estimate", "--object", "box", "--taxel-layout", "taxels.csv",
                                            "--domain", str(self.domain)], word)  # fmt: skip

    def test_faults_are_counted_and_the_stream_goes_on(self):
        program = self.begin()
        _, _, now = self.send_until_estimated(START, least=10)
        state = self.stream.joints(now)
        state.position = state.position[:-1]
        self.peer.write("/joint_states", state)
        state = self.stream.joints(now)
        state.position[0] = math.nan
        self.peer.write("/joint_states", state)
        self.stream.send_joints(self.peer, START)  # late
        cloud = self.stream.cloud("TH", now)
        cloud.data = cloud.data[:5]
        cloud.width = 4_000_000_000
        self.peer.write("/contacts/TH", cloud)

        garbage = Peer(self.domain)  # of the same type's name, but of another form
        garbage.advertise("/joint_states", ros2_peer.Impostor)
        self.assertTrue(wait_until(garbage.is_heard))
        garbage.write("/joint_states", ros2_peer.Impostor([0xFFFFFFFF] * 7))
        del garbage  # a peer that dies

        comes_back = Peer(self.domain)
        self.stream.advertise(comes_back)
        self.assertTrue(wait_until(comes_back.is_heard))
        self.peer.take("/palpate/estimate")
        self.peer.write("/joint_states", self.stream.joints(now))
        later, estimated = now + 20 * TICK, 0
        for i in range(20000):
            self.stream.send(comes_back, later + i * TICK)
            wait_until(lambda: False, 0.01)
            for pose in self.peer.take("/palpate/estimate"):  # of before, too
                estimated = max(estimated, ros2_peer.nanoseconds_of(pose.header.stamp))
            if estimated >= later:
                break
        self.assertGreaterEqual(estimated, later)
        report = self.end(program)["received"]
        self.assertGreaterEqual(report["malformed"], 4)
        self.assertGreaterEqual(report["out_of_order"], 1)
        self.assertGreaterEqual(report["gaps"], 1)

    def test_a_sender_whose_clock_is_set_back_is_taken_up_again(self):
        program = self.begin()
        _, _, now = self.send_until_estimated(START, least=50)
        back = now - 3600 * 10**9  # as a simulation or a bag that begins again
        self.peer.take("/palpate/estimate")
        estimated = []
        for i in range(20000):
            self.stream.send(self.peer, back + i * TICK)
            wait_until(lambda: False, 0.01)
            stamps = [ros2_peer.nanoseconds_of(pose.header.stamp) for pose in self.peer.take("/palpate/estimate")]
            estimated += [stamp for stamp in stamps if stamp < START]
            if estimated:
                break
        self.assertTrue(estimated)
        report = self.end(program)["received"]
        self.assertEqual((report["restarts"], report["malformed"]), (1, 0))

    def test_commands_stop_and_start_it(self):
        program = self.begin()
        self.peer.advertise("/palpate/command", ros2_peer.String)
        self.assertTrue(wait_until(self.peer.is_heard))
        _, _, now = self.send_until_estimated(START, least=10)
        self.peer.write("/palpate/command", ros2_peer.String("stop"))
        self.peer.write("/palpate/command", ros2_peer.String("dance"))
        quiet = 0
        for i in range(2000):  # until it has come to rest
            self.stream.send(self.peer, now + i * TICK)
            wait_until(lambda: False, 0.01)
            quiet = 0 if self.peer.take("/palpate/estimate") else quiet + 1
            if quiet > 50:
                break
        self.assertGreater(quiet, 50)
        self.peer.write("/palpate/command", ros2_peer.String("start"))
        self.peer.take("/palpate/modes")
        _, poses, _ = self.send_until_estimated(now + 3000 * TICK, least=10)
        self.assertEqual(self.end(program)["commands"], 2)


class Robot(Ros2):
    def test_the_simulated_robot_obeys_commands(self):
        program = self.start("robot", "--object", "box", "--seed", "3")
        commands = "/palpate/hand_controller/commands"
        self.peer.advertise(commands, ros2_peer.Float64MultiArray)
        self.peer.listen("/joint_states", ros2_peer.JointState)
        self.peer.listen("/tf", ros2_peer.TFMessage)
        self.peer.listen("/contacts/TH", ros2_peer.PointCloud2)
        self.assertTrue(wait_until(lambda: self.peer.is_heard() and self.peer.hears()))
        self.peer.take("/joint_states")
        layout = ros2_peer.MultiArrayLayout([], 0)
        states = []
        for _ in range(50):  # one tick each
            positions = [0.0] * 20
            positions[9] = 1.0  # FFJ0
            self.peer.write(commands, ros2_peer.Float64MultiArray(layout, positions))
            self.assertTrue(wait_until(lambda: states.extend(self.peer.take("/joint_states")) or states))
            last, states = states[-1], []
        self.assertEqual(len(last.name), 24)
        angle = dict(zip(last.name, last.position))
        self.assertGreater(angle["FFJ2"], 0.3)
        self.assertAlmostEqual(angle["MFJ2"], 0, delta=0.15)
        frames = {t.child_frame_id for m in self.peer.take("/tf") for t in m.transforms}
        self.assertIn("mount", frames)
        self.peer.write(commands, ros2_peer.Float64MultiArray(layout, [1.0]))
        wait_until(lambda: False, 0.5)
        report = self.end(program)
        self.assertEqual(report["ticks"], 51)
        self.assertEqual(report["malformed"], 1)
        self.assertEqual(len(report["T_world_object"]), 16)

    def test_a_pick_through_ros_2_does_what_one_in_a_process_does(self):
        options = ["--object", "box", "--seed", "7", *QUICK]
        alone = self.run_json("pick", *options, "--out", "alone")
        robot = self.start("robot", *options)
        picker = self.start("pick", *options, "--perturb-links", "--timeout", "30")
        stdout, stderr = picker.communicate(timeout=500)
        report, truth = json.loads(stdout), self.end(robot)
        self.assertEqual(report["status"], alone["status"], stderr)
        self.assertEqual(picker.returncode, DONE if alone["status"] == "ok" else cli.NO_SOLUTION)
        self.assertEqual(report["attempts"], alone["attempts"])
        self.assertAlmostEqual(report["robot_seconds"], alone["robot_seconds"], delta=0.2 * alone["robot_seconds"])
        self.assertGreaterEqual(truth["ticks"], 100 * report["robot_seconds"] - 2)
        self.assertEqual(report["repeats"], 0)
        if alone["lifted"]:
            self.assertGreater(truth["T_world_object"][11], 0.1)

    def test_positions_drive_a_pick_too(self):
        options = ["--object", "box", "--seed", "7", "--positions", "/fingers/commands", *QUICK]
        self.peer.listen("/fingers/commands", ros2_peer.Float64MultiArray)
        robot = self.start("robot", *options)
        picker = self.start("pick", *options, "--by-positions", "--perturb-links", "--timeout", "30")
        stdout, stderr = picker.communicate(timeout=500)
        truth = self.end(robot)
        self.assertEqual(picker.returncode, DONE, stdout + stderr)
        self.assertEqual(truth["malformed"], 0)
        self.assertGreater(truth["T_world_object"][11], 0.1)
        self.assertEqual({len(message.data) for message in self.peer.take("/fingers/commands")}, {20})

    def test_a_trajectory_moves_it_too(self):
        program = self.start("robot", "--object", "box", "--seed", "3")
        topic = "/palpate/hand_controller/joint_trajectory"
        self.peer.advertise(topic, ros2_peer.JointTrajectory)
        self.peer.listen("/joint_states", ros2_peer.JointState)
        self.assertTrue(wait_until(lambda: self.peer.is_heard() and self.peer.hears()))
        states = []
        for i in range(1, 51):
            point = ros2_peer.JointTrajectoryPoint([1.0], [], [], [], ros2_peer.Duration(0, TICK))
            header = ros2_peer.Header(ros2_peer.stamp_of(START + i * TICK), "")
            states.clear()
            self.peer.write(topic, ros2_peer.JointTrajectory(header, ["FFJ0"], [point]))
            self.assertTrue(wait_until(lambda: states.extend(self.peer.take("/joint_states")) or states))
        angle = dict(zip(states[-1].name, states[-1].position))
        self.assertGreater(angle["FFJ2"], 0.3)
        self.assertAlmostEqual(angle["MFJ2"], 0, delta=0.15)
        self.assertEqual(self.end(program)["malformed"], 0)

    def test_a_hand_that_dies_in_a_pick_is_a_fault(self):
        options = ["--object", "box", "--seed", "7", *QUICK]
        robot = self.start("robot", *options)
        self.peer.listen("/joint_states", ros2_peer.JointState)
        picker = self.start("pick", *options, "--perturb-links", "--timeout", "0.5")
        count = [0]
        moving = lambda: count.append(count.pop() + len(self.peer.take("/joint_states"))) or count[0] > 300
        self.assertTrue(wait_until(moving))
        robot.kill()
        stdout, stderr = picker.communicate(timeout=120)
        self.assertEqual(picker.returncode, cli.STOPPED, stderr)
        self.assertEqual([fault["name"] for fault in json.loads(stdout)["faults"]], ["silent"])

    def test_what_cannot_be_is_refused(self):
        self.assert_refused(USAGE, ["ros2", "dance"], "ros2 --help")
        self.assert_refused(USAGE, ["ros2", "estimate", "--domain", "900"], "--domain")
        self.assert_refused(BAD_INPUT, ["ros2", "estimate", "--object", "none.stl"], "none.stl")


if __name__ == "__main__":
    main()
