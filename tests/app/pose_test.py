# SPDX-License-Identifier: Apache-2.0
"""Poses on the command line, and files of them."""

import os
import threading

from cli import BAD_INPUT, DONE, CliTest, main

POSE = "1 0 0 0\r\n0 1 0 0\r\n0 0 1 0\r\n0 0 0 1\r\n"


class Pose(CliTest):
    def setUp(self):
        super().setUp()
        points = ["0,0,0", "1,0,0", "0,1,0", "0,0,1"]
        rows = [f"{point},{point}" for point in points]
        self.write("pairs.csv", "\n".join(["sx,sy,sz,tx,ty,tz", *rows, ""]))
        self.pairs = "--correspondences", "pairs.csv"

    def test_a_file_of_another_system_is_read(self):
        self.write("pose.txt", b"\xef\xbb\xbf" + POSE.encode())
        self.assertEqual(self.run_json("certify", "pose.txt", *self.pairs)["status"], "certified")

    def test_a_pipe_is_read(self):
        os.mkfifo(self.folder / "pipe")
        writer = threading.Thread(target=(self.folder / "pipe").write_text, args=[POSE])
        writer.start()
        done = self.run_program("certify", "pipe", *self.pairs)
        writer.join()
        self.assertEqual(done.returncode, DONE, done.stderr)

    def test_a_coordinate_that_cannot_be_is_refused(self):
        for far in ("1e300", "-1e13"):
            pose = POSE.split()
            pose[3] = far
            self.assert_refused(BAD_INPUT, ["certify", " ".join(pose), *self.pairs], "a coordinate of")

    def test_what_is_no_pose_is_named(self):
        self.assert_refused(BAD_INPUT, ["certify", ".", *self.pairs], "'.' is neither a file nor 16 numbers")
        self.write("pose.txt", "1 2 3")
        self.assert_refused(BAD_INPUT, ["certify", "pose.txt", *self.pairs], "'pose.txt' does not hold 16 numbers")


if __name__ == "__main__":
    main()
