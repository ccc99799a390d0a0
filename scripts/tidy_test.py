#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Which sources scripts/tidy looks at, in which order, and what it leaves out; clang-tidy itself is not run."""
import importlib.machinery
import importlib.util
import os
import subprocess
import sys
import tempfile
import unittest
from pathlib import Path

sys.dont_write_bytecode = True
LOADER = importlib.machinery.SourceFileLoader("tidy", str(Path(__file__).resolve().parent / "tidy"))
tidy = importlib.util.module_from_spec(importlib.util.spec_from_loader("tidy", LOADER))
LOADER.exec_module(tidy)
DAY_S = 24 * 3600


class ChangedSources(unittest.TestCase):
    def setUp(self):
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        tidy.ROOT = Path(folder.name)
        self.git("init", "-q", "-b", "main")
        self.commit("src/old.cpp", 0)
        self.commit("src/a.cpp", 3 * DAY_S)
        self.commit("src/b.h", 3 * DAY_S + 10)
        self.commit("src/b.cpp", 3 * DAY_S + 20)
        self.commit("docs/c.md", 3 * DAY_S + 30)

    def git(self, *arguments, **environment):
        names = {f"GIT_{who}_{what}": "nobody" for who in ("AUTHOR", "COMMITTER") for what in ("NAME", "EMAIL")}
        subprocess.run(["git", *arguments], cwd=tidy.ROOT, check=True, env={**os.environ, **names, **environment})

    def write(self, name):
        path = tidy.ROOT / name
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_text("int a;\n")

    def commit(self, name, seconds):
        self.write(name)
        self.git("add", "-A")
        when = f"@{1_000_000_000 + seconds} +0000"
        self.git("commit", "-q", "-m", name, GIT_AUTHOR_DATE=when, GIT_COMMITTER_DATE=when)

    def sources(self, since=""):
        return tidy.sources_of(tidy.changed_paths(since or tidy.start_of_day()))

    def test_newest_first_and_each_once(self):
        self.assertEqual(self.sources(), ["src/b.cpp", "src/a.cpp"])

    def test_what_is_not_committed_comes_first(self):
        self.write("tests/new.cpp")
        (tidy.ROOT / "src/a.cpp").write_text("int b;\n")
        self.assertEqual(self.sources(), ["src/a.cpp", "tests/new.cpp", "src/b.cpp"])

    def test_since_a_commit(self):
        self.assertEqual(self.sources("HEAD~2"), ["src/b.cpp"])
        self.assertEqual(self.sources("HEAD~4"), ["src/b.cpp", "src/a.cpp"])

    def test_what_is_gone_or_apart_is_left_out(self):
        self.commit("tests/consumer/main.cpp", 3 * DAY_S + 40)
        (tidy.ROOT / "src/a.cpp").unlink()
        self.assertEqual(self.sources(), ["src/b.cpp"])

    def test_a_spent_budget_leaves_all_out_aloud(self):
        tidy.check = lambda path, lines: self.fail(path)
        self.assertEqual(tidy.check_all(["src/a.cpp"], {}, -1, 1), ({}, ["src/a.cpp"]))

    def test_findings(self):
        tidy.check = lambda path, lines: "bad" if "a" in path else ""
        self.assertEqual(tidy.check_all(["src/a.cpp", "src/b.cpp"], {}, 60, 2), ({"src/a.cpp": "bad"}, []))

    def test_only_the_lines_that_changed(self):
        (tidy.ROOT / "src/a.cpp").write_text("int a;\nint b;\nint c;\n")
        self.write("tests/new.cpp")
        (tidy.ROOT / "docs/c.md").write_text("other\n")
        self.assertEqual(tidy.changed_lines("HEAD"), {"src/a.cpp": [[2, 3]], "tests/new.cpp": [[1, tidy.WHOLE]]})

    def test_a_young_history_counts_from_the_empty_tree(self):
        self.git("checkout", "-q", "--orphan", "young")
        self.commit("src/b.cpp", 9 * DAY_S)
        self.assertEqual(tidy.start_of_day(), tidy.EMPTY_TREE)
        self.assertEqual(tidy.changed_lines(tidy.EMPTY_TREE)["src/b.cpp"], [[1, 1]])


if __name__ == "__main__":
    unittest.main()
