# SPDX-License-Identifier: Apache-2.0
"""How long `palpate ros2 estimate` takes from a joint state to the pose, and what it loses.

usage: ros2_latency.py PALPATE BAG.mcap [--object O] [--seconds N] [--joint-rate HZ] [--set K=V]

BAG is of `palpate export mcap`, of a pick that ends with the object in the hand. Its last messages
are sent again and again: contacts and transforms at 100 Hz, joint states at --joint-rate. The peer
is Python's Cyclone DDS; PYTHONPATH must have what requirements/ros2.txt names.
"""

import argparse
import json
import os
import pathlib
import random
import signal
import subprocess
import sys
import threading
import time

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[1] / "tests" / "app"))

import ros2_loopback
import ros2_peer
import ros2_stream


class Listener(threading.Thread):
    """Notes when the pose of which stamp came."""

    def __init__(self, peer):
        super().__init__(daemon=True)
        self.peer, self.came, self.ended = peer, {}, False

    def run(self):
        while not self.ended:
            for pose in self.peer.take("/palpate/estimate"):
                self.came[ros2_peer.nanoseconds_of(pose.header.stamp)] = time.monotonic()
            time.sleep(0.0002)


def play(stream, peer, seconds, joint_rate):
    """@return when which stamp was sent"""
    step = 1 / joint_rate
    every = max(1, round(joint_rate / 100))
    start, wall, sent = time.monotonic(), time.time_ns(), {}
    for i in range(int(seconds * joint_rate)):
        delay = start + i * step - time.monotonic()
        if delay > 0:
            time.sleep(delay)
        now = wall + int(1e9 * i * step)
        sent[now] = time.monotonic()
        if i % every == 0:
            stream.send(peer, now)
        else:
            stream.send_joints(peer, now)
    peer.writers["/joint_states"].wait_for_acks(ros2_peer.duration(seconds=30))
    return sent


def quantile(values, share):
    return sorted(values)[min(len(values) - 1, int(share * len(values)))]


def main():
    parser = argparse.ArgumentParser()
    parser.add_argument("palpate")
    parser.add_argument("bag")
    parser.add_argument("--object", default="box")
    parser.add_argument("--seconds", type=float, default=60)
    parser.add_argument("--joint-rate", type=float, default=100)
    parser.add_argument("--set", action="append", default=[], help="option of palpate ros2 estimate")
    arguments = parser.parse_args()
    os.environ["CYCLONEDDS_URI"] = ros2_loopback.LOOPBACK
    domain = random.SystemRandom().randrange(1, 230)
    node = subprocess.Popen(
        [arguments.palpate, "ros2", "estimate", "--object", arguments.object, "--domain", str(domain),
         "--json", "--quiet", *(f"--set={value}" for value in arguments.set)], stdout=subprocess.PIPE, text=True)  # fmt: skip
    stream, peer = ros2_stream.HeldStream(arguments.bag), ros2_peer.Peer(domain)
    stream.advertise(peer)
    peer.listen("/palpate/estimate", ros2_peer.PoseWithCovarianceStamped)
    assert ros2_peer.wait_until(lambda: peer.is_heard() and peer.hears()), "no node"
    listener = Listener(peer)
    listener.start()
    sent = play(stream, peer, arguments.seconds, arguments.joint_rate)
    time.sleep(1)
    listener.ended = True
    node.send_signal(signal.SIGINT)
    report = json.loads(node.communicate(timeout=60)[0])
    latencies = [1e3 * (at - sent[stamp]) for stamp, at in listener.came.items() if stamp in sent]
    first = min(listener.came, default=0)
    print(json.dumps({
        "joint_states_sent": len(sent),
        "joint_states_received": report["received"]["joint_states"],
        "lost": report["lost"],
        "readings": report["received"]["readings"],
        "poses": len(latencies),
        "sent_before_the_first_pose": sum(stamp < first for stamp in sent),
        "estimates": report["estimates"],
        "latency_ms": {name: round(quantile(latencies, share), 2)
                       for name, share in (("median", 0.5), ("p99", 0.99), ("max", 1.0))},
    }, indent=2))  # fmt: skip


if __name__ == "__main__":
    main()
