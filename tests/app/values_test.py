# SPDX-License-Identifier: Apache-2.0
"""Values that are empty or no numbers, and options that are almost right."""

from cli import USAGE, CliTest, main


class Values(CliTest):
    def test_an_empty_value_is_refused(self):
        """As that of a variable of the shell that is not set: it would be ignored in silence."""
        for command, name in (
            (["localize", "box", "c.csv", "--prior", ""], "--prior"),
            (["localize", "box", "c.csv", "--out", ""], "--out"),
            (["localize", "box", "c.csv", "--config", ""], "--config"),
            (["localize", "", "c.csv"], "MESH"),
            (["register", "--correspondences", "p.csv", "--initial", ""], "--initial"),
            (["eval", "--shard", "", "--out", "e"], "--shard"),
            (["pick", "--hand", ""], "--hand"),
            (["pick", "--true-object", ""], "--true-object"),
            (["pick", "--set", ""], "--set"),
            (["plan", "w.csv", "--object", ""], "--object"),
            (["rollout", ""], "POLICY"),
            (["render", ""], "RECORDING"),
            (["replay", ""], "RECORDING"),
            (["view", "run.h5", "--out", ""], "--out"),
            (["hand", "check", ""], "HAND"),
            (["hand", "check", "shadow", "--render", ""], "--render"),
            (["merge", "part1", ""], "PART"),
            (["options", ""], "COMMAND"),
        ):
            self.assert_refused(USAGE, command, f"palpate: {name}: the value is empty; see palpate")

    def test_what_is_no_number_is_said(self):
        for option in ("--distance", "--azimuth", "--elevation"):
            self.assert_refused(USAGE, ["render", "x.h5", option, "1,5"], f"{option}: '1,5' is not a number")
        self.assert_refused(USAGE, ["pick", "--json=maybe"], "--json: 'maybe' is not true or false")


class AlmostRight(CliTest):
    def test_a_misspelt_option_is_named_not_what_it_leaves_missing(self):
        self.assert_refused(USAGE, ["certify", "pose.txt", "--correspondence", "p.csv"],
                            "no option --correspondence;", "'--correspondences'?")  # fmt: skip
        self.assert_refused(USAGE, ["export", "--froce"], "no option --froce", "'--force'?")
        self.assert_refused(USAGE, ["certify", "pose.txt"], "--correspondences is required")

    def test_an_object_is_suggested_where_no_argument_is_taken(self):
        self.assert_refused(USAGE, ["eval", "mug"], "did you mean --object mug?")
        self.assert_refused(USAGE, ["replay", "run.h5", "more"], "takes no argument 'more'; see palpate")


if __name__ == "__main__":
    main()
