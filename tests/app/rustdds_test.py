# SPDX-License-Identifier: Apache-2.0
"""palpate ros2 estimate beside a node of another implementation of DDS, RustDDS.

Runs where tests/peers/rustdds is built: cargo build --release (minutes).
"""

import dataclasses
import json
import math
import os
import pathlib
import random
import signal
import subprocess
import unittest

import cli
from cli import DONE, QUICK, CliTest, main

try:
    import ros2_stream
    from ros2_loopback import LOOPBACK
except ImportError:
    ros2_stream = None

FOLDER = pathlib.Path(__file__).resolve().parents[1] / "peers" / "rustdds"
PEER = pathlib.Path(os.environ.get("CARGO_TARGET_DIR", FOLDER / "target")) / "release" / "rustdds_peer"
POSES = 200  # after which it has seen enough


@unittest.skipUnless(ros2_stream, "requirements/ros2.txt is not installed; ./dev test tries to")
@unittest.skipUnless(PEER.exists(), "tests/peers/rustdds is not built (cargo build --release in that folder)")
class RustDds(CliTest):
    def test_a_stream_gives_the_pose(self):
        self.run_json("pick", "--object", "box", "--seed", "7", "--out", "run", "--no-belief", *QUICK)
        self.run_json("export", "mcap", "run/recording.h5", "--out", "box.mcap")
        stream = ros2_stream.HeldStream(self.folder / "box.mcap")
        self.write("sensed.json", json.dumps({
            "joint_states": [dataclasses.asdict(message) for message in stream.messages["/joint_states"]],
            "tf": [dataclasses.asdict(message) for message in stream.messages["/tf"]],
            "contacts": {topic.rpartition("/")[2]: [dataclasses.asdict(message) for message in messages]
                         for topic, messages in stream.messages.items() if topic.startswith("/contacts/")},
        }))  # fmt: skip
        domain = str(random.SystemRandom().randrange(1, 230))
        environment = dict(os.environ, PALPATE_CACHE=str(self.cache), CYCLONEDDS_URI=LOOPBACK)
        estimator = subprocess.Popen(
            [cli.PROGRAM, "ros2", "estimate", "--object", "box", "--domain", domain, "--json", "--quiet",
             "--set", "first.proposals=10000", "--set", "first.particles=200"],
            cwd=self.folder, env=environment, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True)  # fmt: skip
        self.addCleanup(estimator.kill)
        done = subprocess.run([PEER, domain, "sensed.json", str(POSES), "120"], cwd=self.folder,
                              capture_output=True, text=True, timeout=200)  # fmt: skip
        self.assertEqual(done.returncode, 0, done.stderr)
        estimator.send_signal(signal.SIGINT)
        stdout, stderr = estimator.communicate(timeout=60)
        self.assertEqual(estimator.returncode, DONE, stderr)
        heard, received = json.loads(done.stdout), json.loads(stdout)["received"]
        self.assertGreaterEqual(heard["poses"], POSES, (heard, received))
        self.assertEqual(heard["of_what_was_sent"], heard["poses"])
        self.assertTrue(heard["acknowledged"])
        self.assertEqual(heard["frame"], "world")
        self.assertIn(heard["status"], ("certain", "ambiguous"))
        self.assertGreater(heard["variance"], 0)
        self.assertLess(math.dist(heard["position"], stream.estimated), 0.1)
        # What was sent before the two had found one another is not for it.
        self.assertGreater(received["joint_states"], POSES)
        self.assertEqual((received["malformed"], received["out_of_order"]), (0, 0))


if __name__ == "__main__":
    main()
