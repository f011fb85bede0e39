# SPDX-License-Identifier: Apache-2.0
"""view and render: the page of a recording, served or written, and its pictures."""

import json
import os
import signal
import subprocess
import struct
import urllib.request

import cli
from cli import BAD_INPUT, DONE, QUICK, USAGE, CliTest, main


class RecordingTest(CliTest):
    def record(self):
        self.run_json("pick", "--object", "box", "--seed", "3", "--out", "run", *QUICK)
        return "run/recording.h5"


class View(RecordingTest):
    def serve(self, *arguments):
        environment = dict(os.environ, PALPATE_CACHE=str(self.cache))
        server = subprocess.Popen(
            [cli.PROGRAM, "view", *arguments, "--json", "--quiet"], cwd=self.folder,
            env=environment, stdout=subprocess.PIPE, text=True,
        )  # fmt: skip
        self.addCleanup(server.stdout.close)
        self.addCleanup(server.kill)
        lines = [server.stdout.readline() for _ in range(3)]
        return server, json.loads("".join(lines))["url"]

    def test_serves_the_page_until_interrupted(self):
        recording = self.record()
        server, url = self.serve(recording, "--port", "0")
        with urllib.request.urlopen(url, timeout=60) as answer:
            page = answer.read().decode()
        self.assertIn("<html", page[:1000].lower())

        port = url.rstrip("/").rpartition(":")[2]
        self.assert_refused(BAD_INPUT, ["view", recording, "--port", port], port)

        server.send_signal(signal.SIGINT)
        self.assertEqual(server.wait(timeout=60), DONE)

    def test_writes_the_page_that_pick_writes(self):
        page = self.run_json("view", self.record(), "--out", "pages")["page"]
        self.assertEqual(page, "pages/replay.html")
        self.assertEqual(
            len((self.folder / page).read_text().partition("<script")[2]),
            len((self.folder / "run/replay.html").read_text().partition("<script")[2]))

    def test_no_recording(self):
        self.assert_refused(BAD_INPUT, ["view", "missing.h5"], "missing.h5")


class Render(RecordingTest):
    def test_draws_the_end_of_every_phase(self):
        checks = {check["name"]: check["ok"] for check in self.run_json("doctor")["checks"]}
        if not checks["rendering"]:
            self.skipTest("nothing here draws without a screen")
        report = self.run_json("render", self.record(), "--size", "64x48", "--out", "pictures")
        phases = json.loads((self.folder / "run/report.json").read_text())["phases"]
        self.assertEqual(
            [picture["phase"] for picture in report["files"]], [phase["name"] for phase in phases]
        )
        for picture in report["files"]:
            header = (self.folder / picture["file"]).read_bytes()[:24]
            self.assertEqual(header[:8], b"\x89PNG\r\n\x1a\n")
            self.assertEqual(struct.unpack(">II", header[16:]), (64, 48))

    def test_draws_a_pick_by_channels(self):
        checks = {check["name"]: check["ok"] for check in self.run_json("doctor")["checks"]}
        if not checks["rendering"]:
            self.skipTest("nothing here draws without a screen")
        report = self.run_json(
            "render", "--object", "box", "--seed", "3", "--size", "64x48", "--out", "pictures",
            "--set", "touch.source=biotac", "--set", "attempts=1", *QUICK)  # fmt: skip
        self.assertGreaterEqual(len(report["files"]), 3)
        # The contacts tell of their errors, which the recording then must say.
        seal = (self.folder / "pictures/recording.h5").read_bytes()[:20]
        self.assertEqual(seal, b"PALPATE RECORDING 3\n")

    def test_refuses_what_it_cannot_draw(self):
        for size in ["big", "640", "640x480x3", "x480"]:
            self.assert_refused(USAGE, ["render", "--size", size], size, "WIDTHxHEIGHT")
        self.assert_refused(USAGE, ["render", "run.h5", "--object", "box"], "--object")
        self.assert_refused(BAD_INPUT, ["render", "missing.h5"], "missing.h5")
        self.assert_refused(
            BAD_INPUT, ["render", "--set", "touch.source=skin", "--out", "new"], "touch.source")


if __name__ == "__main__":
    main()
