# SPDX-License-Identifier: Apache-2.0
"""What a hand publishes while it holds something: messages of an exported pick, of any later time."""

import copy
import struct

import mcap.reader
import mcap_ros2.decoder

import ros2_peer
from ros2_peer import converted, restamped

KINDS = {
    "/joint_states": ros2_peer.JointState,
    "/actuator_states": ros2_peer.JointState,
    "/tf": ros2_peer.TFMessage,
}
LAST = 2_000_000_000  # ns, of the file that are read
HELD = 40  # the last so many messages of each topic are sent again and again


class HeldStream:
    def __init__(self, path):
        self.messages = {}
        with open(path, "rb") as file:
            reader = mcap.reader.make_reader(file, decoder_factories=[mcap_ros2.decoder.DecoderFactory()])
            start = reader.get_summary().statistics.message_end_time - LAST
            for _, channel, _, message in reader.iter_decoded_messages(starting_at=start):
                topic = channel.topic
                kind = ros2_peer.PointCloud2 if topic.startswith("/contacts/") else KINDS.get(topic)
                if topic == "/tf" and message.transforms[0].child_frame_id == "palpate_object":
                    continue
                if kind:
                    kept = self.messages.setdefault(topic, [])
                    kept.append((kind, message))
                    del kept[:-HELD]
                if topic == "/palpate/estimate":
                    at = message.pose.pose.position
                    self.estimated = [at.x, at.y, at.z]
        self.messages = {
            topic: [converted(message, kind) for kind, message in kept]
            for topic, kept in self.messages.items()
        }
        self.sent = 0

    def report_as_taxels(self, path):
        """Publishes contacts as raw values of taxels from now on, one where each contact was; writes
        their layout."""
        rows = ["finger,x,y,z,nx,ny,nz,gain,zero"]
        for topic in [name for name in self.messages if name.startswith("/contacts/")]:
            finger, clouds = topic.rpartition("/")[2], self.messages.pop(topic)
            points = [[struct.unpack_from("<9f", bytes(cloud.data), i * cloud.point_step)
                       for i in range(cloud.width)] for cloud in clouds]  # fmt: skip
            where = sorted({point[:6] for cloud in points for point in cloud})
            rows += [",".join([finger, *map(repr, p[:3]), *(repr(-n) for n in p[3:]), "0.01", "20"])
                     for p in where]  # fmt: skip
            arrays = []
            for cloud in points:
                values = [20.0] * len(where)
                for point in cloud:
                    values[where.index(point[:6])] += 100 * sum(f * f for f in point[6:]) ** 0.5
                arrays.append(ros2_peer.Float32MultiArray(ros2_peer.MultiArrayLayout([], 0), values))
            if where:
                self.messages["/taxels/" + finger] = arrays
        path.write_text("\n".join(rows) + "\n")

    def report_as_wrenches(self):
        """Publishes contacts as the wrench on each fingertip from now on, at the origin of its link."""
        for topic in [name for name in self.messages if name.startswith("/contacts/")]:
            clouds, wrenches = self.messages.pop(topic), []
            for cloud in clouds:
                force, torque = [0.0] * 3, [0.0] * 3
                for i in range(cloud.width):
                    values = struct.unpack_from("<9f", bytes(cloud.data), i * cloud.point_step)
                    p, f = values[:3], [-x for x in values[6:]]  # on the fingertip
                    moment = (p[1] * f[2] - p[2] * f[1], p[2] * f[0] - p[0] * f[2], p[0] * f[1] - p[1] * f[0])
                    force = [a + b for a, b in zip(force, f)]
                    torque = [a + b for a, b in zip(torque, moment)]
                wrench = ros2_peer.Wrench(ros2_peer.Vector3(*force), ros2_peer.Vector3(*torque))
                wrenches.append(ros2_peer.WrenchStamped(cloud.header, wrench))
            self.messages["/fingertip_wrenches/" + topic.rpartition("/")[2]] = wrenches

    def advertise(self, peer):
        for topic, messages in self.messages.items():
            peer.advertise(topic, type(messages[0]))

    def message(self, topic, now):
        return restamped(copy.deepcopy(self.messages[topic][self.sent % HELD]), now)

    def joints(self, now):
        return self.message("/joint_states", now)

    def cloud(self, finger, now):
        return self.message("/contacts/" + finger, now)

    def send_joints(self, peer, now):
        peer.write("/joint_states", self.joints(now))

    def send(self, peer, now):
        """All topics, the joint states last."""
        self.sent += 1
        for topic in self.messages:
            if topic != "/joint_states":
                peer.write(topic, self.message(topic, now))
        self.send_joints(peer, now)

    def acknowledged(self, peer):
        return peer.writers["/joint_states"].wait_for_acks(ros2_peer.duration(seconds=10))
