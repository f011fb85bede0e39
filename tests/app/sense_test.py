# SPDX-License-Identifier: Apache-2.0
"""The sense command: contacts that slide on a flat face, bad rows among them, and bad input."""

import os
import random

from cli import BAD_INPUT, USAGE, CliTest, main

HEADER = "finger,t,px,py,pz,fx,fy,fz,nx,ny,nz"


def slide(count=300):
    """Rows of a finger that slides along x on the plane z = 0 and back along y."""
    stream = random.Random(1)
    rows = []
    for i in range(count):
        t = 0.01 * i
        along = (0.02 * t, 0.0) if i < count // 2 else (0.03, 0.02 * (t - 1.5))
        u = (1, 0) if i < count // 2 else (0, 1)
        point = [along[0], along[1], stream.gauss(0, 1e-4)]
        force = [u[0] + stream.gauss(0, 0.05), u[1] + stream.gauss(0, 0.05), -2.0]
        rows.append(["FF", round(t, 2), *point, *force, 0, 0, 1])
    return rows


def corner(tip_normals, count=300):
    """Rows of a finger that slides along x over an edge and down the face behind it."""
    stream = random.Random(2)
    rows = []
    for i in range(count):
        over = i >= count // 2
        s = 0.0003 * (i - count // 2)
        point, n, along = ([0, 0, -s], (1, 0, 0), (0, 0, -1)) if over else ([s, 0, 0], (0, 0, 1), (1, 0, 0))
        force = [a + stream.gauss(0, 0.05) - 2.0 * b for a, b in zip(along, n)]
        noisy = [b + stream.gauss(0, 0.1) for b in n]
        row = ["FF", round(0.01 * i, 2), *[x + stream.gauss(0, 2e-4) for x in point], *force, *n]
        rows.append(row + noisy if tip_normals else row)
    return rows


def csv(rows):
    return "\n".join([HEADER if len(rows[0]) == 11 else HEADER + ",tnx,tny,tnz"] + [",".join(map(str, row)) for row in rows]) + "\n"


class Sense(CliTest):
    def test_errors_and_flags_are_reported_and_series_written(self):
        rows = slide()
        rows[50][5:8] = [0, -1, 0]
        rows[60][5:8] = [0, 0, 0]
        rows[70][2] = "nan"
        self.write("slide.csv", csv(rows))
        for estimator in ("s2", "s2-lag", "rls"):
            report = self.run_json(
                "sense", "slide.csv", "--estimator", estimator, "--out", "out", "--force")
            stream = report["streams"]["FF"]
            self.assertEqual(stream["samples"], 300)
            self.assertEqual(stream["flagged"], 3)
            self.assertEqual(stream["flags"], {"placeholder": 1, "no_force": 1, "not_finite": 1})
            self.assertLess(stream["error_deg"]["median"], 5, estimator)
            if estimator.startswith("s2"):
                self.assertGreater(stream["normalized_error_squared"], 0, estimator)
            self.assertAlmostEqual(stream["force_n"]["median"], 5**0.5, delta=0.05)
        names = {path.name for path in (self.folder / "out").iterdir()}
        self.assertEqual(names, {"report.json", "contacts.csv", "FF.csv", "FF-normal.svg", "FF-force.svg"})
        header, *rows = (self.folder / "out" / "contacts.csv").read_text().splitlines()
        self.assertTrue(header.startswith("finger,t,x,y,z,nx,ny,nz,normal_sigma"), header)
        self.assertGreater(len(rows), 200)
        self.assertNotIn("nan", "".join(rows))

    def test_flags_are_named_in_the_table_and_explained_in_the_help(self):
        rows = slide()
        rows[50][5:8] = [0, -1, 0]
        self.write("slide.csv", csv(rows))
        heading, row, last = self.run_program("sense", "slide.csv", "--estimator", "rls").stdout.splitlines()
        self.assertTrue(heading.endswith("  flags"), heading)
        self.assertTrue(row.endswith("  placeholder 1"), row)
        self.assertTrue(last.startswith("Next: palpate sense slide.csv --estimator rls --out out/sense"), last)
        self.assertIn("the column flags says why", self.run_program("sense", "--help").stdout)

    def test_its_contacts_are_localized(self):
        """A slide on the plane z = 0: in the pose that is found a face of the box lies there."""
        self.write("slide.csv", csv(slide()))
        self.run_json("sense", "slide.csv", "--out", "out")
        report = self.run_json("localize", "box", "out/contacts.csv", "--set", "search.proposals=12000",
                               "--set", "search.particles=200")  # fmt: skip
        self.assertTrue(report["modes"])
        upwards = report["modes"][0]["T_contact_object"][8:11]  # z of the object's axes
        self.assertGreater(max(map(abs, upwards)), 0.99)

    def test_normals_of_the_tip_help_at_an_edge(self):
        p95 = []
        for name, tip_normals in (("with", True), ("without", False)):
            self.write(f"{name}.csv", csv(corner(tip_normals)))
            p95.append(self.run_json("sense", f"{name}.csv")["streams"]["FF"]["error_deg"]["p95"])
        self.assertLess(p95[0], p95[1])

    def test_bad_input_is_refused_in_one_line(self):
        self.write("cell.csv", csv(slide()[:3]).replace("FF,0.01", "FF,soon"))
        self.assert_refused(BAD_INPUT, ["sense", "cell.csv"], "cell.csv:3", "soon")
        self.write("other.csv", "a,b\n1,2\n")
        self.assert_refused(BAD_INPUT, ["sense", "other.csv"], "other.csv", "recording")
        self.assert_refused(BAD_INPUT, ["sense", "none.csv"], "none.csv")
        self.assert_refused(USAGE, ["sense", "other.csv", "--estimator", "magic"], "magic")

    def test_times_are_written_as_they_were_read(self):
        rows = slide(40)
        for row in rows:
            row[1] = 1700000000 + round(row[1] + 0.005, 3)
        self.write("slide.csv", csv(rows))
        self.run_json("sense", "slide.csv", "--out", "out")
        times = [row[1] for row in rows]
        for name, column in (("FF.csv", 0), ("contacts.csv", 1)):
            lines = (self.folder / "out" / name).read_text().splitlines()[1:]
            written = [float(line.split(",")[column]) for line in lines]
            self.assertTrue(written and set(written) <= set(times), (name, written[:3]))
            self.assertEqual(len(set(written)), len(written), name)

    def test_a_name_that_makes_no_file_is_refused(self):
        for name in ("../evil", "a/b", ".hidden", "", "a\x07b", "x" * 201):
            self.write("slide.csv", csv([[name, *row[1:]] for row in slide(3)]))
            self.assert_refused(BAD_INPUT, ["sense", "slide.csv", "--out", "out"], "slide.csv:2", "finger")
        self.write("slide.csv", csv([["contacts", *row[1:]] for row in slide(3)]))
        self.assert_refused(BAD_INPUT, ["sense", "slide.csv", "--out", "out"], "contacts.csv")

    def test_no_file_is_replaced_unasked(self):
        self.write("slide.csv", csv(slide(40)))
        (self.folder / "out").mkdir()
        for name in ("FF.csv", "FF-normal.svg", "FF-force.svg"):
            path = self.folder / "out" / name
            path.write_text("kept")
            self.assert_refused(BAD_INPUT, ["sense", "slide.csv", "--out", "out"], name, "--force")
            self.assertEqual(path.read_text(), "kept")
            path.unlink()
        (self.folder / "out" / "FF.csv").write_text("old")
        self.run_json("sense", "slide.csv", "--out", "out", "--force")
        self.assertTrue((self.folder / "out" / "FF.csv").read_text().startswith("t,"))

    def test_force_leaves_no_stream_of_the_earlier_run(self):
        self.write("one.csv", csv(slide(40)))
        self.write("other.csv", csv([["MF", *row[1:]] for row in slide(40)]))
        self.run_json("sense", "one.csv", "--out", "out")
        self.write("out/notes.csv", "kept")
        self.run_json("sense", "other.csv", "--out", "out", "--force")
        names = {path.name for path in (self.folder / "out").iterdir()}
        self.assertEqual(
            names,
            {"report.json", "contacts.csv", "MF.csv", "MF-normal.svg", "MF-force.svg", "notes.csv"})  # fmt: skip

    def test_where_there_is_no_contact_none_is_written_or_recommended(self):
        rows = [[*row[:5], 0, 0, 0, *row[8:]] for row in slide(40)]
        self.write("still.csv", csv(rows))
        told = self.run_program("sense", "still.csv", "--out", "out").stdout
        self.assertIn("no contacts.csv: no sample", told)
        self.assertNotIn("Next:", told)
        self.assertNotIn("out/contacts.csv", self.contents())
        self.assertNotIn("Next:", self.run_program("sense", "still.csv").stdout)

    def test_contacts_of_less_than_the_least_force_are_left_out(self):
        rows = slide()
        for row in rows[100:150]:
            row[5:8] = [0.05, 0.02, -0.04]
        self.write("air.csv", csv(rows))
        self.assertEqual(self.run_json("sense", "air.csv")["streams"]["FF"]["flags"], {})
        report = self.run_json("sense", "air.csv", "--min-force", "0.3", "--out", "out")
        self.assertEqual(report["streams"]["FF"]["flags"]["no_force"], 50)
        times = [float(row.split(",")[1]) for row in (self.folder / "out/contacts.csv").read_text().splitlines()[1:]]
        self.assertFalse([t for t in times if 0.995 < t < 1.495])
        for force in ("-1", "11", "nan"):
            self.assert_refused(USAGE, ["sense", "air.csv", "--min-force", force], "--min-force")

    def test_times_in_another_unit_are_refused(self):
        rows = slide(40)
        self.write("s.csv", csv(rows))
        self.assert_refused(BAD_INPUT, ["sense", "s.csv", "--tick", "5"], "s.csv", "--tick")
        self.write("ms.csv", csv([[row[0], round(1000 * row[1]), *row[2:]] for row in rows]))
        self.assert_refused(BAD_INPUT, ["sense", "ms.csv"], "ms.csv", "in ms or ns?", "--tick")
        median = [self.run_json("sense", *log)["streams"]["FF"]["error_deg"]["median"]
                  for log in (["s.csv"], ["ms.csv", "--tick", "0.001"])]  # fmt: skip
        self.assertAlmostEqual(*median, delta=1e-3)

    def test_one_frame_ahead_of_time_does_not_lose_the_others(self):
        rows = slide(100)
        rows[49][1] = 999.0
        self.write("ahead.csv", csv(rows))
        flags = self.run_json("sense", "ahead.csv")["streams"]["FF"]["flags"]
        self.assertEqual(flags, {"gap": 2, "out_of_order": 4})

    def test_rows_that_are_there_twice_count_once(self):
        self.write("once.csv", csv(slide(40)))
        self.write("twice.csv", csv([row for row in slide(40) for _ in range(2)]))
        self.assertEqual(self.run_json("sense", "twice.csv"), self.run_json("sense", "once.csv"))

    def test_points_in_millimetres_are_noticed(self):
        self.write("m.csv", csv(slide()))
        self.assertEqual(self.run_json("sense", "m.csv")["hint"], "")
        self.write("mm.csv", csv([[*row[:2], *[1000 * x for x in row[2:5]], *row[5:]] for row in slide()]))
        self.assertIn("in millimetres?", self.run_json("sense", "mm.csv")["hint"])
        self.assertIn("in millimetres?", self.run_program("sense", "mm.csv").stdout)

    def test_a_header_is_read_as_the_rows_are(self):
        rows = csv(slide(40))
        self.write("plain.csv", rows)
        plain = self.run_json("sense", "plain.csv")
        for start, header, end in (("\ufeff", HEADER, "\n"), ("", HEADER.replace(",", " , "), "\n"),
                                   ("\n \n", HEADER, "\n"), ("\ufeff\r\n", HEADER, "\r\n")):  # fmt: skip
            text = start + rows.replace(HEADER, header).replace("\n", end)
            self.write("other.csv", text)
            self.assertEqual(self.run_json("sense", "other.csv"), plain, repr(text[:30]))

    def test_a_name_that_is_not_utf8_is_reported_with_a_mark_in_its_place(self):
        log = os.fsdecode(b"log-\xff.csv")
        self.write(log, csv(slide(40)).encode().replace(b"FF,", b"F\xfe,"))
        report = self.run_json("sense", log, "--out", "out")
        self.assertEqual(list(report["streams"]), ["F\ufffd"])
        self.assertIn(os.fsdecode(b"out/F\xfe.csv"), self.contents())

    def test_what_would_have_no_effect_is_refused(self):
        self.write("slide.csv", csv(slide()[:3]))
        self.write("options.toml", "lag = 0.1\n")
        for code, extra, named in (
            (USAGE, ["--set", "lag=0.1"], "--set"),
            (USAGE, ["--config", "options.toml"], "--config"),
            (BAD_INPUT, ["--model", "some.model"], "some.model"),
            (BAD_INPUT, ["--causal"], "--causal is an option of a log of a BioTac"),
        ):
            self.assert_refused(code, ["sense", "slide.csv", *extra], named)
        electrodes = ",".join(f"e{i}" for i in range(1, 20))
        self.write("biotac.csv", f"t_s,pdc,{electrodes}\n")
        for extra in (["--tick", "0.1"], ["--estimator", "rls"], ["--min-force", "0.1"]):
            self.assert_refused(BAD_INPUT, ["sense", "biotac.csv", *extra], extra[0], "biotac.csv")

    def test_a_model_is_not_overwritten_unasked(self):
        self.write("old.model", "kept")
        self.write("log.csv", "t_s,pdc\n")
        for kind in (["biotac-normal", "log.csv"], ["biotac-electrodes", "log.csv"], ["biotac-network"],
                     ["biotac-inverse"]):  # fmt: skip
            self.assert_refused(
                BAD_INPUT, ["train", *kind, "--out", "old.model"], "old.model exists", "--force")
        for kind in ("biotac-network", "biotac-inverse"):
            self.assert_refused(BAD_INPUT, ["train", kind, "--out", "new.model", "--write-data", "old.model"],
                                "old.model exists", "--force")  # fmt: skip
        self.assertEqual((self.folder / "old.model").read_text(), "kept")


if __name__ == "__main__":
    main()
