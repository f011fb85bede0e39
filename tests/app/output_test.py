# SPDX-License-Identifier: Apache-2.0
"""Folders of results: one run at a time, nothing overwritten, nothing lost by a kill."""

import json
import os
import random
import signal
import subprocess
import time

import cli
from cli import BAD_INPUT, DONE, NO_SOLUTION, QUICK, CliTest, main

# A pick of a second, of which only the form matters.
SHORT = [*QUICK, "--quiet", "--set", "calibrate.touches=0", "--set", "attempts=1",
         "--set", "palpation.max=0", "--set", "explore.touches=0", "--set", "explore.max_touches=0",
         "--set", "estimate_before_lift=false"]  # fmt: skip
PICK = ["pick", "--object", "box", "--out", "run", "--json", *SHORT]
EVAL = ["eval", "--object", "box", "--trials", "3", "--seed", "40", "--json", *SHORT]


class Output(CliTest):
    def start(self, *arguments):
        environment = dict(os.environ, PALPATE_CACHE=str(self.cache))
        process = subprocess.Popen(
            [cli.PROGRAM, *arguments], cwd=self.folder, env=environment,
            stdout=subprocess.DEVNULL, stderr=subprocess.PIPE, text=True,
        )  # fmt: skip
        self.addCleanup(process.stderr.close)
        self.addCleanup(process.kill)
        return process

    def read(self, name):
        return (self.folder / name).read_bytes()

    def test_two_picks_do_not_share_a_folder(self):
        first, second = [self.start(*PICK, "--seed", seed) for seed in ("1", "2")]
        errors = {seed: run.communicate(timeout=120)[1] for seed, run in
                  (("1", first), ("2", second))}  # fmt: skip
        codes = {"1": first.returncode, "2": second.returncode}
        refused = [seed for seed, code in codes.items() if code == BAD_INPUT]
        self.assertEqual(len(refused), 1, (codes, errors))
        # In use, or there already where the other was quicker than this one's start.
        self.assertRegex(errors[refused[0]], "run")
        kept = ({"1", "2"} - set(refused)).pop()
        self.assertEqual(json.loads(self.read("run/report.json"))["seed"], int(kept))
        replayed = self.run_program("replay", "run/recording.h5").returncode
        self.assertIn(replayed, (DONE, NO_SOLUTION))  # the file is whole; so short a pick may fail

        whole = self.read("run/recording.h5")
        self.assert_refused(BAD_INPUT, [*PICK, "--seed", refused[0]], "--force")
        self.assertEqual(self.read("run/recording.h5"), whole)
        self.run_program(*PICK, "--seed", refused[0], "--force")
        self.assertNotEqual(self.read("run/recording.h5"), whole)
        self.run_program(*PICK, "--seed", kept, "--force")
        self.assertEqual(self.read("run/recording.h5"), whole)  # byte for byte

    def test_closed_streams_take_no_results(self):
        """A file that is opened then has the number of one of them."""
        self.assertIn(self.run_program(*PICK, "--seed", "1").returncode, (DONE, NO_SOLUTION))
        whole = self.read("run/recording.h5")
        for closed in (">&-", "2>&-", ">&- 2>&-", "<&- >&- 2>&-"):
            environment = dict(os.environ, PALPATE_CACHE=str(self.cache))
            command = ["sh", "-c", f'exec "$@" {closed}', "sh", cli.PROGRAM, *PICK, "--seed", "1", "--force"]
            done = subprocess.run(command, cwd=self.folder, env=environment, capture_output=True, timeout=120)
            self.assertEqual(done.returncode == BAD_INPUT, ">&-" in closed.split(), (closed, done.stderr))
            self.assertEqual(self.read("run/recording.h5"), whole, closed)

    def test_an_evaluation_that_is_killed_goes_on_and_ends_alike(self):
        self.assertEqual(self.run_program(*EVAL, "--out", "whole").returncode, DONE)
        chance = random.Random(7)
        for _ in range(6):
            run = self.start(*EVAL, "--out", "part")
            time.sleep(chance.uniform(0.1, 4))
            run.send_signal(signal.SIGKILL)
            run.wait(timeout=60)
        self.assertEqual(self.run_program(*EVAL, "--out", "part").returncode, DONE)
        for name in ["eval.json", "trials.csv", "config.toml"]:
            self.assertEqual(self.read(f"part/{name}"), self.read(f"whole/{name}"), name)
        self.assertEqual(sorted(path.name for path in (self.folder / "part").iterdir()),
                         sorted(path.name for path in (self.folder / "whole").iterdir()))

        rows = self.read("part/trials.csv")
        other = [*EVAL, "--out", "part", "--set", "lift.height=0.11"]
        self.assert_refused(BAD_INPUT, other, "trials.jsonl", "--force")
        self.assertEqual(self.read("part/trials.csv"), rows)
        self.assert_refused(BAD_INPUT, [*EVAL, "--out", "none", "--resume"], "none")

    def test_a_campaign_goes_on_only_from_its_own_rows(self):
        campaign = ["eval", "--faults", "--object", "box", "--trials", "1", "--json", *SHORT,
                    "--out", "campaign", "--resume"]  # fmt: skip
        (self.folder / "campaign").mkdir()
        rows = self.folder / "campaign" / "faults.json"
        rows.write_text(json.dumps({"configuration": "another", "faults": {}}))
        self.assert_refused(BAD_INPUT, campaign, "faults.json", "other settings")
        for text in ("{", "[]", '{"configuration": 1'):
            rows.write_text(text)
            self.assert_refused(BAD_INPUT, campaign, "faults.json", "damaged")
            self.assertEqual(rows.read_text(), text)

    def test_shares_of_an_evaluation_merge_into_that_of_one_run(self):
        both = [*EVAL, "--object", "bracket"]  # box, bracket
        self.run_program(*both, "--out", "whole")
        for i in (1, 2, 3):
            self.run_program(*both, "--shard", f"{i}/3", "--out", f"part{i}")
        merged = self.run_program("merge", "part1", "part3/trials.jsonl", "part2", "--out", "all",
                                  "--json")  # fmt: skip
        self.assertEqual(merged.returncode, DONE, merged.stderr)
        for name in ["eval.json", "trials.csv"]:  # trials.jsonl holds wall times, too
            self.assertEqual(self.read(f"all/{name}"), self.read(f"whole/{name}"), name)
        self.assertEqual(merged.stdout.encode(), self.read("whole/eval.json"))
        for name in ("config.toml", "manifest.json"):  # of another evaluation
            self.write(f"all/{name}", "old")
        again = self.run_program("merge", "part1", "part2", "part3", "--out", "all", "--force")
        self.assertEqual(sorted(path.name for path in (self.folder / "all").iterdir()),
                         ["eval.json", "trials.csv", "trials.jsonl"])
        expected = f"Next: palpate pick --object box {' '.join(SHORT)} --seed 40 repeats".replace("--quiet ", "")
        self.assertIn(expected, again.stdout)
        twice = self.run_program("merge", "part2", "part1", "part3", "part1", "--out", "twice", "--json")
        self.assertEqual(twice.stdout, merged.stdout)

        self.assert_refused(BAD_INPUT, ["merge", "part1", "part2"], "2 of 6 trials are missing")
        # The same trial of another program, or of a machine that computes otherwise.
        header, *trials = (self.folder / "part1/trials.jsonl").read_text().splitlines()
        trials = [json.loads(line) for line in trials]
        for trial in trials:
            trial["trial"]["robot_seconds"] += 0.01
        self.write("odd.jsonl", "\n".join([header, *map(json.dumps, trials), ""]))
        self.assert_refused(BAD_INPUT, ["merge", "part1", "odd.jsonl", "part2", "part3"],
                            "odd.jsonl", f"seed {trials[0]['seed']}", "different programs")  # fmt: skip
        self.write("endless.jsonl", json.dumps({**json.loads(header), "trials": 10**18}) + "\n")
        self.assert_refused(BAD_INPUT, ["merge", "endless.jsonl"], "endless.jsonl", "a plan of 1000000000000000000 trials")
        self.run_program(*EVAL, "--out", "other")
        self.assert_refused(BAD_INPUT, ["merge", "part1", "other"], "other settings")
        self.assert_refused(BAD_INPUT, [*both, "--shard", "4/3", "--out", "new"], "4/3")
        self.assert_refused(BAD_INPUT, [*both, "--shard", "1/3"], "--out")

    def test_what_cannot_be_is_refused_before_earlier_results_are_lost(self):
        self.write("part.stl", cli.box_stl(0.06, 0.05, 0.08))
        kept = self.folder / "kept"
        kept.mkdir()
        results = ["trials.jsonl", "trials.csv", "eval.json", "faults.json", "recording.h5", "report.json"]
        for name in results:
            (kept / name).write_text("kept")
        walled = ["--at", "0.25,0.15", "--place", "fixture"]
        for arguments in (
            ["eval", "--candidates", "part.stl,nosuch.stl"],
            ["eval", "--candidates", "generated:0-10"],
            ["eval", "--candidates", "box,mug", "--mass", "0.2"],
            ["eval", *walled],
            ["pick", *walled],
            ["eval", "--set", "expert.fault.kind=nonsense"],
            ["pick", "--set", "expert.fault.kind=nonsense"],
            ["pick", "--true-object", "box", "--place", "random"],
            ["eval", "--faults", "load_nan", "--set", "start.stable_pose=99"],
        ):
            self.assert_refused(BAD_INPUT, [*arguments, "--object", "part.stl", "--out", "kept", "--force"])
            self.assertEqual([(kept / name).read_text() for name in results], len(results) * ["kept"])
            self.assert_refused(BAD_INPUT, [*arguments, "--object", "part.stl", "--out", "new"])

    def test_an_evaluation_goes_on_only_with_the_same_meshes_and_program(self):
        self.write("part.stl", cli.box_stl(0.06, 0.05, 0.08))
        shards = ["eval", "--object", "part.stl", "--candidates", "part.stl,mug", "--trials", "2",
                  "--seed", "40", "--json", *SHORT]  # fmt: skip
        for i in (1, 2):
            self.run_program(*shards, "--shard", f"{i}/2", "--out", f"part{i}")
            self.write("part.stl", cli.box_stl(0.06, 0.05, 0.09))
        self.assert_refused(BAD_INPUT, ["merge", "part1", "part2"], "part1", "part2", "other settings")
        self.assert_refused(BAD_INPUT, [*shards, "--shard", "1/2", "--out", "part1", "--resume"], "other settings")

        header, *trials = (self.folder / "part2/trials.jsonl").read_text().splitlines()
        other = json.dumps(json.loads(header) | {"commit": "of before"})
        self.write("before.jsonl", "\n".join([other, *trials, ""]))
        self.assert_refused(BAD_INPUT, ["merge", "part2", "before.jsonl"], "of before", "built from")
        foreign = json.dumps(json.loads(trials[0]) | {"seed": 4000})
        self.write("foreign.jsonl", "\n".join([header, *trials, foreign, ""]))
        self.assert_refused(BAD_INPUT, ["merge", "part2", "foreign.jsonl"], "part.stl with seed 4000")
        changed = json.loads(trials[0])
        changed["trial"]["weights"] = [*changed["trial"]["weights"], 0.5]
        self.write("changed.jsonl", "\n".join([header, json.dumps(changed), ""]))
        self.assert_refused(BAD_INPUT, ["merge", "part2", "changed.jsonl"], "different programs")

    def test_an_evaluation_takes_no_folder_of_another_command(self):
        (self.folder / "run").mkdir()
        self.write("run/config.toml", "kept")
        self.assert_refused(BAD_INPUT, [*EVAL, "--out", "run"], "run/config.toml is of another run", "--force")
        self.assertEqual(self.read("run/config.toml"), b"kept")

    def test_half_a_line_of_a_killed_run_is_dropped(self):
        self.run_program(*EVAL, "--out", "whole")
        report, lines = self.read("whole/eval.json"), self.read("whole/trials.jsonl")
        for cut in [len(lines) - 1, len(lines) // 2, 20, 0]:
            (self.folder / "whole/trials.jsonl").write_bytes(lines[:cut])
            self.assertEqual(self.run_program(*EVAL, "--out", "whole").returncode, DONE)
            self.assertEqual(self.read("whole/eval.json"), report)
            self.assertEqual(len(self.read("whole/trials.jsonl").splitlines()), 4)

    def test_a_full_disk_is_named_and_seals_nothing(self):
        # A small disk of its own: who is not root is so in a namespace.
        alone = ["unshare", "--mount", *([] if os.geteuid() == 0 else ["--map-root-user"])]
        mount = 'mkdir disk && mount -t tmpfs -o size=300k tmpfs disk && "$@"; code=$?; cp -r disk kept; exit $code'
        if subprocess.run([*alone, "mount", "-t", "tmpfs", "tmpfs", "/mnt"], capture_output=True).returncode != 0:
            self.skipTest("no small file system can be mounted here, neither as root nor in a namespace (unshare)")
        done = subprocess.run(
            [*alone, "sh", "-c", mount, "sh", cli.PROGRAM, "pick", "--object", "box", "--seed", "1",
             "--out", "disk/p", *SHORT],
            cwd=self.folder, env=dict(os.environ, PALPATE_CACHE=str(self.cache)), capture_output=True,
            text=True, timeout=300)  # fmt: skip
        self.assertEqual(done.returncode, BAD_INPUT, done.stderr)
        self.assertIn("No space left on device", done.stderr.splitlines()[0])
        kept = self.folder / "kept/p"
        self.assertFalse((kept / "recording.h5").exists())
        partial = (kept / "recording.h5.partial").read_bytes()
        self.assertNotIn(b"finished ", partial[:60].replace(b"unfinished", b""))


if __name__ == "__main__":
    main()
