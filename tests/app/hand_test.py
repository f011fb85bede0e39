# SPDX-License-Identifier: Apache-2.0
"""The hand command, and hands that pick and eval refuse."""

import os
import pathlib
import subprocess

import cli
from cli import BAD_INPUT, DONE, USAGE, CliTest, main

NO_HAND = '<mujoco><worldbody><body name="palm"><geom size="0.1"/></body></worldbody></mujoco>'


class Hand(CliTest):
    def refused(self, *arguments):
        result = self.run_program(*arguments)
        self.assertEqual(result.returncode, BAD_INPUT, result.stderr)
        self.assertEqual(result.stdout, "")
        self.assertEqual(result.stderr.count("\n"), 1, result.stderr)
        self.assertEqual([path for path in self.folder.rglob("*") if path.is_dir()], [])
        return result.stderr

    def test_the_shadow_hand_is_described(self):
        report = self.run_json("hand", "check", "shadow")
        self.assertEqual(len(report["fingers"]), 5)
        self.assertEqual([finger["thumb"] for finger in report["fingers"]].count(True), 1)
        self.assertEqual(len(report["actuators"]), 20)
        self.assertEqual(report["problems"], [])
        self.assertIn("5 fingers", self.run_program("hand", "check", "shadow").stdout)

    def test_every_hand_of_the_list_names_its_licence(self):
        hands = {hand["name"]: hand for hand in self.run_json("hand", "list")["hands"]}
        known = {"shadow", "allegro", "leap", "barrett", "shadow-left", "allegro-left", "leap-left"}
        self.assertLessEqual(known, set(hands))
        self.assertTrue(all(hand["licence"] for hand in hands.values()))
        self.assertTrue(hands["shadow"]["installed"])
        self.assertFalse(hands["leap"]["installed"])  # the cache of a test is empty

    def test_the_report_has_all_that_a_toml_file_can_correct(self):
        hand = pathlib.Path(__file__).parents[2] / "examples/hands/three_fingers.xml"
        mimic = '<equality><joint joint1="index_3" joint2="index_2" polycoef="0 0.7 0 0 0"/></equality>'
        self.write("hand.xml", hand.read_text().replace("</mujoco>", mimic + "</mujoco>"))
        report = self.run_json("hand", "check", "hand.xml")
        self.assertEqual((report["root"], report["palm"]), ("palm", "palm"))
        drives = {drive["name"]: drive["followers"] for drive in report["actuators"]}
        self.assertEqual(drives["index_2"], [{"joint": "index_3", "multiplier": 0.7, "offset": 0}])
        self.assertEqual(drives["ring_2"], [])
        mount = ", ".join(f"{key} = {value!r}" for key, value in report["mount"].items())
        self.write("hand.toml", f'model = "hand.xml"\nmount = {{{mount}}}\n')
        again = self.run_json("hand", "check", "hand.toml")
        self.assertEqual(again["problems"], report["problems"])
        for key, value in report["mount"].items():
            self.assertAlmostEqual(again["mount"][key], value, 9)

    def test_a_hand_that_holds_nothing_is_described_before_it_is_refused(self):
        hand = pathlib.Path(__file__).parents[2] / "examples/hands/three_fingers.xml"
        self.write("hand.xml", hand.read_text())
        self.write("hand.toml", 'model = "hand.xml"\nclosing = "-index_1,-ring_1,-thumb_1"\n')
        result = self.run_program("hand", "check", "hand.toml")
        self.assertEqual(result.returncode, BAD_INPUT)
        self.assertIn("hand.toml: the hand holds nothing", result.stderr)
        self.assertIn("root palm, palm palm", result.stdout)
        self.assertIn("index_1", result.stdout)
        self.assertNotIn("No problems", result.stdout)
        self.assertIn("`palpate hand check hand.toml --render DIR` shows",
                      self.refused("pick", "--object", "box", "--hand", "hand.toml"))

    def test_an_arm_is_no_hand_and_the_keys_of_a_hand_are_listed(self):
        self.assertIn("ur10 is an arm, not a hand", self.refused("hand", "check", "ur10"))
        keys = {one["key"] for one in self.run_json("options", "hand", "check")["options"]}
        self.assertLessEqual({"model", "root", "tips", "closing", "mount.given"}, keys)

    def test_what_is_no_hand_is_refused_by_every_command(self):
        os.mkfifo(self.folder / "pipe")
        self.write("no_hand.xml", NO_HAND)
        self.write("my_hand.toml", 'model = "no_hand.xml"\nthum = "thumb"\n')
        for command in (["hand", "check"], ["pick", "--hand"], ["eval", "--trials", "1", "--hand"]):
            self.assertIn("pipe: it is a pipe", self.refused(*command, "pipe"))
            self.assertIn("no_hand.xml: no body of the file has joints",
                          self.refused(*command, "no_hand.xml"))
            self.assertIn("my_hand.toml:2: unknown option thum; did you mean thumb?",
                          self.refused(*command, "my_hand.toml"))
            self.assertIn("palpate hand install leap", self.refused(*command, "leap"))
            self.assertIn("'nobody' is neither a hand", self.refused(*command, "nobody"))

    def test_postures_are_drawn(self):
        checks = {check["name"]: check["ok"] for check in self.run_json("doctor")["checks"]}
        if not checks["rendering"]:
            self.skipTest("neither EGL nor OSMesa works here; see palpate doctor")
        pictures = self.run_json("hand", "render", "shadow-left", "--out", "pictures")["pictures"]
        names = {pathlib.Path(picture).stem for picture in pictures}
        self.assertLessEqual({"open", "closed", "flat", "pointing-FF"}, names)
        for picture in pictures:
            data = (self.folder / picture).read_bytes()
            self.assertEqual(data[:4], b"\x89PNG")
        again = ["hand", "render", "shadow-left", "--out", "pictures"]
        self.assert_refused(BAD_INPUT, again, "pictures/open.png is there already")
        self.assertEqual(self.run_json(*again, "--force")["pictures"], pictures)

    def test_a_name_in_a_hands_file_leads_no_picture_elsewhere(self):
        checks = {check["name"]: check["ok"] for check in self.run_json("doctor")["checks"]}
        if not checks["rendering"]:
            self.skipTest("neither EGL nor OSMesa works here; see palpate doctor")
        hand = pathlib.Path(__file__).parents[2] / "examples/hands/three_fingers.xml"
        self.write("hand.xml", hand.read_text().replace('"index_tip"', '"../../../tip"'))
        pictures = self.run_json("hand", "render", "hand.xml", "--out", "pictures")["pictures"]
        self.assertIn("pictures/pointing-.._.._.._tip.png", pictures)
        self.assertEqual({str(pathlib.Path(picture).parent) for picture in pictures}, {"pictures"})

    def test_the_left_shadow_hand_is_the_right_ones_mirror_image(self):
        right, left = (self.run_json("hand", "check", name) for name in ("shadow", "shadow-left"))
        self.assertEqual(left["hand"], "shadow-left")
        for one, other in zip(right["actuators"], left["actuators"], strict=True):
            self.assertEqual(one, other)

    def test_a_hand_is_installed_by_its_name_only(self):
        self.assertIn("no hand named 'nobody'", self.refused("hand", "install", "nobody"))
        self.assertEqual(self.run_program("hand", "install").returncode, USAGE)

    def test_without_a_folder_for_the_cache_nothing_is_installed(self):
        nowhere = {name: value for name, value in os.environ.items()
                   if name not in ("HOME", "XDG_CACHE_HOME", "PALPATE_CACHE", "PALPATE_HANDS")}  # fmt: skip
        for command in (["install", "allegro"], ["list"]):
            done = subprocess.run([cli.PROGRAM, "hand", *command], cwd=self.folder, env=nowhere,
                                  capture_output=True, text=True, timeout=60)  # fmt: skip
            self.assertEqual(done.returncode, BAD_INPUT if command[0] == "install" else DONE, done.stderr)
        self.assertFalse((self.folder / "hands").exists())


if __name__ == "__main__":
    main()
