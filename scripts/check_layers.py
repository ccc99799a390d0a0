#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Checks every C++ source against layers.txt and the house rules that a program can check.

  scripts/check_layers.py [ROOT]

Breaches (exit code 1): an include that layers.txt does not allow, a third party outside of its home, a third party in a
public header, a library source that prints or ends the program, a missing licence line, a file over 800 lines, a
function over 120. Warnings: a file over 500 lines, a function over 60.
"""
import re
import sys
from dataclasses import dataclass, field
from pathlib import Path

FILE_WARNING, FILE_LIMIT = 500, 800
FUNCTION_WARNING, FUNCTION_LIMIT = 60, 120
INTERNAL = "// Internal: not installed."  # the second line of a header that other folders and programs never see
LICENCE = "// SPDX-License-Identifier: Apache-2.0"
# Header prefix -> folders of src/rastro whose sources may include it; tests, bench and examples may include anything.
HOMES = {
    "opencv2/core/utils/logger.hpp": {"cli"},  # the program silences OpenCV
    "opencv2/": {"dataset", "export", "feature", "map", "synthetic"},
    "dlib/": {"feature"},
    "yaml-cpp/": {"base", "camera", "dataset", "evaluate", "export"},
    "nlohmann/": {"dataset", "evaluate", "export", "session", "cli"},
    "CLI/": {"cli"},
    "spdlog/": {"cli"},
    "oneapi/": {"base"},
    "tbb/": {"base"},
    "openssl/": {"base"},
    "ceres/": {"optimize"},
    "rosbag/": {"dataset"},
    "ros/": {"dataset"},
    "sensor_msgs/": {"dataset"},
    "nav_msgs/": {"dataset"},
    "zlib.h": {"dataset"},
    "gtest/": set(),
    "gmock/": set(),
    "benchmark/": set(),
}
INCLUDE = re.compile(r'^\s*#\s*include\s*([<"])([^>"]+)[>"]')
PRINTS_OR_ENDS = re.compile(r"std::(cout|cerr|clog|exit|abort|quick_exit|terminate)\b|(?<![\w.:>])(printf|puts|abort|exit|fprintf)\s*\(")
SCOPE = re.compile(r'\b(namespace|class|struct|union|enum)\b|\bextern\s*""')


@dataclass
class Report:
    breaches: list = field(default_factory=list)
    warnings: list = field(default_factory=list)


class Layers:
    """layers.txt, and which folders of src/rastro are modules: slam/* is every folder below slam/ with a CMakeLists.txt."""

    def __init__(self, root):
        self.lines = {}
        self.folders = {str(path.parent.relative_to(root / "src/rastro")) for path in (root / "src/rastro").rglob("CMakeLists.txt")}
        for line in (root / "layers.txt").read_text().splitlines():
            match = re.match(r"^\d+ ([a-z_/*, ]+):(.*)$", line)
            if match:
                for folder in re.split(r"[, ]+", match.group(1)):
                    self.lines[folder] = match.group(2).split()

    def line_of(self, folder):
        """The line that a folder goes by: its own, or that of all folders beside it; None without one."""
        beside = folder.rsplit("/", 1)[0] + "/*"
        return folder if folder in self.lines else beside if folder in self.folders and beside in self.lines else None

    def named_by(self, entry):
        """The folders that an entry of a line stands for: slam/* for all below slam/."""
        if not entry.endswith("/*"):
            return {entry}
        return {folder for folder in self.folders if folder.startswith(entry[:-1])}

    def uses(self, folder):
        """The folders that one may include."""
        return {used for entry in self.lines.get(self.line_of(folder), []) for used in self.named_by(entry)}

    def folder_of(self, parts):
        """The folder that a path below src/rastro belongs to: a module below another (slam/hector), else the first."""
        below = ("/".join(parts[:n]) for n in range(len(parts) - 1, 1, -1))
        return next((folder for folder in below if self.line_of(folder)), parts[0])


def is_test(path):
    return re.search(r"_(test|testing)\.(h|cpp)$", path.name) is not None


def is_internal(path):
    return path.is_file() and path.suffix == ".h" and path.read_text(errors="replace").splitlines()[1:2] == [INTERNAL]


def without_comments_and_strings(text):
    """The same text with comments and literals blanked out; line breaks stay."""
    pattern = re.compile(
        r'R"([^()\\\s]{0,16})\(.*?\)\1"|//[^\n]*|/\*.*?\*/|"(?:\\.|[^"\\\n])*"|(?<![0-9A-Fa-f])\'(?:\\.|[^\'\\\n])+\'', re.DOTALL)

    def blank(match):
        found = match.group(0)
        mark = '""' if found[0] in "\"R" else ""
        return mark + "\n" * found.count("\n")

    return pattern.sub(blank, text)


def function_lengths(code):
    """(first line, lines) of each function body in code without comments: a brace that follows ')' or its trailers."""
    lengths = []
    stack = []  # (opened a function, first line)
    head, head_line, line = "", 1, 1
    for letter in code:
        if letter == "{":
            inside = any(function for function, _ in stack)
            function = not inside and "(" in head and not SCOPE.search(head.split("(")[0]) and not head.rstrip().endswith("=")
            stack.append((function, head_line if head.strip() else line))
            head = ""
        elif letter == "}" and stack:
            function, first = stack.pop()
            if function:
                lengths.append((first, line - first + 1))
            head = ""
        elif letter == ";":
            head = ""
        else:
            if not head.strip() and not letter.isspace():
                head_line = line
            head += letter
        if letter == "\n":
            line += 1
            if head.lstrip().startswith("#") and not head.rstrip().endswith("\\"):
                head = ""
    return lengths


def check_internal(root, path, folder, name, layers, report, where):
    """An installed header that includes an internal one would not compile where it is installed."""
    if not name.startswith("rastro/") or not folder or not is_internal(root / "src" / name):
        return
    if path.suffix == ".h" and folder != "cli" and not is_internal(path) and not is_test(path):
        report.breaches.append(f"{where}: a public header may not include the internal {name}")
    if layers.folder_of(name.split("/")[1:]) != folder:
        report.breaches.append(f"{where}: {name} is internal to its own folder")


def check_include(path, folder, name, quotes, layers, report, where):
    # CMake generates headers named rastro_*.h; everything else stands in the tree.
    if quotes == '"' and not name.startswith(("rastro/", "rastro_")) and folder:
        report.breaches.append(f'{where}: write the whole path of "{name}", from rastro/ on')
    if name.startswith("rastro/") and folder:
        wanted = layers.folder_of(name.split("/")[1:])
        allowed = {folder} | layers.uses(folder)
        if is_test(path):
            allowed |= {"synthetic"} | layers.uses("synthetic")
        if wanted not in allowed and "/" in name[len("rastro/"):]:
            report.breaches.append(f"{where}: {folder} may not include {wanted} (layers.txt)")
    if not folder or path.name.endswith("_test.cpp") or "_testing." in path.name:
        return
    for prefix, homes in HOMES.items():
        if not name.startswith(prefix):
            continue
        if folder not in homes:
            report.breaches.append(f"{where}: <{name}> belongs to {', '.join(sorted(homes)) or 'tests and benchmarks'}")
        elif path.suffix == ".h" and folder != "cli" and not is_internal(path):
            report.breaches.append(f"{where}: a public header may not include <{name}>; or mark it '{INTERNAL}'")
        return


def check_sizes(path, code, report, where):
    count = code.count("\n")
    if count > FILE_LIMIT:
        report.breaches.append(f"{where}: {count} lines; split it (limit {FILE_LIMIT})")
    elif count > FILE_WARNING:
        report.warnings.append(f"{where}: {count} lines; aim at 300")
    for first, length in function_lengths(code):
        if length > FUNCTION_LIMIT:
            report.breaches.append(f"{where}:{first}: a function of {length} lines (limit {FUNCTION_LIMIT})")
        elif length > FUNCTION_WARNING:
            report.warnings.append(f"{where}:{first}: a function of {length} lines; aim at 30")


def check_file(root, path, layers, report):
    where = path.relative_to(root)
    parts = where.parts
    folder = layers.folder_of(parts[2:]) if parts[:2] == ("src", "rastro") and len(parts) > 3 else ""
    text = path.read_text(errors="replace")
    lines = text.splitlines()
    if not lines or lines[0] != LICENCE:
        report.breaches.append(f"{where}:1: the first line must be '{LICENCE}'")
    if folder and not layers.line_of(folder):
        report.breaches.append(f"{where}: folder {folder} has no line in layers.txt")
    if path.suffix == ".h" and "#pragma once" not in text:
        report.breaches.append(f"{where}: a header needs #pragma once")
    for number, line in enumerate(lines, 1):
        match = INCLUDE.match(line)
        if match:
            check_include(path, folder, match.group(2), match.group(1), layers, report, f"{where}:{number}")
            check_internal(root, path, folder, match.group(2), layers, report, f"{where}:{number}")
    code = without_comments_and_strings(text)
    if folder and folder != "cli" and not is_test(path):
        for number, line in enumerate(code.splitlines(), 1):
            if PRINTS_OR_ENDS.search(line):
                report.breaches.append(f"{where}:{number}: the library never prints, exits or aborts; throw rastro::Error")
    check_sizes(path, code, report, where)


def check_tree(root):
    report = Report()
    layers = Layers(root)
    count = 0
    for top in ("src", "tests", "bench", "examples"):
        for path in sorted((root / top).rglob("*")) if (root / top).is_dir() else []:
            if path.suffix in (".h", ".cpp"):
                check_file(root, path, layers, report)
                count += 1
    return report, count


def main():
    root = Path(sys.argv[1] if len(sys.argv) > 1 else Path(__file__).parent.parent).resolve()
    report, count = check_tree(root)
    for line in report.warnings:
        print(f"warning: {line}")
    for line in report.breaches:
        print(f"breach: {line}")
    print(f"check_layers: {count} files, {len(report.breaches)} breaches, {len(report.warnings)} warnings")
    return 1 if report.breaches or count == 0 else 0


if __name__ == "__main__":
    sys.exit(main())
