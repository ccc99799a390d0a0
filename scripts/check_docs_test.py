#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""check_docs.py on pages with one thing wrong each, against a made-up program."""
import sys
import tempfile
import unittest
from pathlib import Path
from types import SimpleNamespace

sys.dont_write_bytecode = True
import check_docs  # noqa: E402

PROGRAM = SimpleNamespace(
    help={"": "", "slam": "--method NAME\n--out DIR\n--set KEY=VALUE", "export": "--to FORMAT  ply, pcd", "evaluate": "", "evaluate map": "--align KIND"},
    methods={"orb"}, options={"features"}, flags={"--method"})


def complaints(check, *arguments):
    said = []
    check(*arguments, said.append)
    return said


class Commands(unittest.TestCase):
    def test_found_in_blocks_without_comments(self):
        page = "```\n$ rastro slam a --out b   # a comment\nrastro info b && rastro check b\nnot a command\n```\n```cpp\nrastro slam;\n```\n"
        self.assertEqual(list(check_docs.commands(page)), ["rastro slam a --out b", "rastro info b", "rastro check b"])

    def test_right_ones(self):
        for command in ["rastro --help", "rastro slam a --method orb --set features=9", "rastro export a --to ply", "rastro evaluate map a --align none"]:
            self.assertEqual(complaints(check_docs.check_command, command, PROGRAM), [], command)

    def test_wrong_ones(self):
        for command in ["rastro walk a", "rastro slam a --outt b", "rastro slam a --method orbs", "rastro slam a --set feature=9",
                        "rastro export a --to obj", "rastro evaluate map a --method orb", "rastro slam 'a"]:
            self.assertEqual(len(complaints(check_docs.check_command, command, PROGRAM)), 1, command)


class Links(unittest.TestCase):
    def test_files_and_headings(self):
        with tempfile.TemporaryDirectory() as folder:
            page, other = Path(folder) / "page.md", Path(folder) / "other.md"
            other.write_text("# One thing, and more\n")
            page.write_text("")
            for text, wrong in [("[a](other.md)", 0), ("[a](other.md#one-thing-and-more)", 0), ("[a](https://x.org/y)", 0),
                                ("![a](none.png)", 1), ("[a](other.md#two)", 1), ("```\n[a](none.md)\n```", 0)]:
                self.assertEqual(len(complaints(check_docs.check_links, page, text)), wrong, text)


class CodeLocations(unittest.TestCase):
    def test_files_and_names(self):
        for text, wrong in [("`track/klt.h` (`klt_follow`)", 0), ("`track/klt.h`", 0), ("`track/klt.h` (`klt_follow`, `no_such`)", 1),
                            ("`track/no_such.h` (`klt_follow`)", 1)]:
            self.assertEqual(len(complaints(check_docs.check_code_locations, text)), wrong, text)


if __name__ == "__main__":
    unittest.main()
