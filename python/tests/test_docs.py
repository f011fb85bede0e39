# SPDX-License-Identifier: Apache-2.0
"""What the documents show of Python exists, and what needs no hand runs as it is printed."""

import ast
import contextlib
import inspect
import io
import os
import pathlib
import re
import unittest

import palpate

try:
    from palpate import sim
except ImportError:
    sim = None

EXAMPLES = pathlib.Path(
    os.environ.get("PALPATE_EXAMPLES", pathlib.Path(__file__).parents[2] / "examples" / "python")
)
ROOT = EXAMPLES.parents[1]
BLOCK = re.compile(r"^```python\n(.*?)^```", re.MULTILINE | re.DOTALL)


def blocks(document):
    return BLOCK.findall(document.read_text())


def chain(node):
    """The names of a.b.c; None for what is no such chain."""
    names = []
    while isinstance(node, ast.Attribute):
        names.append(node.attr)
        node = node.value
    return [node.id, *names[::-1]] if isinstance(node, ast.Name) else None


def keywords_of(function):
    """Names of the arguments of a function of the package; None where they cannot be known."""
    if inspect.isclass(function):
        function = function.__init__
    texts = [signature[0] for signature in getattr(function, "__nb_signature__", ())]
    if not texts:
        return None
    return {name for text in texts for name in re.findall(r"(\w+)\s*:", text)}


class Documents(unittest.TestCase):
    @unittest.skipUnless((ROOT / "docs").is_dir(), "there are no documents here")
    def setUp(self):
        self.packages = {"palpate": palpate} | ({"sim": sim} if sim else {})

    def meant(self, names):
        """The object that a chain names, None if it is not of these packages."""
        value = self.packages.get(names[0])
        for name in names[1:]:
            if value is None or inspect.isdatadescriptor(value):
                return None
            if inspect.ismodule(value) and not hasattr(value, name) and name in ("sim", "envs", "export"):
                return None  # a part that is imported by itself
            value = getattr(value, name)
        return value

    def test_names_and_arguments_exist(self):
        looked = 0
        for document in [ROOT / "README.md", *sorted((ROOT / "docs").glob("*.md"))]:
            for block in blocks(document):
                for node in ast.walk(ast.parse(block)):
                    names = chain(node) if isinstance(node, ast.Attribute) else None
                    if names and names[0] in self.packages:
                        self.meant(names)  # or AttributeError
                        looked += 1
                    names = chain(node.func) if isinstance(node, ast.Call) else None
                    known = names and len(names) > 1 and keywords_of(self.meant(names))
                    given = {word.arg for word in node.keywords if word.arg} if known else set()
                    self.assertLessEqual(given, known or set(), f"{document.name}: {names}")
        self.assertGreater(looked, 20)

    def test_the_first_steps_run(self):
        """As far as the page goes without a hand, in one session, in a checkout's folder."""
        first = [block for page in ("README.md", "docs/start.md", "docs/python.md")
                 for block in blocks(ROOT / page) if "ObjectModel(" in block]  # fmt: skip
        self.assertEqual(len(first), 4)
        names = {}
        with contextlib.chdir(ROOT), contextlib.redirect_stdout(io.StringIO()) as printed:
            for block in first:
                exec(block, names)
        self.assertEqual(printed.getvalue().count("certain"), 3)
        self.assertEqual(names["found"].best, 1)
        self.assertGreater(names["found"].probabilities[1], 0.9)


if __name__ == "__main__":
    unittest.main()
