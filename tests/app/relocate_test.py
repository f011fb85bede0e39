# SPDX-License-Identifier: Apache-2.0
"""Training, rolling out and comparing policies of the relocate task."""

import json
import os
import shutil
import signal
import subprocess
import time

import cli

TINY = [
    "--set", "cem.search.cem.population=4", "--set", "cem.search.cem.elite=2",
    "--set", "cem.search.screening=1", "--set", "cem.search.episodes=1",
    "--set", "cem.search.episode.horizon=5", "--episodes", "2",
]  # fmt: skip


class RelocateTest(cli.CliTest):
    def train(self, out, iterations, *more):
        return self.run_program(
            "train", "relocate", "--out", out, "--iterations", str(iterations), "--seed", "3",
            "--quiet", *TINY, *more,
        )  # fmt: skip

    def test_train_rollout_compare(self):
        done = self.train("a", 2)
        self.assertEqual(done.returncode, cli.DONE, done.stderr)
        notes = json.loads((self.folder / "a" / "policy.json").read_text())["notes"]
        self.assertEqual(
            notes["command"],
            "palpate train relocate --method cem --iterations 2 --seed 3 "
            + " ".join(word for word in TINY if word not in ("--episodes", "2")),
        )
        for name in ("policy.json", "curves.csv", "elite.svg", "config.toml", "report.json"):
            self.assertTrue((self.folder / "a" / name).exists(), name)
        few = ["--episodes", "3", "--set", "episode.horizon=10", "--set", "task.solver=fast"]
        report = self.run_json("rollout", "a/policy.json", *few, "--out", "r")
        self.assertLessEqual(
            {"episodes", "return", "success_10cm", "success_5cm", "success_2cm",
             "steps_per_second", "observes"}, report.keys())  # fmt: skip
        self.assertEqual(set(report["return"]), {"mean", "sd", "ci95"})
        self.assertIn("base_velocity", report["observes"])
        two = self.run_json("rollout", "a/policy.json", *few, "--threads", "2", "--task",
                            "relocate-v2")
        for changing in (report, two):
            changing.pop("steps_per_second")
        self.assertEqual(report, two)
        self.run_json("rollout", "a/policy.json", *few, "--seed", "5", "--out", "s")
        compared = self.run_json("compare", "r/episodes.csv", "s/episodes.csv", "--out", "c")
        self.assertLessEqual(
            {"normality", "bartlett_p", "anova_p", "welch_p", "mann_whitney_p", "difference",
             "valid_test"}, compared.keys())  # fmt: skip
        self.assertTrue((self.folder / "c" / "normal-plot.svg").exists())

    def test_a_policy_may_be_given_what_touch_estimates(self):
        few = ["--episodes", "1", "--set", "episode.horizon=40", "--set", "touch.explore=false"]
        report = self.run_json("rollout", "--touch", *few)
        self.assertEqual(
            set(report["touch"]),
            {"explored", "explore_seconds", "resting_error_mm", "reported_error_mm", "estimates",
             "estimate_seconds"},  # fmt: skip
        )
        self.assertIn("object_position_by_touch", report["observes"])
        self.assertGreater(report["touch"]["estimates"], 0)
        self.assertGreater(report["touch"]["resting_error_mm"], 0)
        self.assertEqual(report["touch"]["explored"], 0)
        given_the_truth = self.run_json("rollout", *few)
        self.assertNotIn("touch", given_the_truth)

    def test_an_episode_by_touch_is_recorded_seen_and_estimated_again(self):
        few = ["--episodes", "1", "--set", "episode.horizon=60", "--set", "touch.explore=false"]
        report = self.run_json("rollout", "relocate-robust", "--touch", *few, "--record", "1",
                               "--out", "r")  # fmt: skip
        self.assertGreater(report["touch"]["estimates"], 0)
        done = self.run_program("view", "r/episode-0.h5", "--out", "page")
        self.assertEqual(done.returncode, cli.DONE, done.stderr)
        drawn = self.run_json("render", "r/episode-0.h5", "--size", "64x48", "--out", "drawn")
        self.assertEqual([one["phase"] for one in drawn["files"]][0], "reach")
        done = self.run_program("render", "r/episode-0.h5", "--posterior", "--out", "film")
        self.assertEqual(done.returncode, cli.BAD_INPUT)
        self.assertIn("r/episode-0.h5 is an episode of the relocate task", done.stderr)
        again = self.run_json("replay", "r/episode-0.h5")
        self.assertEqual(again["messages"], 60)
        self.assertGreater(again["modes"][0]["weight"], 0)
        wider = self.run_json("replay", "r/episode-0.h5", "--set",
                              "touch.tracking.translation_sigma=0.02")  # fmt: skip
        self.assertNotEqual(wider["modes"][0]["T_world_object"], again["modes"][0]["T_world_object"])
        done = self.run_program("replay", "r/episode-0.h5", "--set", "task.mass_scale=2")
        self.assertEqual(done.returncode, cli.BAD_INPUT)
        self.assertIn("task.mass_scale = 2.0: of an episode by touch a replay reads touch.tracking.*",
                      done.stderr)  # fmt: skip
        expert = "expert.touch.tracking.estimation.surface_sigma=0.001"
        self.run_json("replay", "r/episode-0.h5", "--set", expert)
        self.run_json("rollout", "relocate-robust", *few[:4], "--record", "1", "--out", "t")
        done = self.run_program("replay", "t/episode-0.h5")
        self.assertEqual(done.returncode, cli.BAD_INPUT)
        self.assertIn("an episode with the true pose of the object", done.stderr)

    def test_a_killed_training_goes_on(self):
        self.assertEqual(self.train("whole", 5).returncode, cli.DONE)
        command = [cli.PROGRAM, "train", "relocate", "--out", "part", "--iterations", "5",
                   "--seed", "3", "--quiet", *TINY]  # fmt: skip
        process = subprocess.Popen(
            command, cwd=self.folder, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL
        )
        while not list(self.folder.glob("part/*")) and process.poll() is None:  # its first file
            time.sleep(0.001)
        process.send_signal(signal.SIGKILL)
        process.wait()
        self.assertEqual(self.train("part", 5).returncode, cli.DONE)
        policies = [(self.folder / name / "policy.json").read_text() for name in ("whole", "part")]
        self.assertEqual(*policies)

    def test_a_training_overwrites_nothing_of_others(self):
        gradient = ["--set", "npg.trajectories=2", "--set", "npg.evaluation=1", "--set", "npg.episode.horizon=5"]
        dagger = ["--set", "dagger.rounds=1", "--set", "dagger.episodes=1", "--set", "dagger.samples=10",
                  "--set", "dagger.episode.horizon=5"]  # fmt: skip
        for method, more in (("cem", ["--iterations", "1"]), ("npg", ["--iterations", "1", *gradient]),
                             ("dagger", dagger)):  # fmt: skip
            command = ["train", "relocate", "--method", method, "--quiet", *TINY, *more]
            self.assertEqual(self.run_program(*command, "--out", method).returncode, cli.DONE, method)
            results = {path.name for path in (self.folder / method).iterdir()} - {"checkpoint"}
            self.assertLessEqual({"policy.json", "curves.csv", "report.json", "config.toml"}, results)
            for name in sorted(results | {"ask.jsonl", "scores-1-of-2.jsonl"}):
                (self.folder / "other").mkdir()
                self.write(f"other/{name}", "mine")
                self.assert_refused(cli.BAD_INPUT, [*command, "--out", "other"], name, "--force")
                shutil.rmtree(self.folder / "other")
            self.assertEqual(self.run_program(*command, "--out", method).returncode, cli.DONE)  # goes on
        (self.folder / "npg" / "checkpoint").unlink()
        again = [*command[:3], "npg", "--from", "npg/policy.json", "--out", "npg"]
        self.assert_refused(cli.BAD_INPUT, again, "npg/policy.json is there already")
        self.assert_refused(cli.BAD_INPUT, [*again, "--force"], "would remove npg/policy.json")

    def test_force_starts_over_without_the_scores_of_the_search_before(self):
        self.train("a", 1, "--ask")
        self.train("a", 1, "--score", "1/1")
        self.assertEqual(self.train("a", 1, "--ask", "--force").returncode, cli.DONE)
        self.assertEqual(list((self.folder / "a").glob("scores-*")), [])

    def test_a_policy_says_what_was_done(self):
        self.assertEqual(self.train("a b", 2).returncode, cli.DONE)
        (self.folder / "a b" / "report.json").unlink()
        self.assertEqual(self.train("a b", 1).returncode, cli.DONE)  # has done more
        notes = json.loads((self.folder / "a b" / "policy.json").read_text())["notes"]
        self.assertEqual(notes["iterations"], "2")
        self.assertIn("--iterations 2 ", notes["command"])
        self.assertNotIn("steps_per_second", json.loads((self.folder / "a b" / "report.json").read_text()))
        arguments = ["train", "relocate", *TINY, "--iterations", "1", "--from", "a b/policy.json"]
        done = self.run_program(*arguments, "--out", "c d")
        self.assertIn("Next: palpate rollout 'c d/policy.json'\n", done.stdout)
        self.assertRegex(done.stderr, r"(^|\n)iteration +0 ")
        self.assertEqual((self.folder / "c d" / "curves.csv").read_text().splitlines()[1].split(",")[0], "0")
        command = json.loads((self.folder / "c d" / "policy.json").read_text())["notes"]["command"]
        self.assertIn(" --from 'a b/policy.json' ", command)

    def test_a_spread_that_is_raised_is_said(self):
        command = ["train", "relocate", "--method", "npg", "--iterations", "1", "--episodes", "2", "--set",
                   "npg.trajectories=2", "--set", "npg.evaluation=1", "--set", "npg.episode.horizon=5"]
        self.assertNotIn("raised", self.run_program(*command, "--out", "a").stderr)
        raised = self.run_program(*command, "--out", "b", "--set", "bc.log_std=-4").stderr
        self.assertIn("log_std of 30 of 30 actions is raised to npg.min_log_std = -3", raised)

    def test_a_rollout_overwrites_nothing_of_others(self):
        few = ["rollout", "--set", "episode.horizon=5", "--set", "task.solver=fast", "--out", "r"]
        self.run_program(*few, "--episodes", "3", "--record", "3")
        for name in ("rollout.json", "episodes.csv", "config.toml"):
            (self.folder / "r" / name).unlink()
        one = [*few, "--episodes", "1", "--record", "1"]
        self.assert_refused(cli.BAD_INPUT, one, "r/episode-0.h5 is there already")
        self.write("r/episode-mine.h5", "mine")
        self.assertEqual(self.run_program(*one, "--force").returncode, cli.DONE)
        recordings = sorted(path.name for path in (self.folder / "r").glob("*.h5"))
        self.assertEqual(recordings, ["episode-0.h5", "episode-mine.h5"])

    def test_one_episode_has_no_spread(self):
        one = ["rollout", "--episodes", "1", "--set", "episode.horizon=5", "--set", "task.solver=fast"]
        report = self.run_json(*one)["return"]
        self.assertEqual((report["sd"], report["ci95"]), (None, None))
        self.assertRegex(self.run_program(*one).stdout, r"return +-?\d+ \+- -, mean within - \(95 %\)")

    def test_errors_of_observation_without_effect_are_refused(self):
        self.assert_refused(cli.BAD_INPUT, ["rollout", "--set", "episode.observation_period=0.004", "--out", "r"],
                            "observation_period = 0.004 s")
        for key in ("object_bias", "observation_period"):
            self.assert_refused(cli.BAD_INPUT, ["rollout", "--touch", "--set", f"episode.{key}=0.01", "--out", "r"],
                                f"episode.{key} = 0.01 is of no use")

    def write_returns(self, name, values):
        rows = "".join(f"{value},0.01,30,0\n" for value in values)
        (self.folder / name).write_text("return,distance,steps_within_5cm,diverged\n" + rows)

    def test_of_several_trainings_each_is_one_value(self):
        for k in range(3):
            self.write_returns(f"a{k}.csv", [10 + k, 20 + k, 30 + k])
            self.write_returns(f"b{k}.csv", [50 + k, 70 + k])
        several = ["compare", "a0.csv,a1.csv,a2.csv", "b0.csv,b1.csv,b2.csv"]
        report = self.run_json(*several, "--out", "c")
        self.assertIn("share of trainings", (self.folder / "c" / "histogram.svg").read_text())
        for name in ("compare.json", "histogram.svg", "normal-plot.svg"):
            (self.folder / "d").mkdir(exist_ok=True)
            self.write(f"d/{name}", "mine")
            self.assert_refused(cli.BAD_INPUT, [*several, "--out", "d"], name, "--force")
            (self.folder / "d" / name).unlink()
        self.assertEqual(report["unit"], "training")
        self.assertEqual(report["mean"], {"a": 21, "b": 61})
        self.assertEqual(report["interquartile_mean"]["a"]["value"], 21)
        self.assertEqual(report["valid_test"], "mann_whitney")
        self.assertAlmostEqual(report["mann_whitney_p"], 0.1)
        done = self.run_program("compare", "a0.csv", "b0.csv,b1.csv")
        self.assertEqual(done.returncode, cli.BAD_INPUT)
        self.assertIn("1 trainings against 2", done.stderr)
        self.assert_refused(cli.BAD_INPUT, ["compare", "a0.csv,a0.csv", "b0.csv,b1.csv"], "a0.csv is given twice")

    def test_returns_whose_squares_cannot_be_computed_are_refused(self):
        self.write_returns("a.csv", [1, 2, 3])
        for value in ("1e300", "-1e300", "1e13", "1e-160"):
            self.write_returns("huge.csv", [1, value, 3])
            self.assert_refused(cli.BAD_INPUT, ["compare", "huge.csv", "a.csv"], "huge.csv:3: a return of")

    def test_files_of_other_programs_are_read(self):
        self.write_returns("a.csv", [1, 2, 3])
        self.write_returns("b.csv", [4, 6, 5])
        report = self.run_json("compare", "a.csv", "b.csv")
        text = (self.folder / "a.csv").read_text()
        self.write("crlf.csv", text.replace("\n", "\r\n"))
        self.write("marked.csv", "\ufeff" + text)
        for name in ("crlf.csv", "marked.csv"):
            self.assertEqual(self.run_json("compare", name, "b.csv"), report, name)

    def test_a_pipe_is_read_once(self):
        self.write_returns("a.csv", [1, 2, 3])
        self.write_returns("b.csv", [4, 6, 5])
        os.mkfifo(self.folder / "pipe.csv")
        command = [cli.PROGRAM, "compare", "pipe.csv", "b.csv", "--json"]
        with subprocess.Popen(command, cwd=self.folder, stdout=subprocess.PIPE, text=True) as process:
            (self.folder / "pipe.csv").write_text((self.folder / "a.csv").read_text())
            out = process.communicate(timeout=60)[0]
        self.assertEqual(json.loads(out), self.run_json("compare", "a.csv", "b.csv"))

    def test_both_names_are_checked_before_an_episode_is_run(self):
        command = ["compare", "relocate-best", "relocate-bets", "--episodes", "5000", "--out", "c"]
        self.assert_refused(cli.BAD_INPUT, command, "did you mean 'relocate-best'?")
        self.assert_refused(cli.BAD_INPUT, ["compare", "relocate-best", "none.csv", "--out", "c"], "none.csv")

    def test_what_is_no_policy_is_said(self):
        self.write("bad.stl", "solid x\nendsolid\n")
        self.assert_refused(cli.BAD_INPUT, ["rollout", "bad.stl"], "bad.stl is not a policy file: it is not JSON")
        self.write("other.json", "{}")
        self.assert_refused(cli.BAD_INPUT, ["rollout", "other.json"], "other.json is not a policy file", "'format'")

    def test_the_next_command_is_named(self):
        for k, name in enumerate(("a.csv", "b.csv")):
            self.write_returns(name, [5 + k, 6, 7])
        few = ["rollout", "--episodes", "1", "--set", "episode.horizon=10", "--set", "task.solver=fast"]
        for command, more in ((few, "--record 1 --out out/rollout records"),
                              (["compare", "a.csv", "b.csv"], "--out out/compare draws")):
            line = self.run_program(*command).stdout.splitlines()[-1]
            self.assertTrue(line.startswith(f"Next: palpate {' '.join(command)} {more}"), line)
            self.assertNotIn("Next:", self.run_program(*command, "--quiet").stdout)
            self.assertNotIn("Next:", self.run_program(*command, "--json").stdout)

    def test_constant_returns_are_explained(self):
        self.write_returns("a.csv", [5, 5, 5, 5])
        self.write_returns("b.csv", [7, 7, 7])
        report = self.run_json("compare", "a.csv", "b.csv", "--out", "c")
        self.assertIsNone(report["welch_p"])
        self.assertIn("nothing varies", report["reason"])
        self.assertEqual(report["difference"]["mean"], -2)
        done = self.run_program("compare", "a.csv", "b.csv")
        self.assertEqual(done.returncode, cli.DONE, done.stderr)

    def test_episodes_that_were_run_take_no_options_of_episodes(self):
        for name in ("a.csv", "b.csv"):
            rows = "".join(f"{i},0.01,30,0\n" for i in range(12))
            self.write(name, "return,distance,steps_within_5cm,diverged\n" + rows)
        for option in (["--episodes", "5"], ["--threads", "2"], ["--set", "task.size=1"]):
            self.assert_refused(cli.BAD_INPUT, ["compare", "a.csv", "b.csv", *option], option[0])

    def test_there_is_one_version_of_the_task(self):
        for command in (["rollout"], ["train", "relocate"], ["compare", "a", "b"]):
            done = self.run_program(*command, "--task", "relocate-v1")
            self.assertEqual(done.returncode, cli.USAGE, command)
            self.assertIn("relocate-v2", done.stderr)

    def test_bad_input(self):
        (self.folder / "bad.json").write_text('{"format": "palpate-policy"')
        (self.folder / "bad.csv").write_text("return,distance,steps_within_5cm,diverged\n1;2\n")
        for arguments, named in [
            (["rollout", "bad.json"], "bad.json"),
            (["rollout", "missing.json"], "missing.json"),
            (["rollout", "no-such-policy"], "relocate-memoryless"),
            (["rollout", "bad.json", "--set", "task.solver=magic"], "bad.json"),
            (["compare", "bad.csv", "bad.csv"], "bad.csv:2"),
            (["compare", "a.csv,,b.csv", "c.csv,d.csv"], "empty name"),
            (["train", "relocate"], "--out"),
            (["train", "relocate", "--out", "x", "--method", "bc", "--from", "y"], "--from"),
            (["train", "relocate", "--out", "x", "--method", "dagger", "--from", "y"], "--from"),
            (["train", "relocate", "--out", "x", "--expert", "y"], "--expert"),
            (["train", "relocate", "--out", "x", "--method", "npg", "--expert", "y"], "--expert"),
            (["train", "relocate", "--out", "x", "--method", "npg", "--demos", "y"], "--demos"),
            (["train", "relocate", "--out", "x", "--demonstrations", "9"], "--demonstrations"),
            (["train", "relocate", "--out", "x", "--method", "dagger", "--iterations", "3"],
             "--iterations"),
            (["train", "relocate", "--out", "x", "--method", "bc", "--iterations", "3"],
             "--iterations"),
            (["train", "relocate", "--out", "x", "--method", "bc", "--demos", "y", "--expert",
              "z"], "--expert"),
            (["rollout", "--record", "1", "--episodes", "1"], "--out"),
        ]:
            done = self.run_program(*arguments)
            self.assertEqual(done.returncode, cli.BAD_INPUT, arguments)
            self.assertIn(named, done.stderr)
            self.assertEqual(done.stderr.count("\n"), 1, done.stderr)

    def test_an_episode_can_be_looked_at(self):
        few = ["--episodes", "2", "--set", "episode.horizon=10", "--set", "task.solver=fast"]
        self.run_json("rollout", *few, "--record", "1", "--out", "r")
        self.assertFalse((self.folder / "r" / "episode-1.h5").exists())
        done = self.run_program("view", "r/episode-0.h5", "--out", "page")
        self.assertEqual(done.returncode, cli.DONE, done.stderr)
        self.assertTrue((self.folder / "page" / "replay.html").exists())
        sensed = self.run_json("sense", "r/episode-0.h5")
        self.assertEqual(sensed, {"streams": {}, "hint": "no finger touches anything in r/episode-0.h5"})

    def test_a_damaged_checkpoint_is_reported(self):
        self.assertEqual(self.train("a", 1).returncode, cli.DONE)
        checkpoint = self.folder / "a" / "checkpoint"
        checkpoint.write_bytes(checkpoint.read_bytes()[:-9])
        done = self.train("a", 2)
        self.assertEqual(done.returncode, cli.BAD_INPUT)
        self.assertIn("checkpoint", done.stderr)

    def test_many_machines_run_the_rollouts_of_one_search(self):
        more = ["--set", "cem.search.episodes=2"]  # two rounds a generation
        self.assertEqual(self.train("whole", 2, *more).returncode, cli.DONE)
        self.assertEqual(self.train("many", 2, *more, "--ask").returncode, cli.DONE)
        rounds = 0
        while (self.folder / "many/ask.jsonl").exists():
            lines = [json.loads(line) for line in (self.folder / "many/ask.jsonl").read_text().splitlines()]
            self.assertEqual(len(lines), 4 if rounds % 2 == 0 else 2)
            self.assertGreater(len(lines[0]["parameters"]), 1)
            if rounds == 0:
                done = self.train("many", 2, *more, "--tell")
                self.assertEqual(done.returncode, cli.BAD_INPUT)
                self.assertIn("4 of 4 rollouts are missing", done.stderr)
            for share in ("2/3", "1/3", "1/3", "3/3"):  # one twice: as started again
                done = self.train("many", 2, *more, "--score", share)
                self.assertEqual(done.returncode, cli.DONE, done.stderr)
            stale = self.folder / f"many/scores-stale{rounds}.jsonl"
            stale.write_text('{"generation": 99, "candidate": 0, "first_episode": 0, "results": []}\n')
            done = self.train("many", 2, *more, "--tell")
            self.assertEqual(done.returncode, cli.DONE, done.stderr)
            rounds += 1
        self.assertEqual(rounds, 4)
        for name in ("policy.json", "checkpoint", "curves.csv"):
            self.assertEqual((self.folder / "many" / name).read_bytes(),
                             (self.folder / "whole" / name).read_bytes(), name)  # fmt: skip
        self.assertFalse(list((self.folder / "many").glob("scores-*")))

    def test_shares_that_cannot_be_are_refused(self):
        for share in ("0/3", "4/3", "1", "1/3x"):
            self.train("a", 1, "--ask")
            done = self.train("a", 1, "--score", share)
            self.assertEqual((done.returncode, "--score" in done.stderr), (cli.BAD_INPUT, True), share)
        self.assertEqual(self.train("a", 1, "--score", "1/1").returncode, cli.DONE)
        scores = self.folder / "a/scores-1-of-1.jsonl"
        scores.write_text(scores.read_text()[:-40] + "\n")
        done = self.train("a", 1, "--tell")
        self.assertEqual(done.returncode, cli.BAD_INPUT)
        self.assertIn("scores-1-of-1.jsonl:", done.stderr)
        for more, word in ((["--score", "1/1", "--tell"], "one after another"),
                           (["--tell", "--force"], "--force"), (["--score", "1/1"], "begin with --ask"),
                           (["--tell"], "begin with --ask")):  # fmt: skip
            done = self.train("b", 1, *more)
            self.assertEqual(done.returncode, cli.BAD_INPUT)
            self.assertIn(word, done.stderr)
        self.assertFalse((self.folder / "b").exists())
        done = self.run_program("train", "relocate", "--method", "npg", "--out", "c", "--ask")
        self.assertEqual(done.returncode, cli.BAD_INPUT)
        self.assertIn("--ask", done.stderr)

    def test_other_settings_need_another_folder(self):
        self.assertEqual(self.train("a", 1).returncode, cli.DONE)
        done = self.train("a", 1, "--set", "cem.spread=2")
        self.assertEqual(done.returncode, cli.BAD_INPUT)
        self.assertIn("other settings", done.stderr)


if __name__ == "__main__":
    cli.main()
