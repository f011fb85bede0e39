# SPDX-License-Identifier: Apache-2.0
"""export mcap and replay of MCAP files, judged by three independent readers."""

import json
import math
import pathlib
import shutil
import unittest

from cli import BAD_INPUT, USAGE, PickTest, main

try:
    import mcap.reader
    import mcap.writer
    import mcap_ros2.decoder
    import mcap_ros2.writer
    from rosbags.rosbag2 import StoragePlugin
    from rosbags.rosbag2 import Writer as RosbagsWriter
    from rosbags.rosbag2.storage_mcap import McapReader
    from rosbags.typesys import Stores, get_typestore
except ImportError:
    mcap = None

LAYOUT = pathlib.Path(__file__).resolve().parents[2] / "configs" / "foxglove.json"
POINT_STEP = 44  # bytes: eleven 32-bit floats
NS = 1e-9
TOPICS = {"/joint_states": "/robot/joints", "/tf": "/robot/tf", "/tf_static": "/robot/tf_static",
          "/wrench": "/robot/load", "/actuator_states": "/robot/efforts"}  # of the foreign bag
FOREIGN = ["--object", "box", "--hand", "shadow", "--joint-states", "/robot/joints",
           "--contacts", "/touch", "--tf", "/robot/tf", "--wrench", "/robot/load",
           "--actuator-states", "/robot/efforts", "--mount-frame", "wrist"]  # fmt: skip


def stamp(message):
    return message.header.stamp.sec + NS * message.header.stamp.nanosec


@unittest.skipUnless(mcap, "requirements/ros2.txt is not installed; ./dev test tries to")
class Export(PickTest):
    @classmethod
    def setUpClass(cls):
        """What all tests ask of the pick's export."""
        super().setUpClass()
        cls.report = cls.kept.run_json("export", "mcap", "run/recording.h5", "--out", "box.mcap")
        cls.replayed = cls.kept.run_json("replay", "run/recording.h5")

    def setUp(self):
        super().setUp()
        self.path = self.folder / "box.mcap"

    def decoded(self, path, topics=None, last=None):
        """Messages, of the last seconds alone where so many are given."""
        with open(path, "rb") as file:
            reader = mcap.reader.make_reader(
                file, decoder_factories=[mcap_ros2.decoder.DecoderFactory()], validate_crcs=True)
            end = reader.get_summary().statistics.message_end_time
            start = None if last is None else end - int(last / NS)
            yield from reader.iter_decoded_messages(topics=topics, starting_at=start)

    def test_mcap_reads_it_with_all_crcs_and_counts(self):
        with open(self.path, "rb") as file:
            reader = mcap.reader.make_reader(file, validate_crcs=True)
            self.assertEqual(reader.get_header().profile, "ros2")
            summary = reader.get_summary()
            counted = {}
            for schema, channel, _ in reader.iter_messages():
                self.assertEqual((schema.encoding, channel.message_encoding), ("ros2msg", "cdr"))
                counted[channel.topic] = counted.get(channel.topic, 0) + 1
            metadata = {record.name: record.metadata for record in reader.iter_metadata()}
        statistics = summary.statistics
        self.assertEqual(statistics.message_count, self.report["messages"])
        self.assertEqual(statistics.message_count, sum(counted.values()))
        by_topic = {summary.channels[i].topic: n for i, n in statistics.channel_message_counts.items()}
        self.assertEqual(by_topic, counted)
        self.assertEqual(counted["/joint_states"], self.replayed["messages"])
        self.assertEqual(len(summary.chunk_indexes), statistics.chunk_count)
        self.assertGreater(statistics.chunk_count, 1)
        self.assertEqual((metadata["palpate"]["object"], metadata["palpate"]["hand"]), ("box", "shadow"))
        self.assertNotIn("truth", " ".join(counted))

    def test_mcap_ros2_support_decodes_it(self):
        times = []
        for _, channel, raw, message in self.decoded(self.path, last=20):
            if channel.topic == "/joint_states":
                self.assertEqual(len(message.name), 24)
                self.assertEqual(len(message.position), 24)
                self.assertAlmostEqual(stamp(message), NS * raw.log_time, places=9)
                times.append(stamp(message))
            elif channel.topic.startswith("/contacts/"):
                self.assertEqual(message.point_step, POINT_STEP)
                self.assertEqual(len(message.data), POINT_STEP * message.width)
            elif channel.topic == "/palpate/mode_weights":
                self.assertLessEqual(sum(message.data), 1.001)
        self.assertTrue(all(b > a for a, b in zip(times, times[1:])))
        pose = [m for *_, m in self.decoded(self.path, ["/palpate/estimate"])][-1].pose.pose
        best = self.replayed["modes"][0]["T_world_object"]
        for value, index in ((pose.position.x, 3), (pose.position.y, 7), (pose.position.z, 11)):
            self.assertAlmostEqual(value, best[index], places=9)

    def test_rosbags_decodes_it_with_its_own_definitions(self):
        types = get_typestore(Stores.ROS2_HUMBLE)
        reader = McapReader(self.path)
        reader.open()
        seen = set()
        for connection, time, data in reader.messages(reader.connections):
            if connection.topic in seen:
                continue
            message = types.deserialize_cdr(data, connection.msgtype)
            again = types.serialize_cdr(message, connection.msgtype)
            self.assertEqual(bytes(again), bytes(data), connection.topic)
            seen.add(connection.topic)
        reader.close()
        for topic in ("/joint_states", "/tf", "/wrench", "/palpate/markers", "/palpate/object",
                      "/palpate/events", "/palpate/modes", "/palpate/status"):
            self.assertIn(topic, seen)

    def test_the_layout_shows_topics_that_are_there(self):
        layout = json.loads(LAYOUT.read_text())
        named = set()
        for panel in layout["configById"].values():
            named.update(panel.get("topics", {}))
            named.update(path["value"].split(".")[0] for path in panel.get("paths", []))
            named.update([panel["topicPath"]] if "topicPath" in panel else [])
        with open(self.path, "rb") as file:
            channels = mcap.reader.make_reader(file).get_summary().channels.values()
        self.assertGreater(len(named), 5)
        self.assertLessEqual(named, {channel.topic for channel in channels})

    def test_replay_estimates_what_the_recording_does(self):
        again = self.run_json("replay", "box.mcap")
        self.assertEqual(again["path"], "box.mcap")
        self.assertEqual(again["messages"], self.report["messages"])
        self.assertGreater(len(again["modes"]), 0)
        best, before = again["modes"][0]["T_world_object"], self.replayed["modes"][0]["T_world_object"]
        apart = math.dist([best[i] for i in (3, 7, 11)], [before[i] for i in (3, 7, 11)])
        # The file says which hand, not how the recording believed its links to be off.
        self.assertLess(apart, 0.015)

    def test_the_folder_of_a_pick_stands_for_its_recording(self):
        again = self.run_json("replay", "run")
        self.assertEqual(again["path"], "run/recording.h5")
        self.assertEqual(again["modes"], self.replayed["modes"])
        self.assert_refused(BAD_INPUT, ["replay", "run", "--at", "3"], "run/recording.h5")
        page = self.run_json("view", "run", "run", "--out", "both")["page"]
        self.addCleanup(shutil.rmtree, self.folder / "both")
        self.assertTrue((self.folder / page).exists())
        self.run_json("export", "mcap", "run", "--out", "again.mcap")
        self.addCleanup((self.folder / "again.mcap").unlink)
        self.assertEqual((self.folder / "again.mcap").read_bytes(), self.path.read_bytes())

    def foreign(self, compression):
        """The same hand as somebody else's writer, names and frames have it."""
        path = self.folder / "foreign.mcap"
        self.addCleanup(path.unlink, missing_ok=True)
        with open(path, "wb") as file:
            writer = mcap_ros2.writer.Writer(file, compression=compression)
            schemas = {}
            for schema, channel, raw, message in self.decoded(self.path, last=2):
                topic = channel.topic
                if topic.startswith("/palpate"):
                    continue
                if schema.name not in schemas:
                    schemas[schema.name] = writer.register_msgdef(schema.name, schema.data.decode())
                topic = TOPICS.get(topic, topic).replace("/contacts", "/touch")
                if channel.topic == "/tf":
                    for transform in message.transforms:
                        transform.header.frame_id = transform.header.frame_id.replace("mount", "wrist")
                        transform.child_frame_id = transform.child_frame_id.replace("mount", "wrist")
                writer.write_message(topic, schemas[schema.name], message, raw.log_time, raw.publish_time)
            writer.finish()
        return "foreign.mcap"

    def test_replay_of_somebody_elses_bag(self):
        name = self.foreign(mcap.writer.CompressionType.NONE)
        answer = self.run_json("replay", name, *FOREIGN)
        self.assertGreater(len(answer["modes"]), 0)
        again = self.run_json("replay", name, *FOREIGN)
        self.assertEqual(answer["modes"], again["modes"])
        held = self.replayed["modes"][0]["T_world_object"]
        nearest = min(math.dist([mode["T_world_object"][i] for i in (3, 7, 11)],
                                [held[i] for i in (3, 7, 11)]) for mode in answer["modes"])  # fmt: skip
        # Contacts at one instant alone: it is in the hand, at one of the poses that fit.
        self.assertLess(nearest, 0.08)

        without = [word for word in FOREIGN if word not in ("--tf", "/robot/tf")]
        self.assert_refused(BAD_INPUT, ["replay", name, *without], "wrist")

    def test_a_folder_of_ros2_bag_record_is_read_in_the_order_of_its_numbers(self):
        name = self.foreign(mcap.writer.CompressionType.NONE)
        whole = self.run_json("replay", name, *FOREIGN)
        bag = self.folder / "bag"
        bag.mkdir()
        self.addCleanup(shutil.rmtree, bag)
        with open(self.folder / name, "rb") as file:
            messages = list(mcap.reader.make_reader(file).iter_messages())
        each = len(messages) // 11 + 1  # the tenth comes after the second, whatever their names
        for i in range(11):
            with open(bag / f"run_{i}.mcap", "wb") as file:
                writer, known = mcap.writer.Writer(file), {}
                writer.start("ros2", "")
                for schema, channel, message in messages[i * each:(i + 1) * each]:
                    if channel.topic not in known:
                        of = writer.register_schema(schema.name, schema.encoding, schema.data)
                        known[channel.topic] = writer.register_channel(channel.topic, "cdr", of)
                    writer.add_message(known[channel.topic], message.log_time, message.data,
                                       message.publish_time)  # fmt: skip
                writer.finish()
        split = self.run_json("replay", "bag", *FOREIGN)
        self.assertEqual((split["modes"], split["messages"]), (whole["modes"], whole["messages"]))

    def test_bags_that_are_no_mcap_are_refused_with_what_converts_them(self):
        typestore = get_typestore(Stores.ROS2_HUMBLE)
        with RosbagsWriter(self.folder / "old", version=8, storage_plugin=StoragePlugin.SQLITE3) as bag:
            bag.add_connection("/joint_states", "sensor_msgs/msg/JointState", typestore=typestore)
        self.addCleanup(shutil.rmtree, self.folder / "old")
        for path in ("old", "old/old.db3"):
            self.assert_refused(BAD_INPUT, ["replay", path, "--object", "box"], "rosbags-convert", path)
        (self.folder / "none").mkdir()
        self.assert_refused(BAD_INPUT, ["replay", "none", "--object", "box"], "recording.h5", "*.mcap")

    def test_compressed_chunks_are_read_like_others(self):
        answers = []
        for compression in ("NONE", "ZSTD", "LZ4"):
            name = self.foreign(getattr(mcap.writer.CompressionType, compression))
            answers.append(self.run_json("replay", name, *FOREIGN))
            (self.folder / name).rename(self.folder / "kept.mcap")
        self.assertEqual(answers[0]["modes"], answers[1]["modes"])
        self.assertEqual(answers[0]["modes"], answers[2]["modes"])
        damaged = bytearray((self.folder / "kept.mcap").read_bytes())
        damaged[len(damaged) // 3] ^= 0x55
        (self.folder / "kept.mcap").write_bytes(damaged)
        self.assert_refused(BAD_INPUT, ["replay", "kept.mcap", *FOREIGN], "kept.mcap")

    def test_an_export_is_small(self):
        sizes = [(self.folder / name).stat().st_size for name in ("box.mcap", "run/recording.h5")]
        with open(self.path, "rb") as file:
            chunks = mcap.reader.make_reader(file).get_summary().chunk_indexes
        self.assertEqual({chunk.compression for chunk in chunks}, {"zstd"})
        self.assertLess(sizes[0], sizes[1])

    def test_a_video_of_too_many_pictures_is_refused(self):
        self.assert_refused(BAD_INPUT, ["render", "run/recording.h5", "--video", "--speed", "0.1"], "raise --speed")
        self.assertFalse((self.folder / "run/video.png").exists())

    def test_what_cannot_be_replayed_is_named(self):
        self.assert_refused(BAD_INPUT, ["replay", "box.mcap", "--mount-frame", "elsewhere", "--quiet"],
                            "elsewhere", "/joint_states")
        self.assert_refused(BAD_INPUT, ["replay", "box.mcap", "--at", "-5", "--quiet"], "--at -5")
        (self.folder / "cut.mcap").write_bytes(self.path.read_bytes()[:4000])
        self.assert_refused(BAD_INPUT, ["replay", "cut.mcap", "--quiet"], "cut.mcap")
        (self.folder / "cut.mcap").unlink()

    def test_a_seed_that_is_no_number_is_bad_input(self):
        with open(self.folder / "odd.mcap", "wb") as file:
            writer = mcap.writer.Writer(file)
            writer.start()
            writer.add_metadata("palpate", {"object": "box", "hand": "shadow", "seed": "ten"})
            writer.finish()
        self.addCleanup((self.folder / "odd.mcap").unlink)
        self.assert_refused(BAD_INPUT, ["replay", "odd.mcap", "--quiet"], "odd.mcap", 'the seed "ten"')

    def test_export_refuses_what_it_must(self):
        self.assert_refused(BAD_INPUT, ["export", "mcap", "run/recording.h5", "--out", "box.mcap"],
                            "box.mcap", "--force")
        self.assert_refused(BAD_INPUT, ["export", "mcap", "none.h5"], "none.h5")
        self.assert_refused(USAGE, ["export", "bag", "run/recording.h5"], "bag")


if __name__ == "__main__":
    main()
