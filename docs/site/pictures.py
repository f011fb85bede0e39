# SPDX-License-Identifier: Apache-2.0
"""Makes the pictures of the readme and the documentation from the present program.

usage: pictures.py PALPATE [SET...] [--long]   makes the sets (without one: all that are not long)
       pictures.py --list                      names the sets, and what makes them

Every set is made in a folder of its own below build/pictures, copied to docs/images, and noted in
docs/images/made.json with the pictures' hashes, the commands, and a hash of the sources that draw
them. The test docs.pictures compares those with what is there.
"""

import datetime
import hashlib
import json
import os
import pathlib
import shlex
import shutil
import subprocess
import sys
from typing import NamedTuple

ROOT = pathlib.Path(__file__).resolve().parent.parent.parent
IMAGES = ROOT / "docs" / "images"
MADE = IMAGES / "made.json"
RENDERER = ("src/simulation/rendering/*.?pp", "apps/palpate/posterior_film.cpp")
PLOTS = ("src/plotting/*.?pp", "include/palpate/plotting/*.?pp")
PAGE = ("viewer/*",)
BROWSER = (
    "chromium --headless=new --no-sandbox --disable-gpu-sandbox --use-angle=swiftshader "
    "--enable-unsafe-swiftshader --hide-scrollbars --window-size=1400,900 "
    "--virtual-time-budget=20000 --screenshot={work}/%s 'file://{work}/%s/replay.html#t=%s'"
)


class Set(NamedTuple):
    commands: tuple  # {work} is the set's folder; "palpate" is the program
    pictures: dict   # name in docs/images: path in {work}
    follows: tuple   # sources that must not have changed since
    long: bool = False


def policy_set(policy):
    phases = {"reach": 1, "carry": 2, "hold": 3}
    pictures = {f"{policy}-{name}.png": f"drawn/{i}-{name}.png" for name, i in phases.items()}
    return Set(
        (
            f"palpate rollout {policy} --episodes 1 --record 1 --seed 9100 --out {{work}}/run",
            "palpate render {work}/run/episode-0.h5 --size 320x240 --video --speed 1 "
            "--out {work}/drawn",
        ),
        {**pictures, f"{policy}-video.png": "drawn/video.png"},
        (f"models/{policy}.json", *RENDERER[:1], "apps/palpate/render.cpp"),
    )


def experiment_set(name, seed, *figures):
    """Follows the experiment and what draws its plots, not the library that it measures."""
    return Set(
        (f"./dev experiment {name} --seed {seed} --out {{work}}",),
        {f"{figure}.svg": f"{figure}.svg" for figure in figures},
        (f"experiments/{name}.cpp", f"experiments/common/{name}.?pp", *PLOTS),
        long=True,
    )


def training_set(seed):
    curves = {"evaluation", "return", "surrogate_gain"}
    pictures = {f"relocate-dapg-{curve}.svg": f"dapg/{curve}.svg" for curve in curves}
    for phase, i in {"reach": 1, "carry": 2, "hold": 3}.items():
        pictures[f"relocate-dapg-{phase}.png"] = f"drawn/{i}-{phase}.png"
    pictures["relocate-dapg-video.png"] = "drawn/video.png"
    for figure in ("histogram", "normal-plot"):
        pictures[f"relocate-dapg-{figure}.svg"] = f"compared/{figure}.svg"
    return Set(
        (
            "palpate train relocate --config configs/relocate_dapg.toml --method dapg --expert "
            f"relocate-memoryless --demonstrations 60 --iterations 30 --seed {seed} --threads 2 "
            "--set task.solver=fast --set npg.episode.horizon=99 --set bc.log_std=-3.5 "
            "--set npg.min_log_std=-5 --set bc.epochs=300 --out {work}/dapg",
            "palpate rollout {work}/dapg/policy.json --episodes 1 --record 1 --seed 9100 "
            "--out {work}/run",
            "palpate render {work}/run/episode-0.h5 --size 320x240 --video --speed 1 "
            "--out {work}/drawn",
            "palpate compare {work}/dapg/policy.json {data}/relocate_mug_published_policy.json "
            "--episodes 100 --seed 9100 --out {work}/compared",
        ),
        pictures,
        ("configs/relocate_dapg.toml", "models/relocate-memoryless.json",
         "apps/palpate/train_curves.cpp", *PLOTS, *RENDERER[:1], "apps/palpate/render.cpp"),
        long=True,
    )


def human_set(iterations):
    """Learning curves of DAPG from the synthetic human: a seed, and the iterations with the
    demonstrations in the gradient; 40 without follow, and 40 more on the faithful solver."""
    train = "palpate train relocate --config configs/relocate_human.toml --demos {work}/demos"
    commands = ["palpate demos make --config configs/relocate_human_demos.toml --count 120 --seed 1 "
                "--out {work}/demos"]  # fmt: skip
    pictures = {}
    for seed, count in iterations.items():
        bc, dapg, more, last = (f"{{work}}/{name}-{seed}" for name in ("bc", "dapg", "dapg2", "dapg3"))
        commands += [
            f"{train} --method bc --seed {seed} --out {bc}",
            f"{train} --method dapg --from {bc}/policy.json --seed {seed} --iterations {count} "
            f"--out {dapg}",
            f"{train} --method dapg --set npg.demo_weight=0 --from {dapg}/policy.json "
            f"--seed {seed + 100} --iterations 40 --out {more}",
            f"{train} --method dapg --set npg.demo_weight=0 --set task.solver=faithful "
            f"--from {more}/policy.json --seed {seed + 200} --iterations 40 --out {last}",
        ]
        pictures[f"relocate-human-{seed}-first.svg"] = f"dapg-{seed}/return.svg"
        pictures[f"relocate-human-{seed}-last.svg"] = f"dapg2-{seed}/return.svg"
        pictures[f"relocate-human-{seed}-faithful.svg"] = f"dapg3-{seed}/return.svg"
    follows = ("configs/relocate_human.toml", "configs/relocate_human_demos.toml",
               "apps/palpate/train_curves.cpp", *PLOTS)  # fmt: skip
    return Set(tuple(commands), pictures, follows, long=True)


SETS = {
    "posterior": Set(
        (
            "palpate pick --object mug --seed 2 --force --out {work}/mug",
            "palpate render {work}/mug/recording.h5 --posterior --size 360x270 --azimuth 300 "
            "--elevation -35 --distance 0.6 --speed 6.7 --out {work}/drawn",
        ),
        {"posterior.png": "drawn/posterior.png"},
        RENDERER,
    ),
    "replay": Set(
        (
            "palpate pick --object mug --seed 2 --force --out {work}/mug",
            "palpate pick --object box --seed 7 --place 0.15,0.1,0.5 --force --out {work}/box",
            BROWSER % ("replay.png", "mug", "end&view=side"),
            BROWSER % ("place.png", "box", "end"),
        ),
        {"replay.png": "replay.png", "place.png": "place.png"},
        PAGE,
    ),
    "relocate-best": policy_set("relocate-best"),
    "relocate-memoryless": policy_set("relocate-memoryless"),
    "localization_tables": experiment_set("localization_tables", 31700, "calibration", "success"),
    "localization_tracking": experiment_set("localization_tracking", 28700, "tracking"),
    "localization_probes": experiment_set("localization_probes", 9000, "probes"),
    "hand_figures": experiment_set("hand_figures", 9000, "hand_on_edge", "task_space_vectors",
                                   "tree_shadow", "tree_human"),
    "registration_gnc": experiment_set("registration_gnc", 30000, "beside_6_7_angle",
                                       "beside_6_8_position", "beside_6_10_weights"),
    "touch_surfaces": experiment_set("touch_surfaces", 9906, "angle_error_raw",
                                     "angle_error_s2-lag"),
    "relocate-dapg": training_set(200),
    "relocate-human": human_set({200: 69, 201: 60, 202: 60}),
    "relocate-published": Set(
        (
            "palpate rollout {data}/relocate_mug_published_policy.json --episodes 1 --record 1 "
            "--seed 9100 --out {work}/run",
            "palpate render {work}/run/episode-0.h5 --size 320x240 --out {work}/drawn",
        ),
        {f"relocate-published-{n}.png": f"drawn/{i}-{n}.png"
         for n, i in {"reach": 1, "carry": 2, "hold": 3}.items()},
        (*RENDERER[:1], "apps/palpate/render.cpp"),
        long=True,
    ),
}
# Drawn by hand: sketches of a concept and badges, which show nothing that the program computes.
SKETCHES = {f"concept-{n}.svg" for n in ("likelihood", "free-space", "table", "bias", "certificate")} | {
    f"badge-{n}.svg" for n in ("licence", "version", "languages", "evaluated")
}


def hash_of(*files):
    total = hashlib.sha256()
    for file in files:
        total.update(pathlib.Path(file).read_bytes())
    return total.hexdigest()


def hash_of_sources(patterns):
    """Of the files that draw a set, in the order of their names; none for none."""
    files = sorted(file for pattern in patterns for file in ROOT.glob(pattern) if file.is_file())
    return hash_of(*files) if files else None


def last_time(page):
    """Of a pick, s, when its last estimate was made."""
    return json.loads((page / "report.json").read_text())["robot_seconds"]


def run(command, program, work):
    text = command.replace("{work}", str(work)).replace("{data}", os.environ.get("PALPATE_DATA", ""))
    words = shlex.split(text)
    if words[0] == "palpate":
        words[0] = program
    if "#t=end" in words[-1]:
        page = pathlib.Path(words[-1].removeprefix("file://").split("#")[0]).parent
        words[-1] = words[-1].replace("#t=end", f"#t={last_time(page):.2f}")
    print("==>", shlex.join(words), file=sys.stderr)
    subprocess.run(words, cwd=ROOT, check=True, stdout=subprocess.DEVNULL)


def make(name, program):
    chosen = SETS[name]
    work = ROOT / "build" / "pictures" / name
    shutil.rmtree(work, ignore_errors=True)
    work.mkdir(parents=True)
    for command in chosen.commands:
        run(command, program, work)
    for picture, path in chosen.pictures.items():
        shutil.copyfile(work / path, IMAGES / picture)
    note(name, subprocess.check_output([program, "--version"], text=True).strip(),
         datetime.date.today().isoformat())  # fmt: skip


def note(name, version, date):
    made = json.loads(MADE.read_text()) if MADE.exists() else {}
    chosen = SETS[name]
    made[name] = {
        "commands": chosen.commands,
        "date": date,
        "version": version,
        "follows": hash_of_sources(chosen.follows),
        "pictures": {p: hash_of(IMAGES / p) for p in sorted(chosen.pictures)},
    }
    partial = MADE.with_suffix(".partial")
    partial.write_text(json.dumps(dict(sorted(made.items())), indent=1) + "\n")
    partial.replace(MADE)


def main(arguments):
    if arguments == ["--list"]:
        for name, chosen in SETS.items():
            print(f"{name}{' (long)' if chosen.long else ''}")
            for command in chosen.commands:
                print("   ", command)
        return 0
    with_long = "--long" in arguments
    program, *names = [a for a in arguments if a != "--long"] or [""]
    if not program or set(names) - set(SETS):
        print(__doc__, file=sys.stderr)
        return 2
    for name in names or [n for n, s in SETS.items() if with_long or not s.long]:
        make(name, str(pathlib.Path(program).resolve()))
    return 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
