# SPDX-License-Identifier: Apache-2.0
"""Data sets made of recordings, read by pyarrow, pandas and Minari; each test says what it lacks."""

import contextlib
import importlib.util
import io
import json
import pathlib
import sys
import tempfile
import unittest
from unittest import mock

import numpy as np
from palpate import export

JOINTS, ACTUATORS, FINGERS, TICKS = ["j1", "j2", "j3"], ["a1", "a2"], ["thumb", "first"], 6
STEPS = np.arange(TICKS)


def write_recording(path, seal="finished 0123456789abcdef", joints=JOINTS, version="4"):
    """A small one, of the format's version 4: in tick t the thumb has t % 3 contacts."""
    import h5py

    counts = np.stack([STEPS % 3, np.zeros(TICKS, int)], 1).astype(np.int32)
    contacts = np.ones((counts.sum(), 9)) * np.arange(counts.sum())[:, None]
    header = {
        "seed": 7,
        "object": {"name": "mug"},
        "hand": {
            "joints": [{"name": name} for name in joints],
            "actuators": [{"name": name} for name in ACTUATORS],
            "fingers": FINGERS,
        },
    }
    tables = {
        "time": 5 + 0.01 * STEPS[:, None],
        "joints": np.outer(STEPS, np.ones(len(joints))),
        "torques": np.zeros((TICKS, 2)),
        "base_xyz_ypr": np.zeros((TICKS, 6)),
        "base_force": np.zeros((TICKS, 3)),
        "command_positions": np.outer(STEPS, [10, 20]),
        "command_base_xyz_ypr": np.ones((TICKS, 6)),
        "true_T_world_object": np.full((TICKS, 16), 123.0),
        "contact_counts": counts,
        "contacts": contacts,
    }
    with h5py.File(path, "w", userblock_size=512) as file:
        text = np.frombuffer(json.dumps(header).encode(), np.int8)
        file["header/json"] = text[:, None]
        for name, table in tables.items():
            file[f"frames/{name}"] = table
    with open(path, "r+b") as file:
        file.write(f"PALPATE RECORDING {version}\n{seal}\n".encode())
    return path


def needs(*names):
    missing = [name for name in names if importlib.util.find_spec(name) is None]
    return unittest.skipIf(missing, f"{', '.join(missing)} not installed (pip install {' '.join(missing)})")


class Missing(unittest.TestCase):
    def test_what_has_to_be_installed_is_named(self):
        with mock.patch.dict(sys.modules, {"h5py": None}):
            with self.assertRaisesRegex(ImportError, "h5py.*: pip install 'palpate.export.'"):
                export.read_episode("recording.h5")
            with contextlib.redirect_stderr(io.StringIO()) as errors:
                self.assertEqual(export.main(["minari", "recording.h5"]), export.BAD_INPUT)
        self.assertIn("pip install", errors.getvalue())


@needs("h5py")
class Export(unittest.TestCase):
    def setUp(self):
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        self.folder = pathlib.Path(folder.name)
        self.out = self.folder / "picks"
        self.recording = write_recording(self.folder / "recording.h5")

    def test_an_episode_holds_what_was_sensed_and_the_next_command(self):
        episode = export.read_episode(self.recording)
        names = ["j1", "j2", "j3", "mount.x"]
        self.assertEqual(episode.names["observation.state"][:4], names)
        self.assertEqual(episode.features["action"][:, 0].tolist(), [10, 20, 30, 40, 50, 50])
        np.testing.assert_allclose(episode.time, 0.01 * STEPS, atol=1e-12)
        # Contacts 1 and 2 are of the third tick: their mean point and their summed force.
        points = episode.features["observation.contact_point"]
        forces = episode.features["observation.contact_force"]
        self.assertEqual(points[2].tolist(), [1.5] * 3 + [0] * 3)
        self.assertEqual(forces[2].tolist(), [3] * 3 + [0] * 3)
        for values in episode.features.values():
            self.assertFalse((values == 123).any())  # the truth

    @needs("pyarrow")
    def test_lerobot_is_read_by_others(self):
        import pyarrow.parquet as parquet

        out = self.out
        self.assertEqual(export.export("lerobot", [self.recording] * 2, out), 2 * TICKS)
        info = json.loads((out / "meta/info.json").read_text())
        self.assertEqual((info["codebase_version"], info["fps"]), ("v3.0", 100))
        self.assertEqual((info["total_frames"], info["splits"]), (2 * TICKS, {"train": "0:2"}))
        data = parquet.read_table(out / info["data_path"].format(chunk_index=0, file_index=0))
        self.assertEqual(set(data.column_names), set(info["features"]))
        self.assertEqual(data["index"].to_pylist(), list(range(2 * TICKS)))
        self.assertEqual(data["frame_index"].to_pylist(), 2 * list(range(TICKS)))
        self.assertEqual(data["action"][TICKS].as_py()[:2], [10, 20])
        width = info["features"]["action"]["shape"][0]
        self.assertEqual(data.schema.field("action").type.list_size, width)
        episodes = parquet.read_table(out / "meta/episodes/chunk-000/file-000.parquet")
        self.assertEqual(episodes["dataset_from_index"].to_pylist(), [0, TICKS])
        self.assertEqual(episodes["dataset_to_index"].to_pylist(), [TICKS, 2 * TICKS])
        self.assertEqual(episodes["tasks"].to_pylist(), [["pick the mug"]] * 2)
        statistics = json.loads((out / "meta/stats.json").read_text())
        self.assertEqual(statistics["action"]["max"][:2], [50, 100])

    @needs("pyarrow", "pandas")
    def test_pandas_finds_a_task_by_its_index(self):
        import pandas

        export.export("lerobot", [self.recording], self.out)
        tasks = pandas.read_parquet(self.out / "meta/tasks.parquet")
        self.assertEqual((tasks.iloc[0].name, tasks.iloc[0].task_index), ("pick the mug", 0))

    @needs("minari", "PIL")
    def test_minari_reads_its_data_set(self):
        from minari import MinariDataset

        self.assertEqual(export.export("minari", [self.recording], self.out), TICKS - 1)
        dataset = MinariDataset(self.out / "data")
        self.assertEqual((dataset.total_episodes, dataset.total_steps), (1, TICKS - 1))
        episode = dataset[0]
        self.assertEqual(episode.actions[:, 0].tolist(), [10, 20, 30, 40, 50])
        self.assertEqual(episode.observations["state"].shape, (TICKS, 9))
        space = dataset.observation_space["state"]
        self.assertTrue(space.contains(episode.observations["state"][0]))
        self.assertEqual(episode.truncations.tolist(), [False] * (TICKS - 2) + [True])

    def test_an_unfinished_recording_is_refused(self):
        for seal in ["unfinished", ""]:
            path = write_recording(self.folder / "other.h5", seal)
            with self.assertRaisesRegex(ValueError, "was not done"):
                export.read_episode(path)

    def test_a_recording_of_another_version_is_refused(self):
        for version, word in [
            ("9", "format 9 is too new"),
            ("3", "format 3 is too old"),
            ("4x", "no recording"),
        ]:
            path = write_recording(self.folder / "other.h5", version=version)
            with self.assertRaisesRegex(ValueError, word):
                export.read_episode(path)

    def test_the_id_of_a_minari_data_set_is_one_that_minari_takes(self):
        for folder, name in [
            ("picks minari", "picks-minari"),
            ("set é", "set--"),
            ("run_2.minari", "run_2"),
            (".minari", "picks"),
        ]:
            out = self.folder / folder
            export.export("minari", [self.recording], out)
            metadata = json.loads((out / "data/metadata.json").read_text())
            self.assertEqual(metadata["dataset_id"], f"palpate/{name}-v0")

    def test_a_damaged_recording_is_refused(self):
        import h5py

        with h5py.File(self.recording, "r+") as file:
            del file["frames/joints"]
        with self.assertRaisesRegex(ValueError, "is damaged: .*joints"):
            export.read_episode(self.recording)
        self.recording.write_bytes(self.recording.read_bytes()[:2000])
        with self.assertRaisesRegex(ValueError, "is damaged"):
            export.read_episode(self.recording)

    def test_one_recording_may_be_a_path(self):
        self.assertEqual(export.export("minari", str(self.recording), self.out), TICKS - 1)

    def test_steps_are_those_of_the_data_set(self):
        steps = export.export("minari", [self.recording] * 2, self.out)
        metadata = json.loads((self.out / "data/metadata.json").read_text())
        self.assertEqual((steps, metadata["total_steps"]), (2 * (TICKS - 1),) * 2)

    def test_bad_input_is_named_and_leaves_nothing(self):
        text = self.folder / "text.h5"
        text.write_text("no recording")
        other = write_recording(self.folder / "other.h5", joints=["j1", "j2", "thumb"])
        for recordings, word in [
            ([text], "no recording"),
            ([self.recording, other], "another hand"),
            ([], "0 recordings"),
        ]:
            with self.assertRaisesRegex(ValueError, word):
                export.export("minari", recordings, self.out)
        with self.assertRaisesRegex(ValueError, "'csv'"):
            export.export("csv", [self.recording], self.out)
        self.assertFalse(self.out.exists() or list(self.folder.glob("*.partial")))

    def test_the_command_keeps_what_is_there_unless_forced(self):
        self.out.mkdir()
        arguments = ["minari", str(self.recording), "--out", str(self.out)]
        with contextlib.redirect_stderr(io.StringIO()) as errors:
            self.assertEqual(export.main(arguments), export.BAD_INPUT)
        self.assertIn("--force", errors.getvalue())
        with contextlib.redirect_stdout(io.StringIO()) as printed:
            self.assertEqual(export.main([*arguments, "--force", "--json"]), export.DONE)
        report = {"path": str(self.out), "messages": TICKS - 1}
        self.assertEqual(json.loads(printed.getvalue()), report)

    def refuses_to_overwrite(self, format, words):
        """And leaves all files as they are."""
        before = {path: path.read_bytes() for path in self.folder.rglob("*") if path.is_file()}
        with self.assertRaisesRegex(ValueError, f"{self.out.name}.* {words}.*not overwritten"):
            export.export(format, [self.recording], self.out, force=True)
        after = {path: path.read_bytes() for path in self.folder.rglob("*") if path.is_file()}
        self.assertEqual(before, after)

    def test_force_overwrites_such_a_data_set_alone(self):
        export.export("minari", [self.recording] * 2, self.out)
        self.assertEqual(export.export("minari", [self.recording], self.out, force=True), TICKS - 1)
        self.refuses_to_overwrite("lerobot", "no lerobot data set")
        for other in ["notes.txt", "data/recording.h5", "videos"]:
            path = self.out / other
            path.mkdir() if other == "videos" else path.write_text("of somebody")
            self.refuses_to_overwrite("minari", f"holds {other}")
            path.rmdir() if other == "videos" else path.unlink()
        (self.out / "data/main_data.hdf5").unlink()
        self.refuses_to_overwrite("minari", "no minari data set")

    @needs("pyarrow")
    def test_force_overwrites_a_lerobot_data_set(self):
        for _ in range(2):
            export.export("lerobot", [self.recording], self.out, force=True)
        (self.out / "README.md").write_text("of somebody")
        self.refuses_to_overwrite("lerobot", "holds README.md")

    def test_force_keeps_the_folder_of_a_recording(self):
        self.out = self.folder
        self.refuses_to_overwrite("minari", "holds the recording")
        self.out = self.recording
        self.refuses_to_overwrite("minari", "no folder")
        self.out = self.folder / "picks"
        export.export("minari", [self.recording], self.out)
        inside = self.out / "data/recording.h5"
        inside.symlink_to(self.recording)
        self.refuses_to_overwrite("minari", "holds data/recording.h5")
        inside.unlink()
        self.recording.rename(inside)
        self.recording = self.folder / "link.h5"
        self.recording.symlink_to(inside)
        self.refuses_to_overwrite("minari", "holds the recording")

    def test_folders_of_others_beside_it_are_kept(self):
        kept = self.out.with_name(self.out.name + ".partial") / "notes.txt"
        kept.parent.mkdir()
        kept.write_text("of somebody")
        export.export("minari", [self.recording], self.out)
        self.assertEqual(kept.read_text(), "of somebody")
        self.assertEqual(list(self.folder.glob("*.partial")), [kept.parent])


if __name__ == "__main__":
    unittest.main()
