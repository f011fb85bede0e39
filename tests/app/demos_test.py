# SPDX-License-Identifier: Apache-2.0
"""Demonstrations of the relocate task: made, kept as Minari reads them, and learnt from."""

import json
import pathlib

import cli

try:
    import numpy as np
except ImportError:  # Minari brings it; without that it is not needed
    np = None

QUICK = ["--seed", "1", "--quiet", "--set", "task.solver=fast"]


class DemosTest(cli.CliTest):
    def make(self, *more):
        return self.run_program("demos", "make", "--count", "1", "--out", "demos", *QUICK, *more)

    def test_made_and_learnt_from(self):
        done = self.make("--json")
        self.assertEqual(done.returncode, cli.DONE, done.stderr)
        report = json.loads(done.stdout)
        self.assertEqual(report["kept"], 1)
        self.assertLessEqual(
            {"kept", "tried", "return", "success_2cm", "seconds"}, report.keys())
        bc = self.run_program(
            "train", "relocate", "--method", "bc", "--demos", "demos", "--out", "bc", "--quiet",
            "--episodes", "2", "--set", "npg.episode.horizon=5", "--set", "bc.epochs=2",
        )  # fmt: skip
        self.assertEqual(bc.returncode, cli.DONE, bc.stderr)
        self.assertTrue((self.folder / "bc" / "policy.json").exists())
        self.read_with_minari()

    def read_with_minari(self):
        try:
            from minari.dataset.minari_dataset import MinariDataset
        except ImportError:
            print("minari is not installed: only the layout was checked, in test_learning")
            return
        dataset = MinariDataset(str(self.folder / "demos" / "data"))
        self.assertEqual(dataset.total_episodes, 1)
        episode = dataset[0]
        self.assertEqual(episode.observations.shape[0], episode.actions.shape[0] + 1)
        self.assertEqual(episode.observations.shape[1:], (39,))
        self.assertTrue(episode.truncations[-1])
        self.assertEqual(dataset.env_spec.id, "Palpate/Relocate-v2")
        self.assertEqual(episode.infos["truth"].shape, (episode.observations.shape[0], 37))
        self.recover(dataset)

    def recover(self, dataset):
        """The environment repeats the episode from its seed, where the Python package is there."""
        try:
            env = dataset.recover_environment()
        except ImportError:
            print("palpate.sim is not there: the environment was not recovered")
            return
        episode = dataset[0]
        (stored,) = dataset.storage.get_episode_metadata([0])
        observation, info = env.reset(seed=int(stored["seed"]))
        rewards = []
        np.testing.assert_allclose(observation, episode.observations[0], atol=1e-12)
        np.testing.assert_allclose(info["truth"], episode.infos["truth"][0], atol=1e-12)
        for action in episode.actions:
            observation, reward, _, truncated, _ = env.step(action)
            rewards.append(reward)
        self.assertTrue(truncated)
        np.testing.assert_allclose(rewards, episode.rewards, atol=1e-9)
        np.testing.assert_allclose(observation, episode.observations[-1], atol=1e-9)

    def test_fewer_than_asked_for_are_reported(self):
        short = 0
        for seed in map(str, range(1, 9)):
            done = self.run_program("demos", "make", "--count", "2", "--out", "d", "--force", "--json",
                                    "--quiet", "--seed", seed, "--set", "task.solver=fast")  # fmt: skip
            if done.returncode == cli.NO_SOLUTION:
                continue
            report = json.loads(done.stdout)
            self.assertLessEqual(report["tried"], 8)
            said = f"only {report['kept']} of 2 demonstrations: of {report['tried']} sequences"
            self.assertEqual(said in done.stderr, report["kept"] < 2, done.stderr)
            short += report["kept"] < 2
            if short:
                break
        self.assertGreater(short, 0)

    def test_nothing_that_succeeds(self):
        done = self.make(
            "--set", "demonstration.human.grip_radius=0.06",
            "--set", "demonstration.translation.press=0",
        )  # fmt: skip
        self.assertEqual(done.returncode, cli.NO_SOLUTION, done.stderr)
        self.assertEqual(done.stderr.count("\n"), 1, done.stderr)

    def test_retarget(self):
        data = pathlib.Path(__file__).parent.parent / "data" / "hand_joints.csv"
        report = self.run_json("demos", "retarget", str(data), "--out", "r")
        self.assertLessEqual(report["tip_error_mm"], 5)
        self.assertLessEqual(report["middle_error_mm"], 7)
        self.assertLessEqual(report["largest_step_rad"], 0.3)
        lines = (self.folder / "r" / "joints.csv").read_text().splitlines()
        self.assertEqual(len(lines), 1 + report["frames"])

    def test_bad_input(self):
        (self.folder / "bad.csv").write_text("a,b\n1,2\n")
        (self.folder / "empty").mkdir()
        for arguments, named in [
            (["demos", "make"], "--out"),
            (["demos", "retarget", "bad.csv"], "bad.csv:1"),
            (["demos", "retarget", "missing.csv"], "missing.csv"),
            (["train", "relocate", "--method", "bc", "--demos", "empty", "--out", "x"],
             "metadata.json"),
            (["train", "relocate", "--method", "npg", "--demos", "empty", "--out", "x"], "--demos"),
        ]:
            done = self.run_program(*arguments)
            self.assertEqual(done.returncode, cli.BAD_INPUT, arguments)
            self.assertIn(named, done.stderr)
            self.assertEqual(done.stderr.count("\n"), 1, done.stderr)


if __name__ == "__main__":
    cli.main()
