#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Every rule of check_layers.py must find its breach, and a clean tree must pass."""
import sys
import tempfile
import unittest
from pathlib import Path

sys.dont_write_bytecode = True
import check_layers  # noqa: E402

LICENCE = check_layers.LICENCE + "\n"
LAYERS = "0 base:\n1 image: base\n4 dataset, synthetic: image base\n4 feature: image base\n5 feature/fast: feature base\n6 feature/*: feature base\n7 list: feature/* feature\n8 cli: dataset feature image base\n"


def check(files):
    """The report on a tree of these files (path -> text)."""
    with tempfile.TemporaryDirectory() as folder:
        root = Path(folder)
        (root / "layers.txt").write_text(LAYERS)
        for name, text in files.items():
            path = root / name
            path.parent.mkdir(parents=True, exist_ok=True)
            path.write_text(text)
        return check_layers.check_tree(root)[0]


class Breaches(unittest.TestCase):
    def assert_breach(self, name, text, words):
        report = check({name: text})
        self.assertEqual(len(report.breaches), 1, report.breaches)
        self.assertIn(words, report.breaches[0])

    def assert_clean(self, name, text):
        self.assertEqual(check({name: text}).breaches, [])

    def test_upward_include(self):
        self.assert_breach("src/rastro/base/a.cpp", LICENCE + '#include "rastro/image/image.h"\n', "may not include image")

    def test_sideward_include(self):
        self.assert_breach("src/rastro/feature/a.cpp", LICENCE + '#include "rastro/dataset/open.h"\n', "may not include dataset")

    def test_downward_include(self):
        self.assert_clean("src/rastro/feature/a.cpp", LICENCE + '#include "rastro/base/error.h"\n')

    def test_a_folder_below_with_a_line_of_its_own(self):
        self.assert_clean("src/rastro/feature/fast/a.cpp", LICENCE + '#include "rastro/feature/b.h"\n')
        self.assert_breach("src/rastro/feature/fast/a.cpp", LICENCE + '#include "rastro/image/b.h"\n', "feature/fast may not include image")
        self.assert_breach("src/rastro/feature/a.cpp", LICENCE + '#include "rastro/feature/fast/b.h"\n', "may not include feature/fast")

    def test_a_line_for_all_folders_below(self):
        lists = {f"src/rastro/feature/{name}/CMakeLists.txt": "" for name in ("orb", "sift")}
        text = LICENCE + '#include "rastro/feature/%s"\n'
        self.assertEqual(check({**lists, "src/rastro/feature/orb/a.cpp": text % "b.h"}).breaches, [])
        self.assertEqual(check({**lists, "src/rastro/feature/orb/part/a.cpp": text % "orb/b.h"}).breaches, [])
        self.assertEqual(check({**lists, "src/rastro/list/a.cpp": text % "orb/b.h"}).breaches, [])
        self.assertEqual(check({"src/rastro/feature/shared/a.cpp": text % "b.h"}).breaches, [])
        self.assertEqual(check({"src/rastro/feature/a.cpp": text % "shared/b.h"}).breaches, [])
        for path, wanted, words in (("feature/orb/a.cpp", "sift/b.h", "feature/orb may not include feature/sift"),
                                    ("feature/orb/a_test.cpp", "sift/b.h", "feature/orb may not include feature/sift"),
                                    ("feature/a.cpp", "orb/b.h", "feature may not include feature/orb"),
                                    ("feature/fast/a.cpp", "orb/b.h", "feature/fast may not include feature/orb")):
            report = check({**lists, f"src/rastro/{path}": text % wanted})
            self.assertEqual(len(report.breaches), 1, report.breaches)
            self.assertIn(words, report.breaches[0])

    def test_tests_may_use_synthetic(self):
        text = LICENCE + '#include "rastro/synthetic/hall.h"\n#include <gtest/gtest.h>\n#include <opencv2/core.hpp>\n'
        self.assert_clean("src/rastro/feature/a_test.cpp", text)
        self.assert_breach("src/rastro/feature/a.cpp", text.replace("#include <", "// <"), "may not include synthetic")

    def test_third_party_away_from_home(self):
        self.assert_breach("src/rastro/base/a.cpp", LICENCE + "#include <opencv2/core.hpp>\n", "belongs to calibration")
        self.assert_breach("src/rastro/dataset/a.cpp", LICENCE + "#include <CLI/CLI.hpp>\n", "belongs to cli")
        self.assert_clean("src/rastro/dataset/a.cpp", LICENCE + "#include <opencv2/core.hpp>\n")

    def test_third_party_in_public_header(self):
        text = LICENCE + "#pragma once\n#include <opencv2/core.hpp>\n"
        self.assert_breach("src/rastro/dataset/a.h", text, "public header")

    def test_internal_headers(self):
        internal = LICENCE + check_layers.INTERNAL + "\n#pragma once\n#include <opencv2/core.hpp>\n"
        user = LICENCE + '#pragma once\n#include "rastro/dataset/a.h"\n'
        self.assert_clean("src/rastro/dataset/a.h", internal)
        report = check({"src/rastro/dataset/a.h": internal, "src/rastro/dataset/b.h": user})
        self.assertIn("a public header may not include the internal", report.breaches[0])
        report = check({"src/rastro/dataset/a.h": internal, "src/rastro/cli/b.cpp": user})
        self.assertIn("internal to its own folder", report.breaches[0])
        self.assertEqual(check({"src/rastro/dataset/a.h": internal, "src/rastro/dataset/b.cpp": user}).breaches, [])

    def test_short_include_path(self):
        self.assert_breach("src/rastro/base/a.cpp", LICENCE + '#include "error.h"\n', "whole path")

    def test_licence_and_guard(self):
        self.assert_breach("src/rastro/base/a.cpp", "int a;\n", "first line")
        self.assert_breach("src/rastro/base/a.h", LICENCE + "int a;\n", "#pragma once")

    def test_folder_without_layer(self):
        self.assert_breach("src/rastro/novel/a.cpp", LICENCE, "no line in layers.txt")

    def test_library_prints_or_exits(self):
        self.assert_breach("src/rastro/base/a.cpp", LICENCE + 'void f() { std::printf(""); std::exit(1); }\n', "never prints")
        self.assert_breach("src/rastro/base/a.cpp", LICENCE + "void f() { abort(); }\n", "never prints")
        self.assert_clean("src/rastro/base/a.cpp", LICENCE + '// abort();\nvoid f() { g("std::cout"); }\n')
        self.assert_clean("src/rastro/cli/a.cpp", LICENCE + "void f() { std::exit(1); }\n")

    def test_files_that_include_one_another(self):
        def file(*names):
            return LICENCE + "#pragma once\n" + "".join(f'#include "rastro/{name}"\n' for name in names)

        loop = {"src/rastro/base/a.h": file("base/b.h", "base/d.h"), "src/rastro/base/b.h": file("base/c.h"),
                "src/rastro/base/c.h": file("base/a.h", "base/d.h"), "src/rastro/base/d.h": file()}
        report = check(loop)
        self.assertEqual(len(report.breaches), 1, report.breaches)
        self.assertIn("rastro/base/a.h -> rastro/base/b.h -> rastro/base/c.h -> rastro/base/a.h", report.breaches[0])
        loop["src/rastro/base/c.h"] = file("base/d.h")
        self.assertEqual(check(loop).breaches, [])

    def test_two_loops_and_a_file_that_includes_itself(self):
        self.assertEqual(check_layers.include_loops({"a": {"b"}, "b": {"a", "c"}, "c": {"c"}}), [("a", "b"), ("c",)])

    def test_what_counts_as_a_function(self):
        code = check_layers.without_comments_and_strings("""namespace a {
const std::vector<Row> rows{
    Row("x", 1), {Row("y", 2)}};
template <class T>
T twice(T value) {
  return [&] { return 2 * value; }();
}
struct B : C {
  B(int b)
      : b_{b},
        c_(b) {
    c();
  }
  bool empty() const { return b_ == 0; }
  int b_{1};
};
enum class D { e };
}
""")
        self.assertEqual(check_layers.function_lengths(code), [(4, 4), (9, 5), (14, 1)])

    def test_sizes(self):
        self.assert_breach("src/rastro/base/a.cpp", LICENCE + "int a;\n" * 801, "split it")
        self.assert_breach("src/rastro/base/a.cpp", LICENCE + "void f() {\n" + "g();\n" * 120 + "}\n", ":2: a function of 122 lines")
        self.assert_clean("src/rastro/base/a.cpp", LICENCE + ("void f() {\n" + "g();\n" * 50 + "}\n") * 3)
        warnings = check({"src/rastro/base/a.cpp": LICENCE + "namespace a {\nint f(int b) const {\n" + "g();\n" * 61 + "}\n}\n"}).warnings
        self.assertEqual(warnings, ["src/rastro/base/a.cpp:3: a function of 63 lines; aim at 30"])


if __name__ == "__main__":
    unittest.main()
