# SPDX-License-Identifier: Apache-2.0
"""view: the page of a recording, served or written."""

import json
import os
import signal
import subprocess
import urllib.request

import cli
from cli import BAD_INPUT, DONE, QUICK, CliTest, main


class View(CliTest):
    def record(self):
        self.run_json("pick", "--object", "box", "--seed", "3", "--out", "run", *QUICK)
        return "run/recording.h5"

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


if __name__ == "__main__":
    main()
