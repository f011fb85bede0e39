# SPDX-License-Identifier: Apache-2.0
"""What the tests of the program share. They run it as a person would.

Usage of a test: NAME_test.py PALPATE
"""

import json
import os
import pathlib
import struct
import subprocess
import sys
import tempfile
import unittest

PROGRAM = None
DONE, USAGE, BAD_INPUT, NO_SOLUTION, STOPPED = 0, 2, 3, 4, 5
# A pick of little searching, for tests that only look at its form.
QUICK = [
    "--set", "calibrate.touches=6", "--set", "lift.hold=0.2", "--set", "explore.touches=2",
    "--set", "explore.max_touches=4", "--set", "explore.refining=0", "--set", "palpation.max=0",
    "--set", "palpation.regrasps=0", "--set", "palpation.table_touches=0",
    "--set", "estimation.search.proposals=5000", "--set", "estimation.search.particles=200",
]  # fmt: skip


def binary_stl(triangles, corners):
    """Binary STL of triangles (indices) over corners (x, y, z)."""
    data = b"\0" * 80 + struct.pack("<I", len(triangles))
    for triangle in triangles:
        data += struct.pack("<3f", 0, 0, 0)
        for index in triangle:
            data += struct.pack("<3f", *corners[index])
        data += b"\0\0"
    return data


def box_stl(x, y, z):
    corners = [(x * (i & 1), y * (i >> 1 & 1), z * (i >> 2 & 1)) for i in range(8)]
    triangles = [
        (0, 2, 1), (1, 2, 3), (4, 5, 6), (5, 7, 6), (0, 1, 4), (1, 5, 4),
        (2, 6, 3), (3, 6, 7), (0, 4, 2), (2, 4, 6), (1, 3, 5), (3, 7, 5),
    ]  # fmt: skip
    return binary_stl(triangles, corners)


class CliTest(unittest.TestCase):
    """Every test has a folder of its own, which is the working directory of the program."""

    def setUp(self):
        temporary = tempfile.TemporaryDirectory()
        self.addCleanup(temporary.cleanup)
        self.cache = pathlib.Path(temporary.name) / "cache"
        self.folder = pathlib.Path(temporary.name) / "work"
        self.folder.mkdir()

    def run_program(self, *arguments):
        environment = dict(os.environ, PALPATE_CACHE=str(self.cache))
        return subprocess.run(
            [PROGRAM, *arguments], cwd=self.folder, env=environment, capture_output=True,
            text=True, timeout=900,
        )  # fmt: skip

    def run_json(self, *arguments):
        """The one JSON object that the program prints when all goes well."""
        done = self.run_program(*arguments, "--json")
        self.assertEqual(done.returncode, DONE, done.stderr)
        value = json.loads(done.stdout)
        self.assertIsInstance(value, dict)
        return value

    def write(self, name, data):
        path = self.folder / name
        path.write_bytes(data if isinstance(data, bytes) else data.encode())
        return name

    def contents(self):
        return sorted(str(path.relative_to(self.folder)) for path in self.folder.rglob("*"))

    def assert_refused(self, code, arguments, *words):
        """The program ends with the code, one line on stderr with the words, and no trace."""
        before = self.contents()
        done = self.run_program(*arguments)
        self.assertEqual(done.returncode, code, (arguments, done.stderr))
        self.assertEqual(done.stdout, "", arguments)
        lines = done.stderr.splitlines()
        self.assertEqual(len(lines), 1, (arguments, done.stderr))
        self.assertTrue(lines[0].startswith("palpate: "), lines[0])
        for word in words:
            self.assertIn(word, lines[0])
        self.assertEqual(self.contents(), before, arguments)


class PickTest(CliTest):
    """Tests that share one pick of a box, in the folder `run`."""

    @classmethod
    def setUpClass(cls):
        cls.kept = CliTest("run_program")
        cls.kept.setUp()
        cls.addClassCleanup(cls.kept.doCleanups)
        cls.kept.run_json("pick", "--object", "box", "--seed", "7", "--out", "run", *QUICK)

    def setUp(self):
        super().setUp()
        self.folder, self.cache = self.kept.folder, self.kept.cache


def main():
    """Takes the program from the command line and runs the tests of the calling script."""
    global PROGRAM
    PROGRAM = os.path.abspath(sys.argv.pop(1))
    unittest.main()
