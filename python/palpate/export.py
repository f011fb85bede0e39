# SPDX-License-Identifier: Apache-2.0
"""Recordings of picks as data sets that other programs learn from.

    python -m palpate.export lerobot RECORDING.. --out DIR    LeRobot, version 3 (needs pyarrow)
    python -m palpate.export minari RECORDING.. --out DIR     Minari, version 0.5

`pip install palpate[export]` installs h5py and pyarrow. Each recording is an episode, one step a
tick. What the hand sensed and was commanded is written; of the simulator's truth nothing.
"""

import argparse
import dataclasses
import importlib
import json
import os
import pathlib
import re
import shutil
import sys
import tempfile

import numpy as np

MOUNT = ["x", "y", "z", "yaw", "pitch", "roll"]
DONE, BAD_INPUT = 0, 3
LEROBOT_VERSION, MINARI_VERSION = "v3.0", "0.5.1"
DATA_PATH = "data/chunk-{chunk_index:03d}/file-{file_index:03d}.parquet"
VIDEO_PATH = "videos/{video_key}/chunk-{chunk_index:03d}/file-{file_index:03d}.mp4"
MIN_FRAMES = 2
FORMAT_VERSION = 4  # of recordings, that is read; before it, the header has no joints


@dataclasses.dataclass(frozen=True)
class Episode:
    """A recording as arrays of one row a tick, T rows.

    features: name to (T, n) float32; names: of the n columns of each. SI units; the mount is x, y, z
    (m), yaw, pitch, roll (rad) in the world; contact forces (N) and points (m) are in the frame of
    the finger's last link, summed and averaged over its contacts, 0 without one.
    """

    path: pathlib.Path
    object: str
    seed: int
    time: np.ndarray  # (T,) s, from 0
    features: dict
    names: dict


def _needed(module):
    """A package that only exports need. Raises ImportError that says how to get it."""
    try:
        return importlib.import_module(module)
    except ImportError as error:
        raise ImportError(f"{error}: pip install 'palpate[export]'") from error


def _finger_sums(counts, contacts):
    """Per tick and finger the mean point and the summed force of its contacts, (T, 3 fingers)."""
    ticks, fingers = counts.shape
    owner = np.repeat(np.arange(ticks * fingers), counts.ravel())
    if len(owner) != len(contacts):
        raise ValueError(f"{len(contacts)} contacts, {len(owner)} are counted")
    points, forces = np.zeros((ticks * fingers, 3)), np.zeros((ticks * fingers, 3))
    np.add.at(points, owner, contacts[:, :3])
    np.add.at(forces, owner, contacts[:, 6:9])
    points /= np.maximum(counts.ravel(), 1)[:, None]
    return points.reshape(ticks, -1), forces.reshape(ticks, -1)


def _axes(names, axes="xyz"):
    return [f"{name}.{axis}" for name in names for axis in axes]


def _check_seal(path):
    """Raises ValueError unless it is a finished recording of the version that is read."""
    with open(path, "rb") as file:
        seal = re.match(rb"PALPATE RECORDING (\d{1,9})\n(finished )?", file.read(512))
    if not seal:
        raise ValueError(f"{path} is no recording")
    version = int(seal[1])
    if version != FORMAT_VERSION:
        age = "old" if version < FORMAT_VERSION else "new"
        raise ValueError(f"{path}: format {version} is too {age}: {FORMAT_VERSION} is exported")
    if not seal[2]:
        raise ValueError(f"{path}: its writer was not done")


def read_episode(path):
    """The recording.h5 of a pick as an Episode.

    Raises ValueError for a file that is no finished recording, ImportError without h5py.
    """
    h5py = _needed("h5py")
    path = pathlib.Path(path)
    _check_seal(path)
    try:
        with h5py.File(path) as file:
            header = json.loads(file["header/json"][:, 0].astype(np.uint8).tobytes())
            return _episode(path, header, {name: table[:] for name, table in file["frames"].items()})
    except (KeyError, OSError) as error:
        raise ValueError(f"{path} is damaged: {error}") from error


def _episode(path, header, frames):
    time = frames["time"][:, 0]
    if len(time) < MIN_FRAMES:
        raise ValueError(f"{path}: {len(time)} frames, at least {MIN_FRAMES} make an episode")
    hand = header["hand"]
    joints = [joint["name"] for joint in hand["joints"]]
    actuators = [actuator["name"] for actuator in hand["actuators"]]
    points, forces = _finger_sums(frames["contact_counts"], frames["contacts"])
    mount = [f"mount.{axis}" for axis in MOUNT]
    commands = np.hstack([frames["command_positions"], frames["command_base_xyz_ypr"]])
    columns = {
        "observation.state": (joints + mount, [frames["joints"], frames["base_xyz_ypr"]]),
        "observation.torque": (actuators, [frames["torques"]]),
        "observation.mount_force": (_axes(["mount"]), [frames["base_force"]]),
        "observation.contact_force": (_axes(hand["fingers"]), [forces]),
        "observation.contact_point": (_axes(hand["fingers"]), [points]),
        # A frame holds the command that led to it: the action at a step is that of the next one.
        "action": (actuators + mount, [np.vstack([commands[1:], commands[-1:]])]),
    }
    features = {name: np.hstack(parts).astype(np.float32) for name, (_, parts) in columns.items()}
    for name, values in features.items():
        if not np.isfinite(values).all():
            raise ValueError(f"{path}: {name} holds a value that is not finite")
    names = {name: list(labels) for name, (labels, _) in columns.items()}
    return Episode(path, header["object"]["name"], header["seed"], time - time[0], features, names)


def _same_hand(episodes):
    for episode in episodes[1:]:
        if episode.names != episodes[0].names:
            raise ValueError(f"{episode.path} is of another hand than {episodes[0].path}")


def _statistics(values):
    values = np.asarray(values, np.float64).reshape(len(values), -1)
    return {
        "min": values.min(0).tolist(),
        "max": values.max(0).tolist(),
        "mean": values.mean(0).tolist(),
        "std": values.std(0).tolist(),
        "count": [len(values)],
    }


def _rate(episode):
    return round(1 / float(np.median(np.diff(episode.time))))


def _tables(episodes):
    """Columns of all steps, one dict an episode."""
    tasks = sorted({f"pick the {episode.object}" for episode in episodes})
    tables, first = [], 0
    for number, episode in enumerate(episodes):
        count = len(episode.time)
        table = dict(episode.features)
        table["timestamp"] = (np.arange(count) / _rate(episode)).astype(np.float32)
        table["frame_index"] = np.arange(count)
        table["episode_index"] = np.full(count, number)
        table["index"] = first + np.arange(count)
        table["task_index"] = np.full(count, tasks.index(f"pick the {episode.object}"))
        first += count
        tables.append(table)
    return tasks, tables


def _column(values):
    pa = _needed("pyarrow")
    if values.ndim == 1:
        return pa.array(values)
    return pa.FixedSizeListArray.from_arrays(pa.array(values.ravel()), values.shape[1])


def _info(episodes, tasks, tables):
    features = {}
    for name, values in tables[0].items():
        width = values.shape[1] if values.ndim > 1 else 1
        features[name] = {
            "dtype": str(values.dtype),
            "shape": [width],
            "names": episodes[0].names.get(name),
        }
    return {
        "codebase_version": LEROBOT_VERSION,
        "robot_type": "palpate",
        "total_episodes": len(episodes),
        "total_frames": sum(len(episode.time) for episode in episodes),
        "total_tasks": len(tasks),
        "chunks_size": 1000,
        "data_files_size_in_mb": 100,
        "video_files_size_in_mb": 500,
        "fps": _rate(episodes[0]),
        "splits": {"train": f"0:{len(episodes)}"},
        "data_path": DATA_PATH,
        "video_path": VIDEO_PATH,
        "features": features,
    }


def _episode_row(number, episode, table):
    return {
        "episode_index": number,
        "tasks": [f"pick the {episode.object}"],
        "length": len(episode.time),
        "data/chunk_index": 0,
        "data/file_index": 0,
        "dataset_from_index": int(table["index"][0]),
        "dataset_to_index": int(table["index"][-1]) + 1,
        "meta/episodes/chunk_index": 0,
        "meta/episodes/file_index": 0,
    } | {
        f"stats/{name}/{kind}": value
        for name, values in table.items()
        for kind, value in _statistics(values).items()
    }


def _task_table(tasks):
    """LeRobot looks tasks up by pandas' index, which is named in the metadata."""
    pa = _needed("pyarrow")
    table = pa.table({"task_index": np.arange(len(tasks)), "task": tasks})
    described = [
        {"name": "task_index", "field_name": "task_index", "pandas_type": "int64",
         "numpy_type": "int64", "metadata": None},
        {"name": "task", "field_name": "task", "pandas_type": "unicode",
         "numpy_type": "object", "metadata": None},
    ]  # fmt: skip
    pandas = {"index_columns": ["task"], "column_indexes": [], "columns": described}
    return table.replace_schema_metadata({"pandas": json.dumps(pandas)})


def _write_lerobot(episodes, folder):
    """Returns the number of steps."""
    pa, pq = _needed("pyarrow"), _needed("pyarrow.parquet")
    tasks, tables = _tables(episodes)
    for part in ["meta/episodes/chunk-000", "data/chunk-000"]:
        (folder / part).mkdir(parents=True)
    together = {name: np.concatenate([table[name] for table in tables]) for name in tables[0]}
    data = pa.table({name: _column(values) for name, values in together.items()})
    pq.write_table(data, folder / DATA_PATH.format(chunk_index=0, file_index=0))
    rows = [_episode_row(i, *pair) for i, pair in enumerate(zip(episodes, tables, strict=True))]
    pq.write_table(pa.Table.from_pylist(rows), folder / "meta/episodes/chunk-000/file-000.parquet")
    pq.write_table(_task_table(tasks), folder / "meta/tasks.parquet")
    statistics = {name: _statistics(values) for name, values in together.items()}
    (folder / "meta/stats.json").write_text(json.dumps(statistics, indent=2))
    info = _info(episodes, tasks, tables)
    (folder / "meta/info.json").write_text(json.dumps(info, indent=2))
    return info["total_frames"]


def _box(size):
    """Without limits; Minari reads Python's infinities."""
    return {
        "type": "Box",
        "dtype": "float32",
        "shape": [size],
        "low": [-np.inf] * size,
        "high": [np.inf] * size,
    }


def _dataset_name(folder):  # of letters that Minari takes in an id
    return re.sub(r"[^\w-]", "-", folder.name.split(".")[0], flags=re.ASCII) or "picks"


def _write_minari(episodes, folder):
    """Returns the number of steps: one less an episode than of ticks, for each leads to a next."""
    h5py = _needed("h5py")
    (folder / "data").mkdir()
    observed = [name for name in episodes[0].features if name != "action"]
    steps = [len(episode.time) - 1 for episode in episodes]
    with h5py.File(folder / "data/main_data.hdf5", "w") as file:
        for number, (episode, count) in enumerate(zip(episodes, steps, strict=True)):
            group = file.create_group(f"episode_{number}")
            group.attrs.update({"id": number, "total_steps": count, "seed": episode.seed})
            for name in observed:
                short = name.removeprefix("observation.")
                group[f"observations/{short}"] = episode.features[name]
            group["actions"] = episode.features["action"][:-1]
            group["rewards"] = np.zeros(count)
            group["terminations"] = np.zeros(count, bool)
            group["truncations"] = np.arange(count) == count - 1
            group.create_group("infos")
    spaces = {name.removeprefix("observation."): _box(episodes[0].features[name].shape[1])
              for name in observed}  # fmt: skip
    metadata = {
        "total_episodes": len(episodes),
        "total_steps": sum(steps),
        "data_format": "hdf5",
        "dataset_id": f"palpate/{_dataset_name(folder)}-v0",
        "minari_version": MINARI_VERSION,
        "observation_space": json.dumps({"type": "Dict", "subspaces": spaces}),
        "action_space": json.dumps(_box(episodes[0].features["action"].shape[1])),
    }
    (folder / "data/metadata.json").write_text(json.dumps(metadata, indent=2))
    return metadata["total_steps"]


_WRITERS = {"lerobot": _write_lerobot, "minari": _write_minari}
_FILES = {  # that each writes
    "lerobot": {
        "data/chunk-000/file-000.parquet",
        "meta/episodes/chunk-000/file-000.parquet",
        "meta/info.json",
        "meta/stats.json",
        "meta/tasks.parquet",
    },
    "minari": {"data/main_data.hdf5", "data/metadata.json"},
}
_MARKS = {  # by which a data set is known
    "lerobot": ["meta/info.json"],
    "minari": ["data/main_data.hdf5", "data/metadata.json"],
}


def _files_of(folder):
    """Paths, from there, of all but the folders that hold something."""
    return {
        path.relative_to(folder).as_posix()
        for path in folder.rglob("*")
        if path.is_symlink() or not path.is_dir() or not any(path.iterdir())
    }


def _require_replaceable(format, out, recordings):
    """Raises ValueError for a folder that holds something else than a data set of that format."""
    if out.is_symlink() or not out.is_dir():
        raise ValueError(f"{out} is no folder, and is not overwritten")
    for recording in recordings:
        if pathlib.Path(recording).resolve().is_relative_to(out.resolve()):
            raise ValueError(f"{out} holds the recording {recording}, and is not overwritten")
    if not any(out.iterdir()):
        return
    if not all((out / mark).is_file() for mark in _MARKS[format]):
        raise ValueError(f"{out} is no {format} data set, and is not overwritten")
    if others := sorted(_files_of(out) - _FILES[format]):
        raise ValueError(f"{out} holds {others[0]}, too, and is not overwritten")


def export(format, recordings, out, force=False):
    """Writes one recording, or several, as a data set of that format ("lerobot" or "minari") into the
    folder `out`.

    The folder is complete or absent. Returns the number of steps written. Raises ValueError for
    another format, for what is no recording of one hand, and for a folder that exists, unless
    `force` is set and the folder is empty or such a data set, with nothing else in it; ImportError
    without h5py, or pyarrow for LeRobot.
    """
    if format not in _WRITERS:
        raise ValueError(f"format {format!r}: it is one of {', '.join(_WRITERS)}")
    out = pathlib.Path(out)
    if out.exists() and not force:
        raise ValueError(f"{out} exists; --force overwrites it")
    if isinstance(recordings, (str, os.PathLike)):
        recordings = [recordings]
    recordings = list(recordings)
    if out.exists():
        _require_replaceable(format, out, recordings)
    episodes = [read_episode(path) for path in recordings]
    if not episodes:
        raise ValueError("0 recordings")
    _same_hand(episodes)
    out.parent.mkdir(parents=True, exist_ok=True)
    with tempfile.TemporaryDirectory(
        dir=out.parent, prefix=out.name + ".", suffix=".partial"
    ) as beside:
        partial = pathlib.Path(beside) / out.name
        partial.mkdir()
        steps = _WRITERS[format](episodes, partial)
        if out.exists():
            shutil.rmtree(out)
        partial.rename(out)
    return steps


def main(arguments=None):
    """The command; returns its exit code."""
    parser = argparse.ArgumentParser(prog="palpate export", description=__doc__.split("\n")[0])
    parser.add_argument("format", choices=sorted(_WRITERS))
    parser.add_argument("recording", nargs="+", help="recording.h5 of a pick")
    parser.add_argument("--out", help="folder to write (default: beside the first recording)")
    parser.add_argument("--force", action="store_true", help="overwrite such a data set")
    parser.add_argument("--json", action="store_true", help="print one JSON object on stdout")
    chosen = parser.parse_args(arguments)
    out = chosen.out or pathlib.Path(chosen.recording[0]).with_suffix("." + chosen.format)
    try:
        messages = export(chosen.format, chosen.recording, out, chosen.force)
    except (ImportError, ValueError, OSError, KeyError) as problem:
        print(f"palpate export: {problem}", file=sys.stderr)
        return BAD_INPUT
    report = {"path": str(out), "messages": messages}
    print(json.dumps(report, indent=2) if chosen.json else f"wrote {out}: {messages} steps")
    return DONE


if __name__ == "__main__":
    sys.exit(main())
