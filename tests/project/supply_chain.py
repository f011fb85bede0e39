# SPDX-License-Identifier: Apache-2.0
"""Checks what Palpate is built on: every package pinned by hash, licensed, and watched.

usage: supply_chain.py REPOSITORY
"""

import contextlib
import importlib.util
import io
import json
import pathlib
import re
import sys
import tempfile
import unittest

ROOT = pathlib.Path(sys.argv.pop(1)).resolve()


def load_dependencies():
    path = ROOT / "cmake" / "dependencies.py"
    spec = importlib.util.spec_from_file_location("dependencies", path)
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module


dependencies = load_dependencies()


class Pins(unittest.TestCase):
    def test_every_wheel_has_a_version_and_a_hash(self):
        components = list(dependencies.python_components())
        self.assertGreaterEqual(len(components), 4)
        for component in components:
            self.assertTrue(component["hashes"], component["name"])
        for path in (ROOT / "requirements").glob("*.txt"):
            lines = path.read_text().replace("\\\n", " ").splitlines()
            for line in filter(lambda line: line and not line.startswith("#"), lines):
                self.assertRegex(line, r"^[\w.-]+==\S+\s+--hash=sha256:[0-9a-f]{64}", path.name)

    def test_a_wheel_is_pinned_by_its_own_name(self):
        with tempfile.TemporaryDirectory() as folder:
            for name in ("palpate", "palpate_sim"):
                wheel = pathlib.Path(folder) / f"{name}-0.1.0-cp311-cp311-linux_x86_64.whl"
                wheel.write_bytes(b"a wheel")
                with contextlib.redirect_stdout(io.StringIO()) as printed:
                    dependencies.pin(wheel)
                start = f"{name.replace('_', '-')} @ file:///"
                self.assertTrue(printed.getvalue().startswith(start), printed.getvalue())

    def test_the_hands_are_of_the_same_package(self):
        """The wheel of palpate[hands] passes on what `palpate hand install` downloads."""
        source = (ROOT / "src" / "simulation" / "hand" / "hand_store.cpp").read_text()
        pinned = (ROOT / "requirements" / "hands.txt").read_text()
        (package,) = re.findall(r'kPackage = "(.*)"', source)
        (digest,) = re.findall(r'kHash = "(.*)"', source)
        self.assertIn(f"\n{package} ", pinned)
        self.assertEqual(re.findall(r"sha256:(\w+)", pinned), [digest])

    def test_every_npm_package_has_a_hash_and_a_licence(self):
        locks = list(dependencies.npm_locks())
        self.assertEqual(len(locks), 2)
        for file in locks:
            lock = json.loads(file.read_text())
            wanted = json.loads((file.parent / "package.json").read_text())
            self.assertEqual(lock["packages"][""]["dependencies"], wanted["dependencies"])
            for path, package in lock["packages"].items():
                if path:
                    self.assertTrue(package["integrity"].startswith("sha512-"), path)
                    self.assertIn(package.get("license"), {"MIT", "Public Domain"}, path)

    def test_the_bunny_is_no_part_of_the_product(self):
        required = [c for c in dependencies.npm_components() if c["scope"] == "required"]
        self.assertTrue(required)
        self.assertNotIn("bunny", [component["name"] for component in required])
        install = (ROOT / "cmake" / "PalpateInstall.cmake").read_text()
        self.assertIn('PATTERN "bunny.ply" EXCLUDE', install)

    def test_scripts_of_packages_do_not_run(self):
        scripts = (ROOT / "dev", *ROOT.glob("*/*.sh"), *ROOT.glob("docs/site/*.sh"))
        self.assertEqual(len(scripts), 4)
        text = "\n".join(script.read_text() for script in scripts)
        self.assertEqual(re.findall(r"npm (?:ci|install) (?!.*--ignore-scripts).*", text), [])
        installs = re.findall(r'(?:bin/pip"|"\$1"|-m pip) install(?:.*\\\n)*.*', text)
        self.assertTrue(installs)
        for line in installs:
            self.assertIn("--require-hashes", line)
            self.assertIn("--only-binary :all:", line)


class Licences(unittest.TestCase):
    def test_what_is_linked_or_shipped_is_listed_with_its_licence(self):
        text = (ROOT / "docs" / "licences.md").read_text()
        for line in (ROOT / "requirements" / "simulation.txt").read_text().splitlines():
            if match := re.match(r"([\w-]+)==(\S+)", line):
                name, version = match.groups()
                self.assertRegex(text, rf"`{name}` {re.escape(version)} \| \S")
        for file in dependencies.npm_locks():
            wanted = json.loads((file.parent / "package.json").read_text())["dependencies"]
            for name, version in wanted.items():
                self.assertRegex(text, rf"`{name}` {re.escape(version)} \| \S")

    def test_every_debian_library_is_listed(self):
        text = (ROOT / "docs" / "licences.md").read_text().lower().replace("-", "").replace("+", "")
        words = {
            "libeigen3dev": "eigen", "libfmtdev": "{fmt}", "libtomlplusplusdev": "toml",
            "libcli11dev": "cli11", "nlohmannjson3dev": "nlohmann", "libhdf5dev": "hdf5",
            "libnanoflanndev": "nanoflann", "libqhulldev": "qhull", "libgtestdev": "googletest",
            "libbenchmarkdev": "google benchmark", "libboostdev": "boost", "libegl1": "mesa",
            "libegldev": "mesa", "libgl1mesadri": "mesa", "libopengl0": "libglvnd",
            "libpngdev": "libpng", "libompldev": "ompl", "libnloptdev": "nlopt",
            "cycloneddsdev": "cyclone dds", "libzstddev": "zstandard", "liblz4dev": "lz4",
        }  # fmt: skip
        tools = {"g++", "cmake", "ninja-build", "ccache", "python3-venv"}
        for package in dependencies.debian_packages():
            if package not in tools:
                self.assertIn(words[package.replace("-", "").replace("+", "")], text, package)


class Stamps(unittest.TestCase):
    def setUp(self):
        temporary = tempfile.TemporaryDirectory()
        self.addCleanup(temporary.cleanup)
        self.deps = pathlib.Path(temporary.name)
        (self.deps / "lib" / "sub").mkdir(parents=True)
        (self.deps / "lib" / "sub" / "a").write_text("a")

    def check(self):
        return dependencies.check("wheels", self.deps)

    def test_an_altered_file_is_noticed(self):
        self.assertFalse(self.check())
        dependencies.note("wheels", self.deps, "requirements/simulation.txt", "lib")
        self.assertTrue(self.check())
        (self.deps / "lib" / "sub" / "a").touch()  # the same content at another time
        self.assertTrue(self.check())
        (self.deps / "lib" / "sub" / "a").write_text("b")
        self.assertFalse(self.check())
        (self.deps / "lib" / "sub" / "a").write_text("a")
        self.assertTrue(self.check())
        (self.deps / "lib" / "new").write_text("")
        self.assertFalse(self.check())


class Materials(unittest.TestCase):
    def test_the_bill_names_every_kind(self):
        kinds = {c["purl"].split("/")[0] for c in [
            *dependencies.python_components(), *dependencies.npm_components(),
            *dependencies.debian_components()]}  # fmt: skip
        self.assertEqual(kinds, {"pkg:pypi", "pkg:npm", "pkg:deb"})


if __name__ == "__main__":
    unittest.main()
