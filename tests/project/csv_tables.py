# SPDX-License-Identifier: Apache-2.0
"""Checks that CSV files of a folder have as many cells in each row as columns, and are as the tables.

usage: csv_tables.py FOLDER
"""

import csv
import pathlib
import sys


def table_of(markdown):
    rows = [line for line in markdown.splitlines() if line.startswith("| ")]
    return [row.strip("|").split("|") for row in rows if not row.startswith("| ---")]


def main(folder):
    files = sorted(pathlib.Path(folder).glob("*.csv"))
    faults, quoted = [], 0
    for file in files:
        with file.open(newline="") as text:
            rows = list(csv.reader(text, strict=True))
        expected = table_of(file.with_suffix(".md").read_text())
        if rows != [[cell.strip() for cell in row] for row in expected]:
            faults.append(f"{file}: not the cells of its table")
        quoted += any("," in cell for row in rows for cell in row)
    if not quoted:
        faults.append(f"{folder}: no table with a comma in a cell")
    print("\n".join(faults) if faults else f"{len(files)} tables")
    return 1 if faults else 0


if __name__ == "__main__":
    sys.exit(main(*sys.argv[1:]))
