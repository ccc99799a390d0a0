#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""The figures of code_size.py on small trees whose sizes are known."""
import sys
import tempfile
import unittest
from pathlib import Path

sys.dont_write_bytecode = True
import code_size  # noqa: E402


def measure(files):
    with tempfile.TemporaryDirectory() as folder:
        for name, text in files.items():
            path = Path(folder) / name
            path.parent.mkdir(parents=True, exist_ok=True)
            path.write_text(text)
        return code_size.measure(Path(folder))


class Figures(unittest.TestCase):
    def test_data_members(self):
        for members, statement in [
                (1, "int a"), (1, "int a{1}"), (1, "double a = f(1, 2)"), (3, "int a = 0, b = 1, c"), (2, "std::map<int, int> a, b"),
                (1, "std::function<void(int, int)> call"), (1, "private:\n std::array<std::pair<int, int>, 3> a_{}"),
                (1, "std::vector<std::string> words = {{}, {}}"), (1, "const Options& options_"), (1, "mutable std::mutex mutex_"),
                (0, "int f() const"), (0, "virtual ~A() = default"), (0, "~A()"), (0, "A(const A&) = delete"), (0, "using T = int"),
                (0, "static constexpr int a = 1"), (0, "friend class B"), (0, "bool operator==(const A&) const = default"),
                (0, "[[nodiscard]] int f(int a = 1, int b = 2)"), (0, "class B"), (0, "std::map<int, int> f(int a)")]:
            self.assertEqual(code_size.data_members(statement), members, statement)

    def test_classes_without_options(self):
        text = "struct A {\n  int a = 0;\n  int f() const { return a; }\n  double b{1}, c;\n};\nstruct AOptions {\n  int a;\n};\n"
        self.assertEqual(measure({"src/rastro/base/a.h": text}).classes, [(3, "A", "src/rastro/base/a.h:1")])

    def test_long_functions(self):
        def function(lines):
            return "void f() {\n" + "g();\n" * (lines - 2) + "}\n"

        sizes = measure({"src/rastro/base/a.cpp": function(50) + function(51), "src/rastro/base/a_test.cpp": function(52)})
        self.assertEqual(sizes.long_functions, [(False, 51, "src/rastro/base/a.cpp:51"), (True, 52, "src/rastro/base/a_test.cpp:1")])
        self.assertAlmostEqual(sizes.long_share(), 2 / 3)
        self.assertIn("66.67% of the functions", code_size.breaches(sizes)[0])

    def test_lines_by_folder(self):
        sizes = measure({"src/rastro/base/a.cpp": "int a;\n" * 4, "src/rastro/base/a_test.cpp": "int a;\n", "src/rastro/slam/orb/a.h": "\n" * 4,
                         "src/rastro/slam/slam.h": "\n", "tests/cli/a.cpp": "\n" * 2})
        self.assertEqual(dict(sizes.lines), {"base": [4, 1], "slam/orb": [4, 0], "slam": [1, 0], "tests": [0, 2]})
        self.assertAlmostEqual(sizes.test_share(), 3 / 9)
        self.assertEqual(len(code_size.breaches(sizes)), 1)


if __name__ == "__main__":
    unittest.main()
