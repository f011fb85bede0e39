# SPDX-License-Identifier: Apache-2.0
"""The colcon package: built by what Debian has of ROS 2's build tools, and its launch file."""

import os
import pathlib
import runpy
import shutil
import subprocess
import sys
import types
import unittest
from unittest import mock

from cli import DONE, CliTest, main

PACKAGE = pathlib.Path(__file__).resolve().parents[2] / "ros2" / "palpate_ros2"
DEBIAN = "/usr/sbin:/usr/bin:/sbin:/bin"  # whose Python has ament_package


class Launch(CliTest):
    def launched(self):
        """What the launch file runs, with stand-ins for ROS 2's launch, which Debian 12 has not."""

        class Named:
            def __init__(self, name="", default_value="", cmd=(), output=""):
                self.name, self.default, self.command = name, default_value, list(cmd)

        launch, actions, substitutions = (types.ModuleType(name) for name in (
            "launch", "launch.actions", "launch.substitutions"))  # fmt: skip
        launch.LaunchDescription = list
        actions.DeclareLaunchArgument = actions.ExecuteProcess = substitutions.LaunchConfiguration = Named
        with mock.patch.dict(sys.modules, {module.__name__: module for module in (launch, actions, substitutions)}):
            file = runpy.run_path(str(PACKAGE / "launch/estimate.launch.py"))
        *declared, process = file["generate_launch_description"]()
        defaults = {argument.name: argument.default for argument in declared}
        return [getattr(word, "name", None) and defaults[word.name] or word for word in process.command]

    def test_the_launch_file_runs_a_command_that_there_is(self):
        command = self.launched()
        self.assertEqual(command[:3], ["palpate", "ros2", "estimate"])
        helped = self.run_program("ros2", "estimate", "--help")
        self.assertEqual(helped.returncode, DONE)
        options = [word for word in command if word.startswith("--")]
        self.assertGreater(len(options), 3)
        for option in options:
            self.assertIn(option + " ", helped.stdout)
        # All is understood up to the object, which there is not.
        command[command.index("--object") + 1] = "none.stl"
        done = self.run_program(*command[1:])
        self.assertIn("none.stl", done.stderr)


@unittest.skipUnless(shutil.which("colcon", path=DEBIAN) and pathlib.Path("/usr/share/ament_cmake").exists(),
                     "colcon is not installed (Debian: colcon python3-colcon-ros ament-cmake)")  # fmt: skip
class Colcon(CliTest):
    def test_debians_colcon_builds_it(self):
        shutil.copytree(PACKAGE, self.folder / "src" / PACKAGE.name)
        environment = dict(os.environ, PATH=DEBIAN)
        built = subprocess.run(["colcon", "--log-base", "log", "build"], cwd=self.folder, env=environment,
                               capture_output=True, text=True)  # fmt: skip
        self.assertEqual(built.returncode, 0, built.stderr)
        share = self.folder / "install" / PACKAGE.name / "share"
        self.assertTrue((share / PACKAGE.name / "launch/estimate.launch.py").exists())
        self.assertTrue((share / "ament_index/resource_index/packages" / PACKAGE.name).exists())
        found = subprocess.run(["sh", "-c", ". install/setup.sh && echo $AMENT_PREFIX_PATH"], cwd=self.folder,
                               env=environment, capture_output=True, text=True)  # fmt: skip
        self.assertIn(str(self.folder / "install" / PACKAGE.name), found.stdout)


if __name__ == "__main__":
    main()
