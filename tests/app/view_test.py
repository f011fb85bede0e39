# SPDX-License-Identifier: Apache-2.0
"""view and render: the page of a recording, served or written, and its pictures."""

import json
import os
import signal
import socket
import subprocess
import struct
import urllib.request

import cli
from cli import BAD_INPUT, DONE, NO_SOLUTION, QUICK, USAGE, CliTest, main


class RecordingTest(CliTest):
    def record(self):
        self.run_json("pick", "--object", "box", "--seed", "7", "--out", "run", *QUICK)
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

    def test_serves_on_any_address_of_this_machine(self):
        _, url = self.serve(self.record(), "--port", "0", "--host", "127.0.0.2")
        self.assertNotIn("token", url)
        with urllib.request.urlopen(url, timeout=60) as answer:
            self.assertEqual(answer.status, 200)

    def ask(self, port, lines, body=b""):
        """The answer to a request, whole."""
        request = "\r\n".join(lines).format(port=port).encode() + b"\r\n\r\n" + body
        with socket.create_connection(("127.0.0.1", port), timeout=30) as connection:
            connection.sendall(request)
            answer = b""
            while block := connection.recv(1 << 16):
                answer += block
        return answer

    def code_of(self, port, *lines):
        return int(self.ask(port, lines).split(b" ", 2)[1])

    def memory_of(self, process, key):
        for line in open(f"/proc/{process.pid}/status"):
            if line.startswith(key):
                return int(line.split()[1])  # kB

    def test_stands_hostile_requests(self):
        server, url = self.serve(self.record(), "--port", "0")
        port = int(url.rstrip("/").rpartition(":")[2])
        here, get = "Host: 127.0.0.1:{port}", "GET / HTTP/1.1"
        page = self.ask(port, [get, here]).partition(b"\r\n\r\n")[2]
        self.assertGreater(len(page), 100000)
        for lines, code in [
            ([get, "Host: localhost:{port}"], 200),
            ([get, here, "Origin: http://127.0.0.1:{port}"], 200),
            ([get, "Host: evil.example"], 403),
            ([get, "Host: evil.example:{port}"], 403),
            ([get, here, "Origin: http://evil.example"], 403),
            ([get, here, "Origin: null"], 403),
            ([get], 400),
            ([get, here, "Host: evil.example"], 400),
            (["GET /etc/passwd HTTP/1.1", here], 404),
            (["GET /../../etc/passwd HTTP/1.1", here], 404),
            (["POST / HTTP/1.1", here, "Content-Length: 1000000000000000000"], 405),
            (["nonsense"], 400),
            ([get, here, "X: " + "a" * 100000], 431),
        ]:  # fmt: skip
            self.assertEqual(self.code_of(port, *lines), code, lines[:3])
        self.assertEqual(self.ask(port, ["HEAD / HTTP/1.1", here]).partition(b"\r\n\r\n")[2], b"")

        before = self.memory_of(server, "VmHWM")
        many = "Range: bytes=" + ",".join(["0-"] * 300)
        answers = [self.ask(port, [get, here, many]) for _ in range(3)]
        self.assertEqual({len(answer) for answer in answers}, {len(answers[0])})
        self.assertLess(len(answers[0]), len(page) + 1000)
        self.assertLess(self.memory_of(server, "VmHWM") - before, 32 * 1024)

    def test_slow_clients_delay_no_other(self):
        server, url = self.serve(self.record(), "--port", "0")
        port = int(url.rstrip("/").rpartition(":")[2])
        slow = [socket.create_connection(("127.0.0.1", port), timeout=30) for _ in range(600)]
        for connection in slow:
            self.addCleanup(connection.close)
            try:
                connection.sendall(b"GET / HTTP/1.1\r\nX: ")
            except OSError:
                pass  # its place was needed
        with urllib.request.urlopen(url, timeout=30) as answer:
            self.assertIn(b"<html", answer.read()[:1000].lower())
        for connection in slow[-20:]:  # each is closed by itself after a while
            connection.settimeout(30)
            try:
                self.assertEqual(connection.recv(1), b"")
            except ConnectionResetError:
                pass

    def test_writes_the_page_that_pick_writes(self):
        page = self.run_json("view", self.record(), "--out", "pages")["page"]
        self.assertEqual(page, "pages/replay.html")
        self.assertEqual(
            len((self.folder / page).read_text().partition("<script")[2]),
            len((self.folder / "run/replay.html").read_text().partition("<script")[2]))

    def test_a_name_that_is_not_utf8_is_printed_with_a_mark_in_its_place(self):
        name = os.fsdecode(b"run/\xff.h5")
        (self.folder / self.record()).rename(self.folder / name)
        for command in (["view", name, "--out", "page"], ["export", "mcap", name], ["replay", name]):
            done = self.run_program(*command, "--json")
            self.assertIn(done.returncode, (DONE, NO_SOLUTION), done.stderr)
            report = json.loads(done.stdout)
            if command[0] != "view":
                self.assertEqual(report["path"][:5], "run/\ufffd", command)

    def test_the_part_of_an_interrupted_pick_is_named_and_read(self):
        recording = self.folder / self.record()
        recording.rename(f"{recording}.partial")
        for command in (["view", "run", "--out", "page"], ["replay", "run"], ["export", "mcap", "run"]):
            self.assert_refused(BAD_INPUT, command, "can be read as run/recording.h5.partial")
        page = self.run_json("view", "run/recording.h5.partial", "--out", "page")["page"]
        self.assertTrue((self.folder / page).exists())

    def test_next_lines_are_commands_that_work(self):
        self.record()
        done = self.run_program("view", "run", "--out", "my page")
        self.assertIn("Next: open 'my page/replay.html' in a browser\n", done.stdout)
        done = self.run_program("export", "mcap", "run", "--out", "my box.mcap")
        self.assertIn("Next: palpate replay 'my box.mcap'\n", done.stdout)
        self.run_json("replay", "my box.mcap")
        # A mesh file has to be given, also one that has the name of a built-in object.
        self.write("box.stl", cli.box_stl(0.06, 0.05, 0.09))
        self.run_json("pick", "--object", "box.stl", "--seed", "7", "--out", "other", *QUICK)
        done = self.run_program("export", "mcap", "other")
        self.assertEqual((done.returncode, "Next" in done.stdout), (DONE, False), done.stderr)
        self.assert_refused(BAD_INPUT, ["replay", "other/recording.mcap"], "does not say what was touched")
        self.assertIn(self.run_program("replay", "other/recording.mcap", "--object", "box.stl").returncode,
                      (DONE, NO_SOLUTION))  # fmt: skip
        # Of an episode of the relocate task only the recording can be replayed.
        self.run_json("rollout", "relocate-robust", "--episodes", "1", "--set", "episode.horizon=5",
                      "--record", "1", "--out", "rollout")  # fmt: skip
        done = self.run_program("export", "mcap", "rollout/episode-0.h5", "--out", "rollout.mcap")
        self.assertEqual((done.returncode, "Next" in done.stdout), (DONE, False), done.stderr)

    def test_no_recording(self):
        self.assert_refused(BAD_INPUT, ["view", "missing.h5"], "missing.h5")

    def test_an_address_is_of_no_use_to_a_file(self):
        for option in (["--port", "8080"], ["--host", "127.0.0.1"]):
            self.assert_refused(USAGE, ["view", "run.h5", "--out", "pages", *option], option[0])


class Render(RecordingTest):
    def test_draws_the_end_of_every_phase(self):
        checks = {check["name"]: check["ok"] for check in self.run_json("doctor")["checks"]}
        if not checks["rendering"]:
            self.skipTest("neither EGL nor OSMesa works here; see palpate doctor")
        report = self.run_json("render", self.record(), "--size", "64x48", "--out", "pictures")
        phases = json.loads((self.folder / "run/report.json").read_text())["phases"]
        self.assertEqual(
            [picture["phase"] for picture in report["files"]], [phase["name"] for phase in phases]
        )
        for picture in report["files"]:
            header = (self.folder / picture["file"]).read_bytes()[:24]
            self.assertEqual(header[:8], b"\x89PNG\r\n\x1a\n")
            self.assertEqual(struct.unpack(">II", header[16:]), (64, 48))

    def test_pictures_in_a_folder_of_their_own_are_overwritten_by_force_alone(self):
        checks = {check["name"]: check["ok"] for check in self.run_json("doctor")["checks"]}
        if not checks["rendering"]:
            self.skipTest("neither EGL nor OSMesa works here; see palpate doctor")
        recording = self.record()
        draw = ["render", recording, "--size", "64x48"]
        files = self.run_json(*draw, "--out", "pictures")["files"]
        self.assert_refused(BAD_INPUT, [*draw, "--out", "pictures"], files[0]["file"], "--force")
        self.assertEqual(self.run_json(*draw, "--out", "pictures", "--force")["files"], files)
        for _ in range(2):  # beside the recording they are drawn again
            beside = self.run_json(*draw)["files"]
        self.assertEqual([one["file"] for one in beside],
                         [one["file"].replace("pictures", "run") for one in files])  # fmt: skip

    def test_draws_a_pick_by_channels(self):
        checks = {check["name"]: check["ok"] for check in self.run_json("doctor")["checks"]}
        if not checks["rendering"]:
            self.skipTest("neither EGL nor OSMesa works here; see palpate doctor")
        report = self.run_json(
            "render", "--object", "box", "--seed", "3", "--size", "64x48", "--out", "pictures",
            "--set", "touch.source=biotac", "--set", "attempts=1", *QUICK)  # fmt: skip
        self.assertGreaterEqual(len(report["files"]), 3)
        # The contacts report their errors, which the recording then must state.
        recording = (self.folder / "pictures/recording.h5").read_bytes()
        self.assertEqual(recording[:20], b"PALPATE RECORDING 4\n")
        self.assertIn(b'"sensor_reported_errors":true', recording)

    def test_refuses_what_it_cannot_draw(self):
        for size in ["big", "640", "640x480x3", "x480"]:
            self.assert_refused(USAGE, ["render", "--size", size], size, "WIDTHxHEIGHT")
        for option in (["--object", "box"], ["--set", "lift.height=0.1"], ["--config", "x.toml"],
                       ["--seed", "1"], ["--force"]):  # fmt: skip
            self.assert_refused(USAGE, ["render", "run.h5", *option], option[0])
        for option in (["--gif"], ["--speed", "2"]):
            self.assert_refused(USAGE, ["render", "run.h5", *option], option[0], "--posterior")
        self.assert_refused(BAD_INPUT, ["render", "missing.h5"], "missing.h5")
        self.assert_refused(
            BAD_INPUT, ["render", "--set", "touch.source=skin", "--out", "new"], "touch.source")


if __name__ == "__main__":
    main()
