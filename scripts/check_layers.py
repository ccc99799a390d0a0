#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Checks every C++ source against layers.txt and the house rules that a program can check.

  scripts/check_layers.py [ROOT]

Breaches (exit code 1): an include that layers.txt does not allow, files that include one another in a loop, a third
party outside of its home, a third party in a public header, a library source that prints or ends the program, a missing
licence line, a file over 800 lines, a function over 120. Warnings: a file over 500 lines, a function over 60.
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
    "opencv2/": {"calibration", "dataset", "export", "feature", "map", "synthetic"},
    "dlib/": {"feature"},
    "yaml-cpp/": {"base", "camera", "dataset", "evaluate", "export", "cli"},
    "nlohmann/": {"calibration", "dataset", "evaluate", "export", "session", "viewer", "cli"},
    "boost/": {"viewer"},
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
    "zlib.h": {"dataset", "export"},
    "google/protobuf/": {"export"},
    "foxglove.pb.h": {"export"},
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


@dataclass
class Block:
    """A pair of braces: its kind, the line its head begins on, the head, and its statements where it is a class."""
    kind: str  # scope (namespace), class, function, other, or value: braces of a list of initial values
    first: int
    head: str
    last: int = 0
    statements: list = field(default_factory=list)  # text of each one that ends in ';'


def kind_of_block(head, outside):
    """What the '{' after this head opens, inside of a block of kind `outside`."""
    if outside not in ("scope", "class"):
        return "other"
    head = re.sub(r"\btemplate\s*<.*?>\s*(?=\w)", "", head, flags=re.DOTALL).strip()
    before = head.split("(")[0]
    if SCOPE.search(before) and "=" not in before:
        opener = SCOPE.search(before).group(1)
        return {"enum": "other", "class": "class", "struct": "class", "union": "class"}.get(opener, "scope")
    if "(" not in head or head.count("(") != head.count(")") or head.endswith("="):
        return "other"
    starts = re.search(r"\)[\w\s]*?(?<!:):(?!:)", head)  # a constructor's list of initial values
    if starts and re.search(r"[\w>]$", head[starts.end():]) and not head.endswith("noexcept"):
        return "value"
    return "function"


def blocks(code):
    """Every namespace, class and function body in code without comments; what stands inside of functions is left out."""
    found = []
    stack = []
    head, head_line, line = "", 1, 1
    for letter in code:
        if letter == "{":
            kind = kind_of_block(head, stack[-1].kind if stack else "scope")
            stack.append(Block(kind, head_line if head.strip() else line, head))
            head = ""
        elif letter == "}" and stack:
            block = stack.pop()
            block.last = line
            if block.kind in ("class", "function"):
                found.append(block)
            # A list of initial values goes on after its braces, and so does `int a{1};`.
            goes_on = block.kind == "value" or (block.kind == "other" and (stack[-1].kind if stack else "scope") in ("scope", "class"))
            head = block.head + "{}" if goes_on else ""
            head_line = block.first if goes_on else line
        elif letter == ";":
            if stack and stack[-1].kind == "class" and head.strip():
                stack[-1].statements.append(head.strip())
            head = ""
        else:
            if not head.strip() and not letter.isspace():
                head, head_line = "", line
            head += letter
        if letter == "\n":
            line += 1
            if head.lstrip().startswith("#") and not head.rstrip().endswith("\\"):
                head = ""
    return found


def function_lengths(code):
    """(first line, lines) of each function in code without comments, in their order."""
    return sorted((block.first, block.last - block.first + 1) for block in blocks(code) if block.kind == "function")


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


def include_loops(includes):
    """Each loop of files that include one another (path -> paths) once, as the list of its paths in their order."""
    loops = set()
    done = set()
    for start in sorted(includes):
        path = [(start, iter(sorted(includes[start])))] if start not in done else []
        while path:
            wanted = next(path[-1][1], None)
            names = [name for name, _ in path]
            if wanted is None:
                done.add(path.pop()[0])
            elif wanted in names:
                loop = names[names.index(wanted):]
                lowest = loop.index(min(loop))
                loops.add(tuple(loop[lowest:] + loop[:lowest]))
            elif wanted not in done and wanted in includes:
                path.append((wanted, iter(sorted(includes[wanted]))))
    return sorted(loops)


def check_loops(root, report):
    """No file of src may include itself over others: nobody could read or test one of them alone."""
    includes = {}
    for path in sorted((root / "src").rglob("*")) if (root / "src").is_dir() else []:
        if path.suffix in (".h", ".cpp"):
            found = (INCLUDE.match(line) for line in path.read_text(errors="replace").splitlines())
            includes[path.relative_to(root / "src").as_posix()] = {match.group(2) for match in found if match}
    for loop in include_loops(includes):
        report.breaches.append(f"src/{loop[0]}: files include one another: {' -> '.join(loop + loop[:1])}")


def check_tree(root):
    report = Report()
    layers = Layers(root)
    count = 0
    check_loops(root, report)
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
