# SPDX-License-Identifier: Apache-2.0
"""--live: a page that follows a pick, an evaluation or a stream of ROS 2 while it happens."""

import http.client
import json
import os
import random
import re
import signal
import subprocess
import threading
import unittest
import urllib.parse

import browser
import cli
from cli import BAD_INPUT, DONE, QUICK, STOPPED, USAGE, CliTest, main

try:
    import ros2_loopback
    import ros2_peer
    import ros2_stream
except ImportError:
    ros2_peer = None

PICK = ["--object", "box", "--seed", "7", *QUICK]


class Viewer(threading.Thread):
    """One that watches: every message of a stream, with its number, and the run that sends it."""

    def __init__(self, url, last=None, slow=False):
        super().__init__(daemon=True)
        self.parts = urllib.parse.urlsplit(url)
        self.last, self.slow, self.messages, self.status, self.sender = last, slow, [], None, None
        self.enough = lambda _: False
        self.start()

    def run(self):
        connection = http.client.HTTPConnection(self.parts.hostname, self.parts.port, timeout=120)
        headers = {} if self.last is None else {"Last-Event-ID": str(self.last)}
        query = f"?{self.parts.query}" if self.parts.query else ""
        connection.request("GET", f"/events{query}", headers=headers)
        answer = connection.getresponse()
        self.status = answer.status
        if self.slow:
            return  # and reads nothing, with the connection open
        number = None
        try:
            for line in answer:
                field, _, value = line.decode().rstrip("\n").partition(": ")
                if field == "id":
                    self.sender, _, number = value.partition("-")
                    number = int(number)
                if field == "data":
                    self.messages.append((number, json.loads(value)))
                    if self.enough(self.messages[-1][1]):
                        break
        except (OSError, http.client.HTTPException):
            pass  # the program has ended

    def of(self, kind):
        return [message[kind] for _, message in self.messages if kind in message]


class LiveTest(CliTest):
    def start(self, *arguments):
        environment = dict(os.environ, PALPATE_CACHE=str(self.cache))
        program = subprocess.Popen(
            [cli.PROGRAM, *arguments], cwd=self.folder, env=environment, stdin=subprocess.DEVNULL,
            stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True)  # fmt: skip
        for stream in (program.stdout, program.stderr):
            self.addCleanup(stream.close)
        self.addCleanup(program.kill)
        return program

    def address(self, program):
        """Where it is shown, as the program says."""
        line = ""
        while not line.startswith("live: "):
            line = program.stderr.readline()
            self.assertTrue(line, "no address")
        return line.removeprefix("live: ").strip()

    def wait_for_page(self, url):
        """Until there is more than the page that says to wait."""
        for _ in range(600):
            page = self.page(url)[1]
            if "recording" in page:
                return page
            ros2_wait(0.1)
        self.fail("no page")

    def page(self, url, path=None):
        parts = urllib.parse.urlsplit(url)
        connection = http.client.HTTPConnection(parts.hostname, parts.port, timeout=60)
        connection.request("GET", path or f"/?{parts.query}")
        answer = connection.getresponse()
        return answer.status, answer.read().decode()


def ros2_wait(seconds):
    threading.Event().wait(seconds)


class Pick(LiveTest):
    def test_those_that_watch_get_everything_and_the_pick_is_the_same(self):
        self.run_json("pick", *PICK, "--out", "alone")
        program = self.start("pick", *PICK, "--out", "watched", "--live", "0", "--json")
        url = self.address(program)
        self.assertTrue(url.startswith("http://127.0.0.1:"), url)
        self.wait_for_page(url)
        viewers = [Viewer(url) for _ in range(10)] + [Viewer(url, slow=True) for _ in range(3)]
        stdout, stderr = program.communicate(timeout=500)
        self.assertIn(program.returncode, (DONE, cli.NO_SOLUTION), stderr)
        alone = json.loads((self.folder / "alone/report.json").read_text())
        watched = json.loads((self.folder / "watched/report.json").read_text())
        for report in (alone, watched):
            del report["estimate"]["seconds"]  # of wall time, as those of the phases
            for phase in report["phases"]:
                del phase["wall_seconds"]
        self.assertEqual(alone, watched)
        self.assertEqual((self.folder / "alone/recording.h5").read_bytes(),
                         (self.folder / "watched/recording.h5").read_bytes())

        for viewer in viewers[:10]:
            viewer.join(timeout=60)
            numbers = [number for number, _ in viewer.messages]
            self.assertEqual(numbers, list(range(numbers[0], numbers[0] + len(numbers))))
            self.assertEqual(viewer.messages, viewers[0].messages)
            self.assertEqual(len(viewer.of("end")), 1)
        first = viewers[0]
        self.assertGreater(len(first.of("frames")), 100)
        phases = first.of("story")[-1]["phases"]
        self.assertEqual([phase["name"] for phase in phases],
                         [phase["name"] for phase in alone["phases"]])  # fmt: skip
        sources = {belief["source"] for belief in first.of("belief")}
        self.assertLessEqual({"prior", "touch"}, sources)
        times = [belief["time"] for belief in first.of("belief")]
        self.assertEqual(times, sorted(times))
        self.assertEqual(times[0], 0)

    def test_beyond_this_machine_only_with_the_token(self):
        program = self.start("pick", *PICK, "--out", "run", "--live", "0.0.0.0:0", "--json")
        url = self.address(program).replace("0.0.0.0", "127.0.0.1")
        token = re.fullmatch(r".*/\?token=([0-9a-f]{32})", url)
        self.assertTrue(token, url)
        self.assertEqual(self.page(url)[0], 200)
        for path in ("/", "/?token=", "/?token=" + "0" * 32, "/events", "/events?token=1",
                     f"/?x={token[1]}", f"/?token={token[1]}0"):  # fmt: skip
            self.assertEqual(self.page(url, path)[0], 403, path)
        program.send_signal(signal.SIGINT)
        program.communicate(timeout=100)

    def test_who_lost_the_stream_goes_on_where_it_broke(self):
        program = self.start("pick", *PICK, "--out", "run", "--live", "0", "--json")
        url = self.address(program)
        self.wait_for_page(url)
        first = Viewer(url)
        first.enough = lambda _: len(first.messages) >= 50
        first.join(timeout=200)
        last = first.messages[-1][0]
        self.assertRegex(first.sender, "^[0-9a-f]{32}$")
        second = self.first_message(url, f"{first.sender}-{last}")
        self.assertEqual(second[0], last + 1)
        # A message that is not there, one of an earlier run, and no message at all.
        for stated in (f"{first.sender}-{10**12}", f"{'0' * 32}-{last}", last, first.sender):
            self.assertEqual(self.first_message(url, stated), first.messages[0], stated)
        program.send_signal(signal.SIGHUP)  # of a terminal that is closed
        _, err = program.communicate(timeout=100)
        self.assertEqual(program.returncode, STOPPED, err)

    def first_message(self, url, last):
        """Of a stream, to a browser that states the last message that it has."""
        viewer = Viewer(url, last=last)
        viewer.enough = lambda _: True
        viewer.join(timeout=200)
        return viewer.messages[0]

    def test_addresses_that_cannot_be_are_refused(self):
        for address in ("a", "70000", "1.2.3:80", "example.org:80", "127.0.0.1:"):
            self.assert_refused(BAD_INPUT, ["pick", *PICK, "--out", "run", f"--live={address}"], "address")
        self.assertFalse((self.folder / "run").exists())
        self.assert_refused(BAD_INPUT, ["eval", "--faults", "load_nan", "--live", "0"], "--live")
        self.assert_refused(USAGE, ["view", "--object", "mug"], "--live")
        self.assert_refused(USAGE, ["view"], "--live")
        self.assert_refused(BAD_INPUT, ["view", "--live", "run.h5"], "--live")


class Evaluation(LiveTest):
    def test_one_trial_after_the_other_is_shown(self):
        quick = ["--object", "box", "--trials", "2", "--seed", "3", *QUICK]
        program = self.start("eval", *quick, "--live", "0", "--json")
        url = self.address(program)
        titles = set()
        while program.poll() is None and len(titles) < 2:
            found = re.search(r"<title>palpate eval, (.*?)</title>", self.page(url)[1])
            titles |= {found[1]} if found else set()
            ros2_wait(0.2)
        self.assertEqual(titles, {"box with seed 3", "box with seed 4"})
        watched = json.loads(program.communicate(timeout=500)[0])
        self.assertEqual(watched, self.run_json("eval", *quick))


@unittest.skipUnless(ros2_peer, "requirements/ros2.txt is not installed; ./dev test tries to")
class Stream(LiveTest):
    def test_a_stream_of_ros_2_is_shown_with_what_is_estimated_beside_it(self):
        os.environ["CYCLONEDDS_URI"] = ros2_loopback.LOOPBACK
        domain = str(random.SystemRandom().randrange(1, 230))
        self.run_json("pick", *PICK, "--out", "run")
        self.run_json("export", "mcap", "run/recording.h5", "--out", "box.mcap")
        stream, peer = ros2_stream.HeldStream(self.folder / "box.mcap"), ros2_peer.Peer(int(domain))
        view = self.start("view", "--live", "--object", "box", "--domain", domain, "--port", "0",
                          "--json")  # fmt: skip
        url = json.loads("".join(view.stdout.readline() for _ in range(3)))["url"]
        estimator = self.start("ros2", "estimate", "--object", "box", "--domain", domain, "--quiet",
                               "--set", "first.proposals=10000")  # fmt: skip
        stream.advertise(peer)
        self.assertTrue(ros2_peer.wait_until(peer.is_heard), "nobody listens")
        self.wait_for_page(url)
        viewer = Viewer(url)
        now, beliefs = 1_700_000_000_000_000_000, []
        for _ in range(20000):
            stream.send(peer, now)
            now += 10_000_000
            ros2_wait(0.01)
            beliefs = viewer.of("belief")
            if beliefs and viewer.of("frames") and len(viewer.of("status")) > 1:
                break
        self.assertTrue(beliefs)
        self.assertEqual(beliefs[0]["source"], "online")
        self.assertTrue(beliefs[0]["in_hand"])
        self.assertLessEqual(sum(pose["probability"] for pose in beliefs[0]["poses"]), 1.001)
        self.assertIn("readings, 0 lost", viewer.of("status")[-1])
        for program in (view, estimator):
            program.send_signal(signal.SIGINT)
            program.communicate(timeout=100)
            self.assertEqual(program.returncode, DONE)


@unittest.skipUnless(browser.PROGRAM, "Chromium is not installed (Debian: chromium)")
class Page(LiveTest):
    def clock(self, page):
        return float(page.run("document.getElementById('clock').textContent.split(' ')[0]"))

    def checked(self, page, name):
        return page.run(f"[...document.querySelectorAll('#layers label')].find((l) => "
                        f"l.innerText.includes('{name}')).querySelector('input').checked")  # fmt: skip

    def test_a_recording(self):
        self.run_json("pick", *PICK, "--out", "run")
        with browser.Browser(1280, 800) as page:
            page.open(f"file://{self.folder}/run/replay.html#t=0")
            # The truth is hidden until asked for, and belief is there from the beginning.
            self.assertFalse(self.checked(page, "true pose"))
            self.assertIn("credible pose", page.run("document.getElementById('estimate').innerText"))
            # Keys work after a click on a checkbox.
            page.click("#layers label:nth-child(2) input")
            page.key("t")
            self.assertTrue(self.checked(page, "true pose"))
            page.key("PageDown")
            self.assertGreater(self.clock(page), 0.05)
            page.key("Home")
            self.assertLess(self.clock(page), 0.05)
            page.key(" ")
            self.assertEqual(page.run("document.getElementById('play').textContent"), "Pause")
            page.wait("Number(document.getElementById('clock').textContent.split(' ')[0]) > 0.1")
            page.key(" ")
            # Estimate, plots and forces are above the fold.
            for part in ("estimate", "plots", "forces"):
                self.assertLess(page.run(f"document.getElementById('{part}').getBoundingClientRect().bottom"), 800)
            page.run("location.hash = 't=end'")
            page.wait("document.getElementById('estimate').innerText.includes('from')")
            self.assertEqual(page.errors, [])

    def test_skips_what_is_quiet(self):
        self.run_json("pick", *PICK, "--out", "run")
        with browser.Browser(400, 300) as page:
            page.open(f"file://{self.folder}/run/replay.html#t=0.1")
            page.key("d")
            page.key(" ")
            calibrated = json.loads((self.folder / "run/report.json").read_text())["phases"][0]
            page.wait("Number(document.getElementById('clock').textContent.split(' ')[0]) > "
                      f"{calibrated['robot_seconds'] - 0.5}", 60)  # fmt: skip
            self.assertEqual(page.errors, [])

    def test_films_the_view(self):
        self.run_json("pick", *PICK, "--out", "run")
        with browser.Browser(400, 300) as page:
            page.call("Browser.setDownloadBehavior", behavior="allow", downloadPath=str(self.folder))
            page.open(f"file://{self.folder}/run/replay.html#t=end")
            page.run("document.getElementById('speed').value = '32'; location.hash = 't=30'; 1")
            page.run("window.drawn = 0; const count = () => { window.drawn += 1; requestAnimationFrame(count); };"
                     "count(); 1")  # fmt: skip
            page.click("#film")
            page.wait("window.drawn > 100", 120)
            page.click("#film")
            for _ in range(600):
                films = [path for path in self.folder.glob("palpate.*") if path.suffix in (".webm", ".mp4")]
                if films and films[0].stat().st_size > 5000:
                    break
                ros2_wait(0.1)
            self.assertTrue(films)
            self.assertGreater(films[0].stat().st_size, 5000)
            self.assertEqual(page.errors, [])

    def test_two_recordings_play_together(self):
        self.run_json("pick", *PICK, "--out", "run")
        page_path = self.run_json("view", "run/recording.h5", "run/recording.h5", "--out", "both")["page"]
        with browser.Browser(800, 400) as page:
            page.call("Page.navigate", url=f"file://{self.folder}/{page_path}")
            clocks = ("[...document.querySelectorAll('iframe')].map((f) => "
                      "f.contentDocument?.getElementById('clock')?.textContent ?? '')")  # fmt: skip
            page.wait(f"{clocks}.length === 2 && {clocks}.every((text) => text)")
            page.key("End")  # for both, though neither has been clicked
            page.wait(f"new Set({clocks}).size === 1 && {clocks}[0].split(' ')[0] > 1")
            page.key("t")
            page.wait("[...document.querySelectorAll('iframe')].every((f) => "
                      "f.contentDocument.querySelector('#layers input').checked)")  # fmt: skip
            self.assertEqual(page.errors, [])

    def test_a_live_pick(self):
        with browser.Browser(800, 500) as page:  # before the pick, which ends in seconds
            # Long enough for a browser that is slow to come.
            longer = [*PICK, "--set", "calibrate.touches=20", "--set", "explore.touches=8"]
            program = self.start("pick", *longer, "--out", "run", "--live", "0", "--json")
            url = self.address(program)
            self.wait_for_page(url)
            page.open(url)
            page.wait("Number(document.getElementById('clock').textContent.split(' ')[0]) > 1")
            self.assertTrue(page.run("document.getElementById('live').classList.contains('on')"))
            page.wait("document.getElementById('estimate').innerText.includes('credible pose')")
            program.communicate(timeout=500)
            page.wait("document.getElementById('live').classList.contains('ended')")
            page.key("Home")
            self.assertLess(self.clock(page), 0.05)
            self.assertFalse(page.run("document.getElementById('live').classList.contains('on')"))
            self.assertEqual(page.errors, [])


if __name__ == "__main__":
    main()
