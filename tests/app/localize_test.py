# SPDX-License-Identifier: Apache-2.0
"""The localize command: a box file in its own coordinates, and every kind of bad contacts."""

import json
import math
import os
import pathlib
import random
import threading

from cli import BAD_INPUT, DONE, NO_SOLUTION, USAGE, CliTest, box_stl, main

HEADER = "x,y,z,nx,ny,nz"
SIZE = (0.05, 0.094, 0.175)
HALF = [size / 2 for size in SIZE]
SHIFT, ANGLE = (0.3, -0.2, 0.5), 0.7  # where the box is: turned about z, then moved
QUICK = ["--set", "search.proposals=12000", "--set", "search.particles=200"]


def moved(v, shift=(0, 0, 0)):
    c, s = math.cos(ANGLE), math.sin(ANGLE)
    turned = (c * v[0] - s * v[1], s * v[0] + c * v[1], v[2])
    return [a + b for a, b in zip(turned, shift)]


def contacts_on_box(count, faces=(0, 1, 2, 3, 4, 5), seed=1):
    """Rows of exact contacts on faces of the box 0..SIZE, where SHIFT and ANGLE put it."""
    stream = random.Random(seed)
    rows = []
    for i in range(count):
        axis, high = divmod(faces[i % len(faces)], 2)
        point = [size * stream.uniform(0.1, 0.9) for size in SIZE]
        point[axis] = SIZE[axis] * high
        normal = [0.0, 0.0, 0.0]
        normal[axis] = 2.0 * high - 1
        rows.append(moved(point, SHIFT) + moved(normal))
    return rows


def middle(T):
    """Where a pose, 16 numbers, puts the middle of the box."""
    return [sum(T[4 * i + j] * HALF[j] for j in range(3)) + T[4 * i + 3] for i in range(3)]


def csv(rows, header=HEADER):
    return "\n".join([header] + [",".join(map(str, row)) for row in rows]) + "\n"


class Localize(CliTest):
    def setUp(self):
        super().setUp()
        self.write("box.stl", box_stl(*SIZE))

    def localize(self, rows, *options, header=HEADER, code=DONE):
        self.write("contacts.csv", csv(rows, header))
        done = self.run_program("localize", "box.stl", "contacts.csv", "--json", *QUICK, *options)
        self.assertEqual(done.returncode, code, done.stderr)
        return json.loads(done.stdout)

    def test_says_what_lies_outside_the_modes(self):
        result = self.localize(contacts_on_box(3))
        listed = sum(mode["weight"] for mode in result["modes"])
        self.assertLess(listed, 0.95)
        self.assertAlmostEqual(result["residual_mass"], 1 - listed)
        self.assertGreater(len(result["residual_set"]), 0)
        self.assertGreater(result["credible_mass"], listed)
        self.assertLessEqual(result["credible_mass"], 0.95)
        self.assertTrue(all(len(pose) == 16 for pose in result["residual_set"]))
        certain = self.localize(contacts_on_box(18))
        self.assertEqual(certain["residual_set"], [])

    def test_pose_maps_the_files_own_coordinates(self):
        for method in ("fast", "full"):
            result = self.localize(contacts_on_box(18), "--method", method)
            self.assertEqual(result["status"], "certain", method)
            best = result["modes"][0]
            self.assertIsNone(best["free_axis"])
            self.assertEqual(len(best["covariance"]), 36)
            self.assertGreater(best["weight"], 0.95)
            # The box's middle and axes, whichever of the box's four equal poses was found.
            T = best["T_contact_object"]
            for value, true in zip(middle(T), moved(HALF, SHIFT)):
                self.assertAlmostEqual(value, true, delta=0.003)
            self.assertGreater(abs(T[10]), math.cos(math.radians(5)))
            self.assertGreater(abs(T[0] * math.cos(ANGLE) + T[4] * math.sin(ANGLE)), 0.99)
            self.assertGreater(result["prepare_seconds"], 0)
            self.assertGreater(result["seconds"], 0)

    def test_the_same_seed_gives_the_same(self):
        first, second = (self.localize(contacts_on_box(9), "--seed", "3") for _ in range(2))
        self.assertEqual(first["modes"], second["modes"])

    def test_an_error_of_the_centre_of_mass_goes_with_a_table(self):
        self.localize(contacts_on_box(9))  # writes the files
        command = ["localize", "box.stl", "contacts.csv", "--set", "centroid_sigma=0.003"]
        self.assert_refused(BAD_INPUT, command, "centroid_sigma = 0.003 goes with --table")

    def test_rows_out_of_order(self):
        rows = [row + [float(i)] for i, row in enumerate(contacts_on_box(12))]
        header = HEADER + ",t"
        first = self.localize(rows, header=header)
        random.Random(2).shuffle(rows)
        self.assertEqual(self.localize(rows, header=header)["modes"], first["modes"])

    def test_too_little_is_ambiguous(self):
        one = contacts_on_box(1)
        for rows in (one, one * 6, contacts_on_box(10, faces=[5])):
            result = self.localize(rows)
            self.assertEqual(result["status"], "ambiguous")
            self.assertLessEqual(len(result["modes"]), 16)

    def test_no_contacts_are_refused_before_the_mesh_is_prepared(self):
        self.write("contacts.csv", HEADER + "\n")
        for mesh in ("box.stl", "nosuch"):
            self.assert_refused(BAD_INPUT, ["localize", mesh, "contacts.csv"], "contacts.csv has no contacts")
        result = self.localize([], "--table", "0")  # the stable poses
        self.assertEqual(result["status"], "ambiguous")

    def test_contacts_come_through_a_pipe_of_which_a_far_one_is_named(self):
        pipe = self.folder / "pipe"
        os.mkfifo(pipe)

        def through_pipe(rows):
            writer = threading.Thread(target=pipe.write_text, args=(csv(rows),), daemon=True)
            writer.start()
            done = self.run_program("localize", "box.stl,mug", str(pipe), "--json", *QUICK)
            writer.join(10)
            return done

        rows = contacts_on_box(9)
        self.assertEqual(through_pipe(rows).returncode, DONE)
        refused = through_pipe([*rows, [12.0, 0, 0, 0, 0, 1]])
        self.assertEqual(refused.returncode, BAD_INPUT)
        self.assertIn(":11: the contact is ", refused.stderr)

    def test_contacts_of_another_object(self):
        """A ball of 30 mm, twice as wide as the box is thick."""
        stream, rows = random.Random(3), []
        for _ in range(20):
            n = [stream.gauss(0, 1) for _ in range(3)]
            length = math.hypot(*n)
            n = [v / length for v in n]
            rows.append([0.05 * v for v in n] + n)
        self.assertEqual(self.localize(rows, code=NO_SOLUTION)["status"], "no_pose")

    def test_flipped_normals_are_named(self):
        rows = [row[:3] + [-v for v in row[3:]] for row in contacts_on_box(18)]
        result = self.localize(rows, code=NO_SOLUTION)
        self.assertEqual(result["status"], "no_pose")
        self.assertIn("reversed", result["hint"])

    def test_a_table_at_another_height_is_named(self):
        rows = contacts_on_box(18)
        result = self.localize(rows, "--table", str(SHIFT[2] + 0.1), code=NO_SOLUTION)
        self.assertIn("without --table one does", result["hint"])
        self.assertIn("0.6 m", result["hint"])
        rows = [[2 * v for v in row[:3]] + row[3:] for row in rows]  # of a box twice as large
        result = self.localize(rows, "--table", "0", code=NO_SOLUTION)
        self.assertIn("with --table or without: another object", result["hint"])

    def test_ten_thousand_contacts(self):
        result = self.localize(contacts_on_box(10000))
        self.assertEqual(result["status"], "certain")
        self.assertLess(result["seconds"], 5)

    def refuse(self, text, *words):
        self.write("contacts.csv", text)
        self.assert_refused(BAD_INPUT, ["localize", "box.stl", "contacts.csv"], *words)

    def test_files_that_are_no_contacts(self):
        self.refuse("", "empty")
        self.refuse("x,y,z,nx\n0,0,0,1\n", "ny")
        self.refuse(csv([[0, 0, "nan", 0, 0, 1]]), "contacts.csv:2", "nan", "z")
        self.refuse(csv([[0, 0, 0, 0, 0, 1], [0, 0, 0, 0, 0, 0]]), "contacts.csv:3", "length 0")
        self.refuse(csv([[0, 0, 0, 0, 0, 2]]), "contacts.csv:2", "length 2")
        self.refuse("x,y,z,point_sigm\n0,0,0,1\n", "'point_sigm'", "known: x, y, z", "'point_sigma'?")
        self.refuse(csv([[0, 0, 0, 0, 0]]), "contacts.csv:2", "5 values for 6 columns")
        self.refuse(csv([[0, 0, 0, 0, "?", 1]]), "'?'")

    def test_headers_that_are_none_are_named(self):
        for header in ("x;y;z", "x\ty\tz", "0.1,0.2,0.3"):
            self.refuse(f"{header}\n1,2,3\n",
                        f"expected a comma-separated header with x,y,z; found '{header}'")
        self.refuse("X,Y,Z\n1,2,3\n", "did you mean x,y,z?")

    def test_a_contact_far_from_the_others_is_named_by_its_line(self):
        rows = contacts_on_box(8)
        rows[3][0] += 12.5
        self.refuse(csv(rows), "contacts.csv:5: the contact is 12.4 m from the others")
        rows[6][1] -= 20
        self.refuse(csv(rows), "contacts.csv:5: ", ", and 1 more are as far")

    def test_a_mesh_in_millimetres(self):
        self.write("mm.stl", box_stl(*(1000 * size for size in SIZE)))
        self.write("contacts.csv", csv(contacts_on_box(18)))
        self.assert_refused(BAD_INPUT, ["localize", "mm.stl", "contacts.csv"], "--units mm")
        self.assert_refused(BAD_INPUT, ["localize", "box", "contacts.csv", "--units", "mm"],
                            "--units mm is of mesh files, and box is none")  # fmt: skip
        self.assert_refused(USAGE, ["localize", "mm.stl", "contacts.csv", "--units", "cm"], "'cm'")
        report = self.run_json("localize", "mm.stl", "contacts.csv", "--units", "mm", *QUICK)
        plain = self.localize(contacts_on_box(18))
        self.assertEqual(report["status"], "certain")
        for value, true in zip(middle(report["modes"][0]["T_contact_object"]),
                               middle(plain["modes"][0]["T_contact_object"])):  # fmt: skip
            self.assertAlmostEqual(value, true, delta=0.001)

    def test_the_size_of_the_object_is_estimated(self):
        larger = [[1.08 * v for v in row[:3]] + row[3:] for row in contacts_on_box(30)]
        self.write("contacts.csv", csv(larger))
        command = ["localize", "box.stl", "contacts.csv", "--size-range", "0.1"]
        answer = self.run_json(*command)
        self.assertEqual([each["name"] for each in answer["objects"]],
                         ["box.stl", "box.stl@0.95", "box.stl@1.05", "box.stl@0.9", "box.stl@1.1"])
        self.assertAlmostEqual(answer["size"], 1.08, delta=0.03)
        self.assertIn("times the size of its mesh", self.run_program(*command).stdout)
        self.write("before.json", json.dumps(answer))
        after = self.run_json("localize", answer["object"], "contacts.csv", "--prior", "before.json")
        self.assertNotEqual(after["status"], "no_pose")
        known = self.run_json("localize", "box.stl@1.08", "contacts.csv")
        self.assertEqual((known["status"], known["size"]), ("certain", 1.08))
        for a, b in zip(middle(answer["modes"][0]["T_contact_object"]),
                        middle(known["modes"][0]["T_contact_object"])):  # fmt: skip
            self.assertAlmostEqual(a, b, delta=0.01)

    def test_sizes_that_cannot_be(self):
        self.write("contacts.csv", csv(contacts_on_box(18)))
        for code, arguments, words in [
            (USAGE, ["box.stl", "--size-range", "0.3"], ["--size-range", "0.3"]),
            (USAGE, ["box.stl", "--size-range", "0.1", "--method", "full"], ["--method", "one size"]),
            (BAD_INPUT, ["box.stl@x"], ["box.stl@x"]),
            (BAD_INPUT, ["box.stl@20"], ["box.stl@20", "0.1..10"]),
            (BAD_INPUT, ["box.stl,box.stl@1"], ["given twice"]),
            (BAD_INPUT, ["box.stl@5"], ["10 to 400 mm"]),
        ]:
            self.assert_refused(code, ["localize", arguments[0], "contacts.csv", *arguments[1:]], *words)

    def test_the_prior_of_another_object_is_refused(self):
        report = self.localize(contacts_on_box(18))
        self.write("box.json", json.dumps(report))
        self.write("other.json", json.dumps(report | {"object": "bracket"}))
        command = ["localize", "./box.stl", "contacts.csv", *QUICK, "--quiet", "--prior"]
        self.assertEqual(self.run_program(*command, "box.json").returncode, DONE)
        self.assert_refused(BAD_INPUT, [*command, "other.json"], "other.json: ", "'bracket'", "'./box.stl'")

    def test_the_next_command_keeps_the_poses(self):
        self.write("contacts.csv", csv(contacts_on_box(18)))
        command = ["localize", "box.stl", "contacts.csv", *QUICK, "--table", str(SHIFT[2])]
        lines = self.run_program(*command).stdout.splitlines()
        self.assertTrue(lines[-1].startswith("Next: palpate localize box.stl contacts.csv --table 0.5 "), lines[-1])
        self.assertIn(" ".join(QUICK), lines[-1])
        self.assertIn(" --out out/localize-box writes", lines[-1])
        for option in ("--quiet", "--json"):
            self.assertNotIn("Next:", self.run_program(*command, option).stdout)

    def test_the_next_command_takes_names_with_blanks(self):
        self.write("contacts.csv", csv(contacts_on_box(18)))
        self.write("a box.stl", (self.folder / "box.stl").read_bytes())
        for more, words in (([], " --out 'out/localize-a box' "),
                            (["--out", "an out"], "localize 'a box.stl' MORE_CONTACTS --prior 'an out/report.json'")):
            lines = self.run_program("localize", "a box.stl", "contacts.csv", *QUICK, *more).stdout.splitlines()
            self.assertIn(words, lines[-1])

    def test_points_without_normals(self):
        rows = [row[:3] for row in contacts_on_box(40)]
        result = self.localize(rows, header="x,y,z")
        self.assertEqual(result["status"], "certain")
        T = result["modes"][0]["T_contact_object"]
        half = [size / 2 for size in SIZE]
        middle = [sum(T[4 * i + j] * half[j] for j in range(3)) + T[4 * i + 3] for i in range(3)]
        for value, true in zip(middle, moved(half, SHIFT)):
            self.assertAlmostEqual(value, true, delta=0.003)

    def test_rows_state_their_own_errors(self):
        """Ten rows that are 20 mm off, and say so, change nothing."""
        good = [row + [0.0005] for row in contacts_on_box(18)]
        bad = [[v + 0.02 for v in row[:3]] + row[3:6] + [0.03] for row in contacts_on_box(10, seed=5)]
        header = HEADER + ",point_sigma"
        result = self.localize(good + bad, header=header)
        self.assertEqual(result["status"], "certain")
        self.refuse(csv([good[0][:6] + [-0.5]], header), "contacts.csv:2", "point_sigma", "-0.5")

    def test_table_free_space_and_prior(self):
        """Contacts on two sides alone leave heights open, which the table settles."""
        rows = contacts_on_box(8, faces=(0, 1, 2, 3))
        alone = self.localize(rows, "--method", "full")
        table = self.localize(rows, "--method", "full", "--table", str(SHIFT[2]))
        self.assertGreater(table["probability"], alone["probability"] + 0.1)
        self.write("free.csv", "x,y,z,radius\n5,5,5,0.01\n")
        self.write("before.json", json.dumps(self.localize(contacts_on_box(18))))
        informed = self.localize(rows, "--free", "free.csv", "--prior", "before.json")
        self.assertGreater(informed["probability"], alone["probability"] + 0.1)

    def test_a_prior_without_contacts_stands_on_its_table(self):
        before = self.localize(contacts_on_box(18))
        self.write("before.json", json.dumps(before))
        again = self.localize([], "--prior", "before.json", "--table", str(SHIFT[2]))
        for value, true in zip(middle(again["modes"][0]["T_contact_object"]),
                               middle(before["modes"][0]["T_contact_object"])):  # fmt: skip
            self.assertAlmostEqual(value, true, delta=0.003)

    def test_a_plane_settles_the_height(self):
        """Contacts on two sides alone leave heights open, which the plane below settles."""
        rows = contacts_on_box(8, faces=(0, 1, 2, 3))
        alone = self.localize(rows, "--method", "full")
        self.write("planes.csv", csv([[0, 0, 1, SHIFT[2]]], "nx,ny,nz,height"))
        self.write("none.csv", HEADER + "\n")
        self.assert_refused(BAD_INPUT, ["localize", "box.stl", "none.csv", "--planes", "planes.csv"],
                            "none.csv has no contacts")  # fmt: skip
        informed = self.localize(rows, "--method", "full", "--planes", "planes.csv")
        self.assertGreater(informed["probability"], alone["probability"] + 0.1)

    def test_free_voxels_rule_out_what_would_stand_in_them(self):
        """Where the air was free in the middle of the box, the box is not believed to be."""
        rows = contacts_on_box(12)
        center = moved(HALF, SHIFT)
        plain = self.localize(rows)
        self.assertGreater(plain["probability"], 0.9)
        steps = [0.01 * (i - 1) for i in range(3)]
        voxels = "".join(f"{center[0] + a},{center[1] + b},{center[2] + c},0.01\n"
                         for a in steps for b in steps for c in steps)  # fmt: skip
        self.write("voxels.csv", "x,y,z,size\n" + voxels)
        done = self.run_program("localize", "box.stl", "contacts.csv", "--json", *QUICK, "--free",
                                "voxels.csv")  # fmt: skip
        self.assertIn(done.returncode, (DONE, NO_SOLUTION), done.stderr)
        for mode in json.loads(done.stdout)["modes"]:
            at = middle(mode["T_contact_object"])
            far = sum((a - b) ** 2 for a, b in zip(at, center)) ** 0.5 > 0.01
            self.assertTrue(far or mode["weight"] < 0.1, mode)

    def test_ignoring_spin_counts_the_whole_family(self):
        rows = contacts_on_box(6, faces=(5,))
        plain = self.localize(rows, "--method", "full")
        ignored = self.localize(rows, "--method", "full", "--ignore-spin")
        self.assertGreaterEqual(ignored["probability"], plain["probability"])
        self.assertAlmostEqual(ignored["probability"], ignored["modes"][0]["weight"])

    def test_bad_evidence(self):
        self.write("contacts.csv", csv(contacts_on_box(3)))
        self.write("free.csv", "x,y,z,radius\n0,0,0,-1\n")
        self.write("voxels.csv", "x,y,z,size\n0,0,0,0.01\n0.015,0,0,0.01\n")
        self.write("planes.csv", "nx,ny,nz,height\n0,0,0,1\n")
        self.write("prior.json", "{}")
        for option, name, word in (("--free", "free.csv", "radius"), ("--free", "voxels.csv", "grid"),
                                   ("--planes", "planes.csv", "length 0"), ("--prior", "prior.json", "report")):
            self.assert_refused(
                BAD_INPUT, ["localize", "box.stl", "contacts.csv", option, name], name, word
            )

    def test_contacts_in_millimetres(self):
        rows = [[1000 * v for v in row[:3]] + row[3:] for row in contacts_on_box(8)]
        self.refuse(csv(rows), "millimetres")

    def test_the_contacts_that_ship_give_the_pose_that_ships(self):
        examples = pathlib.Path(__file__).resolve().parents[2] / "examples"
        T = self.run_json("localize", "bracket", str(examples / "bracket.csv"))
        self.assertEqual(T["status"], "certain")
        found = T["modes"][0]["T_contact_object"]
        true = [float(value) for value in (examples / "bracket_pose.txt").read_text().split()]
        shift = math.dist([found[i] for i in (3, 7, 11)], [true[i] for i in (3, 7, 11)])
        trace = sum(found[4 * i + j] * true[4 * i + j] for i in range(3) for j in range(3))
        turn = math.degrees(math.acos(max(-1, min(1, (trace - 1) / 2))))
        self.assertLess(turn, 5)
        self.assertLess(shift, 0.010 + 0.1 * math.radians(5))  # of the origin, 0.1 m off the centroid

    def test_open_mesh(self):
        """Without one face of two triangles: the hole is closed, and the result says so."""
        whole = box_stl(*SIZE)
        count = 11
        data = whole[:80] + count.to_bytes(4, "little") + whole[84 : 84 + 50 * count]
        self.write("box.stl", data)
        result = self.localize(contacts_on_box(18))
        self.assertEqual(result["status"], "certain")
        self.assertTrue(result["repairs"])

    def test_many_objects_are_more_than_a_files_name_can_hold(self):
        many = ",".join(f"generated:{number}" for number in range(30))
        self.assert_refused(BAD_INPUT, ["localize", many, "none.csv"], "none.csv does not exist")

    def test_the_search_of_several_objects_is_not_chosen(self):
        self.write("some.csv", "x,y,z\n0,0,0\n")
        several = ["localize", "mug,box", "some.csv", "--method", "fast"]
        self.assert_refused(USAGE, several, "--method")

    def test_usage(self):
        self.write("contacts.csv", csv(contacts_on_box(3)))
        self.assert_refused(USAGE, ["--json", "localize", "box.stl", "contacts.csv"], "goes after palpate localize")
        for wrong in (["--method", "slow"], ["--point-noise", "0"], ["--point-noise", "0.1"], ["--normal-noise-deg", "-1"]):
            self.assert_refused(USAGE, ["localize", "box.stl", "contacts.csv", *wrong], wrong[1])
        for option in (["--set", "x.y=1"], ["--config", "x"], ["--method", "full"], ["--table", "0"]):
            self.assert_refused(USAGE, ["localize", "--demo", *option], option[0])
        self.assert_refused(BAD_INPUT, ["localize", "mug,mug", "contacts.csv"], "mug is given twice")
        self.assert_refused(USAGE, ["localize"], "MESH and CONTACTS, or --demo, are required")
        self.assert_refused(USAGE, ["localize", "bracket"], "palpate: CONTACTS is required;")
        self.assert_refused(BAD_INPUT, ["localize", "box.stl", "contacts.csv", "--set", "point_noise=0.002"],
                            "--point-noise sets it")  # fmt: skip
        self.assert_refused(USAGE, ["localize", "box.stl", "x.csv", "--threads", "2"], "--demo")


if __name__ == "__main__":
    main()
