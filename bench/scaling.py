# SPDX-License-Identifier: Apache-2.0
"""What an evaluation costs on many cores, modelled from parts that are measured here.

usage: scaling.py PALPATE [--object O,..] [--trials N] [--of TRIALS] [--cores N,..] [--price P] [--parts FILE]

Measured, as processor time, which other programs on the machine change little: single trials, a
part's start, merging a trial, a rollout's step, and what a generation of a search does on one core.
Measured as wall time: a line that is appended and synced, in the folder of --work.

Modelled: TRIALS trials on N cores, where no core does anything else and none is slower than this
one. Static: a shard a core. Fine: ten shards a core, which begin as others end. A core's time is the
sum of single trials drawn from those that were measured, so that the last core to end is slower than
the mean. Not in it, because it was not measured: a scheduler's queue, a network file system, and
cores that share memory bandwidth.
"""

import argparse
import heapq
import json
import os
import pathlib
import random
import resource
import subprocess
import tempfile
import time

MERGED = (500, 20000)  # trials, of which the slope is a trial's share
SYNCS = 200
REPEATS = 20  # of the model
FINE = 10  # shards a core


def processor_time(command, **more):
    """Seconds that a program and its children took, and what it wrote on stdout."""
    before = resource.getrusage(resource.RUSAGE_CHILDREN)
    done = subprocess.run(command, check=True, stdout=subprocess.PIPE, text=True, **more)
    after = resource.getrusage(resource.RUSAGE_CHILDREN)
    seconds = after.ru_utime + after.ru_stime - before.ru_utime - before.ru_stime
    return seconds, done.stdout


def time_so_far(process):
    fields = pathlib.Path(f"/proc/{process.pid}/stat").read_text().rpartition(")")[2].split()
    return (int(fields[11]) + int(fields[12])) / os.sysconf("SC_CLK_TCK")


def measure_trials(palpate, arguments, folder):
    """Processor time of each trial: between the lines of two of them."""
    out = folder / "eval"
    command = [palpate, "eval", "--quiet", "--json", "--object", arguments.object, "--trials", str(arguments.trials),
               "--seed", str(arguments.seed), "--out", str(out), *(f"--set={value}" for value in arguments.set)]  # fmt: skip
    process = subprocess.Popen(command, stdout=subprocess.DEVNULL)
    lines, times = out / "trials.jsonl", []
    while process.poll() is None:
        count = lines.read_bytes().count(b"\n") - 1 if lines.exists() else 0
        if count > len(times):
            times += [time_so_far(process)] * (count - len(times))
        time.sleep(0.01)
    if process.returncode:
        raise SystemExit(f"{' '.join(command)}: exit code {process.returncode}")
    start, _ = processor_time([*command, "--resume"])  # all trials are there
    trials = [b - a for a, b in zip([start, *times], times)]
    return out, start, [seconds for seconds in trials if seconds > 0]


def measure_merge(palpate, out, folder):
    """Processor time that a trial takes to be merged, and bytes of its line."""
    header, *lines = (out / "trials.jsonl").read_text().splitlines()
    header, records = json.loads(header), [json.loads(line) for line in lines]
    seconds = []
    header["objects"], header["symmetry_orders"] = header["objects"][:1], header["symmetry_orders"][:1]
    for count in MERGED:
        part = folder / f"part{count}.jsonl"
        with open(part, "w") as file:
            file.write(json.dumps(header | {"trials": count}) + "\n")
            for i in range(count):
                record = records[i % len(records)]
                file.write(json.dumps(record | {"object": header["objects"][0], "seed": header["seed"] + i}) + "\n")
        seconds.append(processor_time([palpate, "merge", str(part), "--json"])[0])
    bytes_of_line = sum(map(len, lines)) / len(lines)
    return (seconds[1] - seconds[0]) / (MERGED[1] - MERGED[0]), bytes_of_line


def measure_sync(folder):
    times = []
    with open(folder / "synced", "ab") as file:
        for _ in range(SYNCS):
            start = time.perf_counter()
            file.write(b"x" * 2000)
            file.flush()
            os.fsync(file.fileno())
            times.append(time.perf_counter() - start)
    return sorted(times)[SYNCS // 2]


def measure_search(palpate, folder):
    """A candidate's rollout by its seconds a step, and a generation's work on one core."""
    search = [palpate, "train", "relocate", "--quiet", "--seed", "3", "--iterations", "9",
              "--set", "cem.search.cem.population=4", "--set", "cem.search.cem.elite=2",
              "--set", "cem.search.screening=1", "--set", "cem.search.episodes=1",
              "--out", str(folder / "search")]  # fmt: skip
    ask, _ = processor_time([*search, "--ask"])
    few, _ = processor_time([*search, "--score", "1/4"])
    many, _ = processor_time([*search, "--score", "1/1"])
    tell, _ = processor_time([*search, "--tell"])
    episode = (many - few) / 3
    return {"episode": episode, "start_of_a_share": few - episode, "ask": ask, "tell": tell}


def ends(cores, shards, start, trials, draw):
    """When the last core ends that takes a shard after the other."""
    free = [0.0] * cores
    heapq.heapify(free)
    last = 0.0
    for shard in range(shards):
        count = trials // shards + (shard < trials % shards)
        if count == 0:
            continue
        end = heapq.heappop(free) + start + sum(draw() for _ in range(count))
        last = max(last, end)
        heapq.heappush(free, end)
    return last


def model(parts, trials, cores):
    """Wall time, its parts, and the share of the cores' time that trials are run in."""
    draws = random.Random(1)
    mean = sum(parts["trials"]) / len(parts["trials"])
    merge = parts["start"] + trials * parts["merge"]
    rows = {}
    for name, shards in (("static", cores), ("fine", FINE * cores)):
        last = sum(ends(cores, shards, parts["start"], trials,
                        lambda: draws.choice(parts["trials"]) + parts["sync"])
                   for _ in range(REPEATS)) / REPEATS  # fmt: skip
        ideal, starts = trials * mean / cores, parts["start"] * min(shards, trials) / cores
        syncs = trials * parts["sync"] / cores
        waiting = max(0.0, last - ideal - starts - syncs)
        losses = {"starts": starts, "syncs": syncs, "waiting for the last core": waiting, "merge": merge}
        rows[name] = {
            "seconds": round(last + merge, 1),
            "efficiency": round(ideal / (last + merge), 3),
            "core_hours": round(cores * (last + merge) / 3600, 2),
            "most_lost_by": max(losses, key=losses.get),
            "lost_seconds": {key: round(value, 2) for key, value in losses.items()},
            "syncs_per_second": round(trials / last, 1),
            "written_MB": round(1e-6 * trials * parts["bytes"], 1),
        }
    return rows


def model_search(search, cores, population=48, screening=2, episodes=6):
    """A generation: all are screened, then the better half goes on; each round waits for its last."""
    alone = search["episode"] * (population * screening + population // 2 * (episodes - screening))
    rounds = [(population, screening), ((population + 1) // 2, episodes - screening)]
    seconds = sum(
        search["start_of_a_share"] + -(-count // cores) * each * search["episode"] + search["tell"]
        for count, each in rounds
    )
    return {"seconds": round(seconds, 2), "speedup": round(alone / seconds, 1)}


def main():
    parser = argparse.ArgumentParser()
    parser.add_argument("palpate")
    parser.add_argument("--object", default="box,mug")
    parser.add_argument("--trials", type=int, default=5, help="of each object that are measured")
    parser.add_argument("--seed", type=int, default=700)
    parser.add_argument("--set", action="append", default=[], help="option of palpate eval")
    parser.add_argument("--of", type=int, default=10000, help="trials of the evaluation that is modelled")
    parser.add_argument("--cores", default="1,10,100,1000")
    parser.add_argument("--price", type=float, help="of a core for an hour, in whatever currency")
    parser.add_argument("--work", help="folder in which it works (default: a temporary one)")
    parser.add_argument("--parts", type=pathlib.Path, help="parts that were measured before, or where to keep them")
    arguments = parser.parse_args()
    if arguments.parts and arguments.parts.exists():
        parts = json.loads(arguments.parts.read_text())
    else:
        with tempfile.TemporaryDirectory(dir=arguments.work) as name:
            folder = pathlib.Path(name)
            out, start, trials = measure_trials(arguments.palpate, arguments, folder)
            merge, size = measure_merge(arguments.palpate, out, folder)
            parts = {"start": start, "trials": trials, "merge": merge, "bytes": size, "sync": measure_sync(folder),
                     "search": measure_search(arguments.palpate, folder)}  # fmt: skip
        if arguments.parts:
            arguments.parts.write_text(json.dumps(parts, indent=2) + "\n")
    rows = {}
    for cores in map(int, arguments.cores.split(",")):
        rows[cores] = model(parts, arguments.of, cores) | {"search": model_search(parts["search"], cores)}
        if arguments.price is not None:
            rows[cores]["cost"] = {name: round(arguments.price * rows[cores][name]["core_hours"], 2)
                                   for name in ("static", "fine")}  # fmt: skip
    print(json.dumps({"measured": parts, "modelled": rows}, indent=2))


if __name__ == "__main__":
    main()
