# SPDX-License-Identifier: Apache-2.0
"""Where the page of a recording draws what is believed, and how two pages share a screen."""

import base64
import json
import struct
import unittest

import browser
from cli import PickTest, main

MARK = '<script type="application/json" id="recording">'
STILL = [1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1]


def packed(values, kind="f"):
    return base64.b64encode(struct.pack(f"<{len(values)}{kind}", *values)).decode()


@unittest.skipUnless(browser.PROGRAM, "Chromium is not installed (Debian: chromium)")
class Page(PickTest):
    """The pick's page has its recording replaced."""

    def moving_page(self, beliefs, estimates, touched, let_go=()):
        """Ten frames, 0.1 s apart, in which the palm moves along x by 10 mm each.

        touched: frames in which two fingers touch.
        """
        count, pose = 10, [0, 0, 0, 0, 0, 0, 1]
        fingers = [2 if i in touched else 0 for i in range(count)]
        frames = {
            "count": count,
            "time": packed([0.1 * i for i in range(count)]),
            "link_poses": packed([x for i in range(count) for x in [0.01 * i, *pose[1:]]]),
            "object_poses": packed(pose * count),
            "has_object": packed([1] * count, "B"),
            "contact_counts": packed(fingers, "I"),
            "contacts": packed([0, 0, 0, 0, 0, 1, 1] * sum(fingers)),
            "contact_fingers": packed([0, 1] * (sum(fingers) // 2), "B"),
        }
        mesh = {"positions": packed([0, 0, 0, 0.1, 0, 0, 0, 0.1, 0]),
                "indices": packed([0, 1, 2], "I")}  # fmt: skip
        placement = {"target": None, "path": [], "fixture": [], "let_go": list(let_go)}
        data = {
            "program_version": "1", "seed": "1", "finished": True, "object": "toy", "mass": 1,
            "symmetries": 1, "recorded_frames": count, "links": 1, "palm": 0, "fingers": ["TH", "FF"],
            "frames": frames, "object_mesh": 0, "meshes": [mesh], "parts": [], "spheres": [],
            "phases": [], "placement": placement, "beliefs": beliefs, "estimates": estimates,
        }  # fmt: skip
        page = (self.folder / "run/replay.html").read_text()
        begin = page.index(MARK) + len(MARK)
        toy = page[:begin] + json.dumps(data) + page[page.index("</script>", begin):]
        (self.folder / "toy.html").write_text(toy)
        return f"file://{self.folder}/toy.html"

    def carried_mm(self, page, t, view):
        """How far along x a view of the scene is drawn from where its pose is stated."""
        page.run(f"location.hash = 't={t}'; 1")
        page.wait(f"Math.abs(Number(document.getElementById('clock').textContent.split(' ')[0]) - {t}) < 0.006")
        return round(1000 * page.run(f"palpate.scene.{view}.matrix.elements[12]"), 1)

    def test_poses_move_with_the_palm_from_their_own_time_on(self):
        belief = {"time": 0.25, "source": "online", "in_hand": True, "entropy": 0,
                  "poses": [{"probability": 1, "T_world_object": STILL}]}  # fmt: skip
        with browser.Browser(400, 300) as page:
            page.open(self.moving_page([belief], [], range(10), [0.65]))
            at = {t: self.carried_mm(page, t, "belief") for t in (0.25, 0.3, 0.5, 0.65, 0.7, 0.9)}
            self.assertEqual(at, {0.25: 0, 0.3: 5, 0.5: 25, 0.65: 40, 0.7: 40, 0.9: 40})
            self.assertEqual(page.errors, [])

    def test_an_estimate_from_no_contacts_rests_until_two_fingers_touch(self):
        mode = {"T_world_object": STILL, "weight": 1, "rotation_sigma_deg": 1, "translation_sigma_mm": 1}
        contact = {"finger": 0, "p": [0, 0, 0], "n": [0, 0, 1]}
        resting = {"time": 0, "status": "certain", "modes": [mode], "contacts": []}
        held = {**resting, "time": 0.7, "contacts": [contact]}
        with browser.Browser(400, 300) as page:
            page.open(self.moving_page([], [resting, held], range(4, 10)))
            at = {t: self.carried_mm(page, t, "estimates[0]") for t in (0, 0.2, 0.35, 0.4, 0.5, 0.65)}
            self.assertEqual(at, {0: 0, 0.2: 0, 0.35: 0, 0.4: 0, 0.5: 10, 0.65: 25})
            at = {t: self.carried_mm(page, t, "estimates[1]") for t in (0.7, 0.9)}
            self.assertEqual(at, {0.7: 0, 0.9: 20})
            # Touches go with the palm since then, too.
            self.assertEqual(self.carried_mm(page, 0.3, "touchMarks"), 0)
            self.assertEqual(self.carried_mm(page, 0.9, "touchMarks"), 50)
            self.assertEqual(page.errors, [])

    def test_two_recordings_on_a_telephone(self):
        page_path = self.run_json("view", "run", "run", "--out", "both")["page"]
        for width, columns in ((390, 1), (1280, 2)):
            with browser.Browser(width, 844) as page:
                page.call("Page.navigate", url=f"file://{self.folder}/{page_path}")
                page.wait("document.querySelectorAll('iframe').length === 2")
                lefts = page.run("[...document.querySelectorAll('iframe')].map((f) => f.getBoundingClientRect().x)")
                self.assertEqual(len(set(lefts)), columns)


if __name__ == "__main__":
    main()
