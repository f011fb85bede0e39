# SPDX-License-Identifier: Apache-2.0
"""Checks that the built site is whole without a network.

usage: site_links.py FOLDER   (the site's html folder; without it the test is skipped, exit code 77)

Every link and picture leads to a file of the site, every anchor to an element of its page, and no
page loads a script, style, font or picture from elsewhere. Links that a reader follows may.
"""

import html.parser
import pathlib
import sys
import urllib.parse

SKIPPED = 77
LOADED = {("script", "src"), ("img", "src"), ("link", "href"), ("iframe", "src"), ("source", "src")}


class Page(html.parser.HTMLParser):
    """Anchors of a page and what it refers to, as (tag, attribute, target)."""

    def __init__(self, path):
        super().__init__()
        self.anchors, self.targets = {"", "top"}, []
        self.feed(path.read_text())

    def handle_starttag(self, tag, attributes):
        for name, value in attributes:
            if name in ("id", "name") and value:
                self.anchors.add(value)
            if name in ("href", "src") and value:
                self.targets.append((tag, name, value))


def fault_of(target, path, pages):
    """What is wrong with a target on the page at a path, or None."""
    tag, name, value = target
    parts = urllib.parse.urlsplit(value)
    if parts.scheme == "data":
        return None
    if parts.scheme or parts.netloc:
        return f"loads {value}" if (tag, name) in LOADED else None
    file = (path.parent / urllib.parse.unquote(parts.path)).resolve() if parts.path else path
    if file.is_dir():
        file /= "index.html"
    if not file.exists():
        return f"no such file: {value}"
    if parts.fragment and file in pages and parts.fragment not in pages[file].anchors:
        return f"no such anchor: {value}"
    return None


def main(folder):
    folder = pathlib.Path(folder).resolve()
    if not (folder / "index.html").exists():
        print(f"skipped: there is no site in {folder}; ./dev docs builds it")
        return SKIPPED
    pages = {path: Page(path) for path in folder.rglob("*.html")
             if path.relative_to(folder).parts[0] != "cpp"}  # fmt: skip
    faults = [f"{path.relative_to(folder)}: {fault}"
              for path, page in sorted(pages.items())
              for fault in sorted({fault_of(t, path, pages) for t in page.targets} - {None})]  # fmt: skip
    print("\n".join(faults) if faults else f"{len(pages)} pages are whole")
    return 1 if faults else 0


if __name__ == "__main__":
    sys.exit(main(*sys.argv[1:]))
