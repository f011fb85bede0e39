# SPDX-License-Identifier: Apache-2.0
"""Whether those who watch a pick slow it down: wall time of its phases without and with viewers.

usage: live_viewers.py PALPATE [--viewers 10] [--stalled 0] [--runs 4] [--object box] [--seed 3]

Runs alternate between none and all viewers. A viewer reads the page's stream as it comes; a stalled
one opens it and reads nothing.
"""

import argparse
import http.client
import json
import pathlib
import statistics
import subprocess
import tempfile
import threading
import urllib.parse


def watch(url, reads):
    """@return the connection, to keep it open"""
    parts = urllib.parse.urlsplit(url)
    connection = http.client.HTTPConnection(parts.hostname, parts.port)
    connection.request("GET", "/events")
    if not reads:
        return connection
    script = f"exec curl -sN http://{parts.hostname}:{parts.port}/events >/dev/null"
    connection.close()
    return subprocess.Popen(["sh", "-c", script])


def pick(arguments, viewers, stalled, folder):
    """@return s of wall time that the phases took"""
    program = subprocess.Popen(
        [arguments.palpate, "pick", "--object", arguments.object, "--seed", str(arguments.seed), "--out",
         str(folder), "--force", "--live", "0"], stdout=subprocess.DEVNULL, stderr=subprocess.PIPE, text=True)  # fmt: skip
    line = ""
    while not line.startswith("live: "):
        line = program.stderr.readline()
        if not line:
            raise SystemExit("no address")
    url = line.removeprefix("live: ").strip()
    watching = [watch(url, i < viewers) for i in range(viewers + stalled)]
    threading.Thread(target=program.stderr.read, daemon=True).start()
    program.wait()
    for one in watching:
        one.wait() if isinstance(one, subprocess.Popen) else one.close()
    report = json.loads((folder / "report.json").read_text())
    return sum(phase["wall_seconds"] for phase in report["phases"])


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("palpate")
    parser.add_argument("--viewers", type=int, default=10)
    parser.add_argument("--stalled", type=int, default=0)
    parser.add_argument("--runs", type=int, default=4)
    parser.add_argument("--object", default="box")
    parser.add_argument("--seed", type=int, default=3)
    arguments = parser.parse_args()
    seconds = {"none": [], "watched": []}
    with tempfile.TemporaryDirectory() as folder:
        for run in range(arguments.runs):
            for name in ("none", "watched") if run % 2 == 0 else ("watched", "none"):
                many = (arguments.viewers, arguments.stalled) if name == "watched" else (0, 0)
                seconds[name].append(round(pick(arguments, *many, pathlib.Path(folder) / "run"), 2))
    ratio = statistics.mean(seconds["watched"]) / statistics.mean(seconds["none"])
    print(json.dumps({"wall_seconds": seconds, "ratio_of_means": round(ratio, 3)}, indent=2))


if __name__ == "__main__":
    main()
