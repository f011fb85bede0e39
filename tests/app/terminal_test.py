# SPDX-License-Identifier: Apache-2.0
"""Colours and progress: on a terminal, and nowhere else."""

import os
import pty
import re
import subprocess

import cli
from cli import BAD_INPUT, DONE, QUICK, USAGE, CliTest, main

COLOR = re.compile(r"\033\[\d+m")
IDENTITY = "1,0,0,0,0,1,0,0,0,0,1,0,0,0,0,1"


def read_all(terminal):
    """What was written to a terminal whose other end is closed."""
    text = b""
    while True:
        try:
            part = os.read(terminal, 4096)
        except OSError:  # as Linux says that nobody has the other end any more
            part = b""
        if not part:
            return text.decode()
        text += part


class Terminal(CliTest):
    def on_terminal(self, *arguments, **environment):
        """What a person sees, of stdout and stderr together."""
        outer, inner = pty.openpty()
        self.addCleanup(os.close, outer)
        settings = dict(os.environ, PALPATE_CACHE=str(self.cache)) | {"TERM": "xterm"} | environment
        with subprocess.Popen([cli.PROGRAM, *arguments], cwd=self.folder, env=settings,
                              stdin=inner, stdout=inner, stderr=inner) as program:  # fmt: skip
            os.close(inner)
            text = read_all(outer)
        self.assertEqual(program.returncode, DONE, text)
        return text

    def certify(self):
        points = [(0, 0, 0), (1, 0, 0), (0, 1, 0), (0, 0, 1)]
        rows = [",".join(map(str, point + point)) for point in points]
        self.write("pairs.csv", "sx,sy,sz,tx,ty,tz\n" + "\n".join(rows) + "\n")
        return "certify", IDENTITY, "--correspondences", "pairs.csv"

    def test_statuses_have_a_colour_on_a_terminal_that_has_any(self):
        command = self.certify()
        self.assertIn("\033[32mcertified\033[0m", self.on_terminal(*command))
        for without in {"NO_COLOR": "1"}, {"TERM": "dumb"}:
            text = self.on_terminal(*command, **without)
            self.assertIn("certified", text)
            self.assertNotRegex(text, COLOR, without)
        self.assertNotRegex(self.run_program(*command).stdout, COLOR)

    def test_the_columns_of_a_table_stand_where_they_stand_without_colours(self):
        plain = self.run_program("doctor").stdout.splitlines()
        colored = COLOR.sub("", self.on_terminal("doctor", "--quiet")).splitlines()
        self.assertEqual([line.find(" ok ") for line in plain], [line.find(" ok ") for line in colored])

    def test_a_terminal_obeys_nothing_that_a_file_says(self):
        self.write("a.csv", "x,y,z,\x1b[2Jn\n1,2,3,4\n")
        self.assert_refused(BAD_INPUT, ["localize", "mug", "a.csv"], "unknown column '?[2Jn'")
        self.assert_refused(USAGE, ["pik\x1b[2J\nk"], "'pik?[2J k'")

    def test_a_wait_shows_its_seconds_and_leaves_no_trace(self):
        command = "rollout", "--episodes", "60"
        text = self.on_terminal(*command)
        self.assertIn("running episodes ... 2 s", text)
        last = text[text.rindex("running episodes") :]
        self.assertRegex(last, r"\r\033\[K[^\r]*return")
        self.assertNotIn("running", self.on_terminal("rollout", "--episodes", "1", "--quiet"))
        done = self.run_program("rollout", "--episodes", "1")
        self.assertEqual((done.returncode, done.stderr), (DONE, ""))

    def test_no_line_stands_behind_a_wait(self):
        pick = "pick", "--object", "box", "--seed", "7", "--out", "run", *QUICK
        self.assertRegex(self.on_terminal(*pick, "--live", "0"), r"(\n|\033\[K)live: http")
        self.run_json("export", "mcap", "run")
        text = self.on_terminal("replay", "run/recording.mcap")
        self.assertRegex(text, r"\r\033\[Kbox in the hand shadow")


if __name__ == "__main__":
    main()
