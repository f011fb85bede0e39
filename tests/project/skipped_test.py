# SPDX-License-Identifier: Apache-2.0
"""The summary of what was skipped, from logs as ctest writes them."""

import unittest

from skipped import summary

LOG = """Start testing: Nov 27 02:00 UTC
----------------------------------------------------------
1/4 Testing: app.live
1/4 Test: app.live
Output:
----------------------------------------------------------
test_a (__main__.Page.test_a)
The page. ... skipped 'Chromium is not installed'
test_b (__main__.Page.test_b) ... skipped 'Chromium is not installed'
test_c (__main__.Page.test_c) ... skipped "no one's node"
test_d (__main__.Page.test_d) ... ok

OK (skipped=3)
<end of output>
Test Passed.
2/4 Testing: simulation.Renderer.Draws
Output:
[ RUN      ] Renderer.Draws
tests/simulation/renderer_test.cpp:47: Skipped
neither EGL nor OSMesa works here

[  SKIPPED ] Renderer.Draws (0 ms)
3/4 Testing: docs.site_links
Output:
skipped: there is no site; ./dev docs builds it
4/4 Testing: core.File.Reads
Output:
a log with the words skipped, Skipped and "skipped" in it
[       OK ] File.Reads (0 ms)
"""


class Summary(unittest.TestCase):
    def test_every_reason_is_named_with_its_test_and_how_often(self):
        self.assertEqual(summary(LOG).splitlines(), [
            "5 checks were skipped:",
            "  app.live: Chromium is not installed (2 checks)",
            "  app.live: no one's node",
            "  simulation.Renderer.Draws: neither EGL nor OSMesa works here",
            "  docs.site_links: there is no site; ./dev docs builds it",
        ])  # fmt: skip

    def test_nothing_skipped(self):
        self.assertEqual(summary("1/1 Testing: a\n[       OK ] A.B\n"), "no check was skipped")


if __name__ == "__main__":
    unittest.main()
