# SPDX-License-Identifier: Apache-2.0
"""Sphinx's configuration of the documentation site; build.py runs Sphinx with it.

The site is read without a network: no fonts or scripts from elsewhere, equations as MathML.
"""

import pathlib

from latex2mathml.converter import convert

project = "Palpate"
author = "The Palpate authors"
copyright = "2026, The Palpate authors"  # noqa: A001
root_doc = "index"
extensions = ["myst_parser"]
myst_enable_extensions = ["dollarmath", "amsmath"]
myst_heading_anchors = 4
html_theme = "furo"
html_title = "Palpate"
html_copy_source = False
html_static_path = [str(pathlib.Path(__file__).with_name("static"))]
html_css_files = ["site.css"]
MATH_FONT = pathlib.Path("/usr/share/fonts/truetype/dejavu/DejaVuMathTeXGyre.ttf")
if MATH_FONT.exists():  # else equations have the font of the browser
    html_static_path.append(str(MATH_FONT))
html_math_renderer = "mathml"
suppress_warnings = ["myst.header", "misc.highlighting_failure"]
exclude_patterns = []

CONTENTS = pathlib.Path(__file__).with_name("contents.txt")


def contents():
    """The site's table of contents, as toctrees below the first page."""
    for block in CONTENTS.read_text().split("\n\n"):
        caption, *pages = block.strip().splitlines()
        entries = "\n".join(page.strip() for page in pages)
        yield f"\n```{{toctree}}\n:hidden:\n:caption: {caption}\n:maxdepth: 2\n\n{entries}\n```\n"


def add_contents(app, name, source):
    if name == root_doc:
        source[0] += "".join(contents())


def add_equation(display):
    def visit(translator, node):
        from docutils.nodes import SkipNode

        mathml = convert(node.astext(), display="block" if display else "inline")
        translator.body.append(f'<div class="math">{mathml}</div>' if display else mathml)
        raise SkipNode

    return visit


def setup(app):
    app.add_html_math_renderer(
        "mathml", (add_equation(False), None), (add_equation(True), None)
    )
    app.connect("source-read", add_contents)

