# SPDX-License-Identifier: Apache-2.0
"""Usage, help and the commands that only look."""

import json
import os
import re
import signal
import subprocess

import cli
from cli import BAD_INPUT, DONE, USAGE, CliTest, main


class Usage(CliTest):
    def commands(self):
        """The names that the program's own help lists."""
        done = self.run_program("--help")
        self.assertEqual(done.returncode, DONE)
        names = re.findall(r"^  (\w+) ", done.stdout.partition("Subcommands:")[2], re.MULTILINE)
        self.assertIn("pick", names)
        return names

    def test_wrong_usage_ends_with_2(self):
        self.assert_refused(USAGE, ["pik"], "pik")
        self.assert_refused(USAGE, [])
        self.assert_refused(USAGE, ["pick", "--objekt", "mug"], "--objekt")
        self.assert_refused(USAGE, ["pick", "--seed", "many"], "many")
        self.assert_refused(USAGE, ["pick", "--seed", "-1"], "-1")
        self.assert_refused(USAGE, ["pick", "--threads", "0"], "--threads")
        self.assert_refused(USAGE, ["eval", "--trials", "0"], "0")
        self.assert_refused(USAGE, ["replay"], "RECORDING is required")

    def test_what_was_meant_is_suggested(self):
        self.assert_refused(USAGE, ["pik"], "there is no command 'pik'", "did you mean 'pick'?")
        self.assert_refused(USAGE, ["train", "relocat"], "'train relocat'", "'relocate'?")
        self.assert_refused(USAGE, ["pick", "--objekt", "mug"], "no option --objekt", "'--object'?")
        self.assert_refused(USAGE, ["pick", "mug"], "did you mean --object mug?")
        self.assert_refused(USAGE, ["merge"], "PART is required")
        self.assert_refused(USAGE, ["export", "lerobott", "x.h5"],
                            "FORMAT: 'lerobott' is none of mcap, lerobot, minari",
                            "did you mean 'lerobot'?")  # fmt: skip
        self.assert_refused(USAGE, ["train"], "no command is given")
        self.assert_refused(BAD_INPUT, ["pick", "--set", "x.zigzag=1"], "palpate options pick lists")
        self.assert_refused(BAD_INPUT, ["rollout", "relocate-bset"], "'relocate-best'?")

        self.assert_refused(BAD_INPUT, ["pick", "--hand", "shadw"], "did you mean 'shadow'?")
        self.assert_refused(BAD_INPUT, ["pick", "--arm", "ur1"], "did you mean 'ur10'?")
        self.assert_refused(BAD_INPUT, ["pick", "--set", "stance=1"], "stable_pose?")
        self.assert_refused(USAGE, ["--verison"], "palpate: there is no option --verison; did you mean '--version'?")
        self.assert_refused(BAD_INPUT, ["hand", "install", "shadw"], "did you mean 'shadow'?")
        self.assert_refused(BAD_INPUT, ["hand", "install", "shadow"], "need not be installed")
        faults = ["eval", "--trials", "1", "--faults"]
        self.assert_refused(BAD_INPUT, [*faults, "load_nna"], "no fault 'load_nna'; did you mean 'load_nan'?")
        self.assert_refused(BAD_INPUT, [*faults, "no_such"], "no fault 'no_such'; the faults are none, load_nan")

    def test_nothing_is_suggested_that_resembles_too_little(self):
        for key in ("nonsense", "x.y", "start.yaw"):
            self.assert_refused(BAD_INPUT, ["pick", "--set", f"{key}=1"],
                                f"unknown option {key}; palpate options pick lists the options")  # fmt: skip

    def test_nothing_is_suggested_that_resembles_by_its_dashes_alone(self):
        self.assert_refused(USAGE, ["render", "x.h5", "--phase", "lift"], "no option --phase; see")

    def test_help_is_a_command_too(self):
        self.assertEqual(self.run_program("help").stdout, self.run_program("--help").stdout)
        self.assertEqual(self.run_program("help", "hand", "check").stdout,
                         self.run_program("hand", "check", "--help").stdout)  # fmt: skip
        self.assert_refused(USAGE, ["help", "pik"], "there is no command 'pik'", "'pick'?")
        self.assert_refused(USAGE, ["help", "nope"], "'nope'; the commands are pick, eval, merge")
        self.assert_refused(USAGE, ["train", "nope"], "the commands of palpate train are")
        self.assert_refused(USAGE, ["help", "pick", "extra"], "help takes one command, and 'pick extra' is none;")

    def test_what_is_missing_is_named(self):
        for option in ("--config", "--seed", "--mass", "--object", "--explore"):
            self.assert_refused(USAGE, ["pick", option], f"palpate: {option} needs a value;")
        self.assert_refused(USAGE, ["register", "a", "b", "--gravity", "1"], "--gravity needs 3 values, and has 1")
        self.assert_refused(USAGE, ["view"], "RECORDING or --live is required")
        self.assert_refused(BAD_INPUT, ["pick", "--set", "=3"], "'=3' has no key", "KEY=VALUE")
        self.assert_refused(USAGE, ["view", "a", "b", "c"], "at most 2 are possible, 3 are given")
        self.assert_refused(BAD_INPUT, ["sense", "none.csv"], "none.csv does not exist")
        self.assert_refused(BAD_INPUT, ["export", "mcap", "x.h5", "--out", "no/such/a.mcap"],
                            "there is no folder no/such for a.mcap")  # fmt: skip

    def test_an_argument_of_any_length_is_refused(self):
        self.assert_refused(USAGE, ["localize", "mug", "--method", 100_000 * "a"], "--method: ", "aaa", "fast")
        self.assert_refused(USAGE, [100_000 * "a"], "there is no command")

    def test_a_path_that_names_nothing_is_bad_input(self):
        (self.folder / "loop").symlink_to("loop")
        for path, why in (("loop", "symbolic links"), (5000 * "a", "too long")):
            self.assert_refused(BAD_INPUT, ["replay", path], path, why)
            self.assert_refused(BAD_INPUT, ["merge", path], path, why)

    def test_files_that_are_no_text_are_refused_as_options(self):
        """The error comes out of a shared library that was linked beside another C++ runtime."""
        for number, data in enumerate([b"\xff\xfe\0", b'attempts = "\xff"', b"attempts = 3\0", b"\x80" * 999]):
            name = self.write(f"{number}.toml", data)
            for command in (["pick"], ["plan", "x"], ["localize", "box", "x"], ["rollout"]):
                self.assert_refused(BAD_INPUT, [*command, "--config", name], f"{name}:1: ")

    def test_values_out_of_range_are_named_with_the_range(self):
        self.assert_refused(USAGE, ["pick", "--mass", "9"], "--mass: 9 is outside 0.001 to 5")
        self.assert_refused(USAGE, ["pick", "--seed", "many"], "'many' is not a whole number")
        self.assert_refused(USAGE, ["pick", "--seed", "-1"], "-1 is below 0")
        self.assert_refused(USAGE, ["pick", "--explore", "1.5"], "'1.5' is not a whole number")
        self.assert_refused(USAGE, ["view", "x", "--port", "99999"], "99999 is outside 0 to 65535")
        self.assert_refused(USAGE, ["pick", "--seed", "9" * 30], "9" * 30 + " is beyond the largest number")
        self.assert_refused(USAGE, ["pick", "--seed", "9" * 30 + "x"], "is not a whole number")
        self.assert_refused(BAD_INPUT, ["eval", "--object", "box", "--candidates", "mug,box", "--place", "random",
                                        "--out", "new"], "--candidates mug,box cannot be combined with --place random")

    def test_an_object_that_is_given_twice_is_refused(self):
        for objects, named in (("box,box", "box"), ("generated:1-3,generated:2", "generated:2")):
            for more in ([], ["--faults", "load_nan"]):
                self.assert_refused(BAD_INPUT, ["eval", "--object", objects, "--out", "new", *more],
                                    named + " is given twice")

    def test_help_is_at_most_100_columns_wide_and_names_defaults(self):
        for command in self.commands():
            for line in self.run_program(command, "--help").stdout.splitlines():
                if not line.startswith("  palpate "):  # examples are kept whole, to be copied
                    self.assertLessEqual(len(line), 101, (command, line))
        text = self.run_program("eval", "--help").stdout
        self.assertIn("--trials N ", text)
        self.assertIn("(default: 30; 1 to 1000000)", text)

    def test_values_in_help_say_what_they_are(self):
        for command in (*((name,) for name in self.commands()), ("bench", "contact"), ("ros2", "pick"), ("ros2", "robot"),
                        ("ros2", "estimate"), ("train", "relocate"), ("train", "biotac-normal"), ("demos", "make"),
                        ("demos", "retarget"), ("hand", "check"), ("hand", "render")):  # fmt: skip
            self.assertNotRegex(self.run_program(*command, "--help").stdout, r"--[\w-]+ TEXT\b", command)

    def test_version(self):
        done = self.run_program("--version")
        self.assertEqual(done.returncode, DONE)
        self.assertRegex(done.stdout, r"^\d+\.\d+\.\d+")

    def test_help_of_every_command_has_examples(self):
        for command in self.commands():
            done = self.run_program(command, "--help")
            self.assertEqual(done.returncode, DONE, command)
            self.assertEqual(done.stderr, "", command)
            examples = done.stdout.partition("Examples:")[2]
            self.assertIn(f"palpate {command}", examples)


class CommandsTest(CliTest):
    def all_commands(self, path=()):
        """The words of each command, those of subcommands after their command."""
        text = self.run_program(*path, "--help").stdout
        names = text.partition("Subcommands:\n")[2].partition("\n\n")[0]
        if path:
            yield list(path)
        for name in re.findall(r"^  ([\w-]+) ", names, re.MULTILINE):
            yield from self.all_commands((*path, name))


class WholeNumbers(CommandsTest):
    def test_a_leading_zero_changes_nothing(self):
        few = ["rollout", "--set", "episode.horizon=5", "--set", "task.solver=fast"]
        reports = [self.run_json(*few, "--episodes", count, "--seed", seed)
                   for count, seed in (("010", "010"), ("10", "10"), ("0010", "08"), ("10", "8"))]
        for report in reports:
            self.assertEqual(report["episodes"], 10)
        returns = [report["return"] for report in reports]
        self.assertEqual(returns[0], returns[1])
        self.assertEqual(returns[2], returns[3])
        self.assertNotEqual(returns[0], returns[2])
        self.assert_refused(USAGE, ["pick", "--seed", "0x10"], "'0x10' is not a whole number")
        self.assert_refused(USAGE, ["pick", "--seed", "-01"], "-1 is below 0")
        self.assert_refused(USAGE, ["pick", "--threads", "00"], "--threads")

    def test_every_option_of_a_whole_number_is_read_as_decimal(self):
        seen = set()
        for words in self.all_commands():
            for text in re.split(r"^  (?=--)", self.run_program(*words, "--help").stdout, flags=re.MULTILINE):
                option, kind, *rest = text.split(maxsplit=2)
                if not option.startswith("--") or kind != "N":
                    continue
                seen.add(option)
                limits = re.search(r"(\d+)\s+to\s+(\d+)\)", rest[0])
                if limits:
                    beyond = int(limits[2]) + 1
                    self.assert_refused(USAGE, [*words, option, f"0{beyond}"], f"{option}: {beyond} is outside")
                else:
                    self.assertEqual(option, "--seed", words)
                    self.assert_refused(USAGE, [*words, option, "-010"], "-10 is below 0")
        self.assertGreaterEqual(seen, {"--seed", "--threads", "--trials", "--episodes", "--domain"})


class LostOutput(CliTest):
    def code_and_error(self, *arguments, stdout, **more):
        environment = dict(os.environ, PALPATE_CACHE=str(self.cache))
        done = subprocess.run([cli.PROGRAM, *arguments], cwd=self.folder, env=environment, stdout=stdout,
                              stderr=subprocess.PIPE, text=True, timeout=60, **more)  # fmt: skip
        return done.returncode, done.stderr

    def test_output_that_a_full_disk_loses_is_an_error(self):
        for arguments in (["--version"], ["--help"], ["options", "pick"], ["options", "pick", "--json"], ["doctor"]):
            with open("/dev/full", "w") as full:
                code, error = self.code_and_error(*arguments, stdout=full)
            self.assertEqual(code, BAD_INPUT, arguments)
            self.assertEqual(error, "palpate: cannot write the output: No space left on device\n", arguments)

    def test_a_reader_that_goes_away_is_told_nothing(self):
        reader, writer = os.pipe()
        os.close(reader)
        self.addCleanup(os.close, writer)
        for arguments in (["--version"], ["--help"], ["options", "pick", "--json"]):
            self.assertEqual(self.code_and_error(*arguments, stdout=writer), (-signal.SIGPIPE, ""))
            # As under a parent that ignores the signal: only the error of a write is left.
            self.assertEqual(self.code_and_error(*arguments, stdout=writer, restore_signals=False)[1], "")

    def test_an_error_that_cannot_be_told_is_one_by_its_code(self):
        with open("/dev/full", "w") as full:
            done = subprocess.run([cli.PROGRAM, "sense", "none.csv"], cwd=self.folder, stderr=full, timeout=60)
        self.assertEqual(done.returncode, BAD_INPUT)


class OptionsOfOtherInput(CliTest):
    def test_those_of_bags_are_refused_for_a_recording(self):
        self.write("recording.h5", "PALPATE RECORDING")
        self.write("skin.csv", "finger,x,y,z,nx,ny,nz\nff,0,0,0,0,0,1\n")
        for option in ("--object", "--hand", "--at", "--world-frame", "--mount-frame", "--joint-states", "--contacts",
                       "--fingertip-wrenches", "--taxels", "--taxel-layout"):  # fmt: skip
            value = {"--at": "1", "--taxel-layout": "skin.csv"}.get(option, "x")
            self.assert_refused(BAD_INPUT, ["replay", "recording.h5", option, value],
                                f"{option} is an option of bags (MCAP)", "recording.h5")  # fmt: skip

    def test_those_of_a_stream_need_one(self):
        self.write("recording.h5", "PALPATE RECORDING")
        for option in ("--object", "--hand", "--domain", "--world-frame", "--mount-frame", "--joint-states",
                       "--contacts", "--fingertip-wrenches", "--taxels", "--best-effort"):  # fmt: skip
            value = [] if option == "--best-effort" else ["1"]
            self.assert_refused(USAGE, ["view", "recording.h5", option, *value, "--out", "page"], option, "--live")


class Export(CliTest):
    def test_a_recording_is_not_replaced_by_what_is_made_of_it(self):
        (self.folder / "run").mkdir()
        self.write("run/recording.h5", "PALPATE RECORDING")
        (self.folder / "link.h5").symlink_to("run/recording.h5")
        for form in ("mcap", "lerobot", "minari"):
            for recording in ("run/recording.h5", "run", "link.h5"):
                for out in ("run/recording.h5", "run/../run/recording.h5", "link.h5", "run", "."):
                    self.assert_refused(BAD_INPUT, ["export", form, recording, "--out", out, "--force"],
                                        f"{out} is the recording, or holds it")  # fmt: skip
        self.assertEqual((self.folder / "run/recording.h5").read_text(), "PALPATE RECORDING")

    def test_an_mcap_is_not_written_in_the_place_of_a_folder(self):
        self.write("recording.h5", "PALPATE RECORDING")
        (self.folder / "there").mkdir()
        for force in ([], ["--force"]):
            command = ["export", "mcap", "recording.h5", "--out", "there", *force]
            self.assert_refused(BAD_INPUT, command, "there is a folder, and an MCAP is a file")

    def test_modules_in_the_current_folder_are_not_run(self):
        self.write("recording.h5", "PALPATE RECORDING")
        for name in ("palpate", "h5py", "argparse"):
            self.write(f"{name}.py", f"open('ran-{name}', 'w').close()\n")
        self.assertEqual(self.run_program("export", "minari", "recording.h5").returncode, BAD_INPUT)
        self.assertFalse(list(self.folder.glob("ran-*")))


class Options(CommandsTest):
    def test_every_option_is_listed_with_its_help(self):
        for command in ("pick", "replay", "localize", "plan", "register", "rollout"):
            options = self.run_json("options", command)["options"]
            self.assertGreater(len(options), 3, command)
            for option in options:
                self.assertEqual(sorted(option),
                                 ["command", "default", "help", "key", "range", "type"])  # fmt: skip
                self.assertEqual(option["command"], command)
                self.assertNotEqual(option["help"], "", option["key"])

    def test_every_command_that_takes_options_has_the_list_that_its_help_names(self):
        named = set()
        for words in self.all_commands():
            text = " ".join(self.run_program(*words, "--help").stdout.split())
            if "--set KEY=VALUE" not in text:
                continue
            name = re.search(r"`palpate options ([^`]*)`", text)[1]
            self.assertEqual(name.split(), words)
            options = self.run_json("options", *words, "--expert")["options"]
            self.assertGreater(len(options), 1, words)
            named.add(name)
            if words == ["replay"]:  # it opens the recording first
                continue
            # The command has the keys, too.
            key = next(o["key"] for o in options if o["type"] in ("number", "integer"))
            needs = {"localize": ["box", "x"], "register": ["x", "y"], "plan": ["x"],
                     "compare": ["a", "b"], "demos retarget": ["x"]}.get(name, [])  # fmt: skip
            if words[0] == "train":
                needs = ["--out", "new"] + ["x"] * ("LOGS" in text)
            if name == "demos make":
                needs = ["--out", "new"]
            self.assert_refused(BAD_INPUT, [*words, *needs, "--set", f"{key}=x"], f"{key} = x is not a")
        self.assertGreaterEqual(named, {"pick", "compare", "train relocate", "demos make"})

    def test_a_group_lists_the_options_of_each_of_its_commands(self):
        options = self.run_json("options", "train", "--expert")["options"]
        commands = {o["command"] for o in options}
        self.assertEqual(len(commands), 5)
        for command in commands:
            own = self.run_json("options", *command.split(), "--expert")["options"]
            self.assertEqual([o for o in options if o["command"] == command], own)
        self.assertIn("palpate demos retarget:\n", self.run_program("options", "demos").stdout)

    def test_experts_are_listed_on_demand_and_those_of_a_pick_are_few_enough_to_read(self):
        keys = [option["key"] for option in self.run_json("options", "pick")["options"]]
        self.assertLessEqual(len(keys), 100)
        self.assertFalse([key for key in keys if key.startswith("expert.")])
        every = [o["key"] for o in self.run_json("options", "pick", "--expert")["options"]]
        self.assertEqual(every[: len(keys)], keys)
        self.assertTrue(all(key.startswith("expert.") for key in every[len(keys) :]))

    def test_the_forward_model_has_the_options_that_it_uses(self):
        text = self.run_program("options", "pick", "--expert").stdout
        self.assertEqual(re.findall(r"^expert\.forward_model\.(\S+)", text, re.MULTILINE),
                         ["time_step", "table_friction", "stiffness_scale", "exact_tips"])

    def test_an_option_that_is_gone_is_refused_with_the_reason(self):
        for key, reason in (("grasp.top.pitch", "the postures are those of the hand's description"),
                            ("palpation.rolls", "a held object is no longer rolled between the fingers"),
                            ("expert.forward_model.hand_friction", "the forward model has the friction that planning assumes"),
                            ("expert.forward_model.noise.joint", "the forward model has neither noise nor errors")):
            self.assert_refused(BAD_INPUT, ["pick", "--set", f"{key}=1"],
                                f"option {key} is gone: {reason}; palpate options pick lists the options")

    def test_a_replay_has_the_options_of_the_estimate_alone(self):
        every = {o["key"] for o in self.run_json("options", "pick", "--expert")["options"]}
        keys = {o["key"] for o in self.run_json("options", "replay", "--expert")["options"]}
        self.assertLess(keys, every)
        of_estimate = {key for key in every if "estimation." in key and ".identify." not in key}
        self.assertLessEqual(of_estimate, keys)
        self.assertFalse({key for key in keys if key.startswith(("lift", "world", "grasp"))})

    def test_text_and_a_command_without_options(self):
        done = self.run_program("options")
        self.assertEqual(done.returncode, DONE)
        self.assertIn("attempts = 3", done.stdout)
        self.assert_refused(BAD_INPUT, ["options", "view"], "view")


class Doctor(CliTest):
    def test_doctor(self):
        checks = self.run_json("doctor")["checks"]
        self.assertIn("MuJoCo", [check["name"] for check in checks])
        for check in checks:
            self.assertIsInstance(check["ok"], bool)
            self.assertIsInstance(check["hint"], str)

    def test_options_without_effect_are_refused_and_not_in_the_help(self):
        self.assertEqual(self.run_program("doctor", "--quiet").returncode, DONE)
        for command, *options in [
            ("doctor", "--seed", "--threads", "--set", "--out"),
            ("options", "--seed", "--threads", "--set", "--out"),
            ("replay", "--seed", "--threads", "--out"),
            ("view", "--seed", "--threads", "--set"),
            ("certify", "--seed", "--threads", "--set"),
            ("sense", "--seed", "--threads", "--set"),
            ("pick", "--threads"),
            ("plan", "--threads"),
            ("render", "--threads"),
        ]:
            text = self.run_program(command, "--help").stdout
            for option in options:
                self.assertNotIn(option + " ", text, command)
                done = self.run_program(command, option, "1")
                self.assertEqual(done.returncode, USAGE, (command, option, done.stderr))

    def test_a_commands_own_option_in_a_setting_is_named(self):
        for key in ("hand", "object", "seed"):
            self.assert_refused(BAD_INPUT, ["pick", "--set", f"{key}=allegro"], f"--{key} sets it")
        self.assert_refused(BAD_INPUT, ["pick", "--set", "lift.hight=1"], "did you mean lift.height")
        self.assert_refused(BAD_INPUT, ["pick", "--set", "grasp.frction=1"], "did you mean friction?")

    def test_missing_assets_are_named_with_what_to_do(self):
        os.environ["PALPATE_ASSETS"] = str(self.folder)
        self.addCleanup(os.environ.pop, "PALPATE_ASSETS")
        done = self.run_program("doctor", "--json")
        self.assertEqual(done.returncode, BAD_INPUT)
        checks = json.loads(done.stdout)["checks"]
        missing = [check for check in checks if check["required"] and not check["ok"]]
        self.assertIn("hand model", [check["name"] for check in missing])
        for check in missing:
            self.assertIn("./dev build", check["hint"])
        self.assert_refused(BAD_INPUT, ["pick", "--object", "box", "--out", "new"], "run ./dev build")

    def test_an_object_that_is_not_installed_is_named_with_what_to_do(self):
        os.environ["PALPATE_ASSETS"] = str(self.folder)
        self.addCleanup(os.environ.pop, "PALPATE_ASSETS")
        self.write("contacts.csv", "x,y,z\n0,0,0\n")
        self.assert_refused(BAD_INPUT, ["localize", "bunny", "contacts.csv"], "./dev bunny installs it")


if __name__ == "__main__":
    main()
