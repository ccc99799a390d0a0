#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Says how large functions, classes and tests are, and whether they keep the limits of CONTRIBUTING.md.

  scripts/code_size.py [--check] [--most N] [ROOT]

Lists functions over 50 lines, the N classes with most data members (default 10; structs of options apart, whose members
are rows of a table) and test lines per program line by folder. With --check, exit code 1 where a limit is passed: over
1 % of functions longer than 50 lines, a class of over 20 data members, under 0.45 test lines per program line.
Lambdas count as part of the function they stand in; programs are src, bench and examples without their tests.
"""
import argparse
import re
import sys
from collections import defaultdict
from dataclasses import dataclass, field
from pathlib import Path

sys.dont_write_bytecode = True
import check_layers  # noqa: E402

LONG_FUNCTION, MOST_LONG_SHARE = 50, 0.01
MOST_MEMBERS = 20
LEAST_TEST_SHARE = 0.45
OPTIONS = re.compile(r"Options$")  # their members are rows of an option table
NO_MEMBER = re.compile(r"^(using|typedef|friend|static|template|static_assert|enum|class|struct|union|explicit|virtual)\b|\boperator\b")


@dataclass
class Sizes:
    functions: dict = field(default_factory=lambda: {False: 0, True: 0})  # how many, by whether they are tests
    long_functions: list = field(default_factory=list)  # (is a test, lines, "path:line")
    classes: list = field(default_factory=list)  # (data members, name, "path:line")
    lines: dict = field(default_factory=lambda: defaultdict(lambda: [0, 0]))  # folder -> program lines, test lines

    def long_share(self):
        return len(self.long_functions) / max(1, sum(self.functions.values()))

    def test_share(self):
        program, test = (sum(counts[i] for counts in self.lines.values()) for i in (0, 1))
        return test / max(1, program)


def without_brackets(text):
    """The text without what stands in <>, (), [] or {}; `->`, `<=` and the like are not in declarations of members."""
    before = None
    while before != text:
        before, text = text, re.sub(r"<[^<>(){}]*>|\([^(){}]*\)|\{[^{}]*\}|\[[^\[\]]*\]", " ", text)
        text = re.sub(r"<[^<>]*>", " ", text)
    return text


def data_members(statement):
    """How many data members a statement of a class declares: 0 for functions, types and statics."""
    text = re.sub(r"\b(public|protected|private)\s*:", "", statement)
    text = re.sub(r"\[\[.*?\]\]|\b(RASTRO_\w+|alignas)\([^)]*\)", "", text).strip()
    text = re.sub(r"^(\{\}\s*)+", "", text)
    if not text or NO_MEMBER.search(text):
        return 0
    declared = re.split(r"=(?!=)|\{", text)[0]
    while re.search(r"<[^<>]*>", declared):
        declared = re.sub(r"<[^<>]*>", "", declared)
    if "(" in declared or "~" in declared or len(declared.split()) < 2:
        return 0
    return 1 + without_brackets(text).count(",")


def folder_of(where):
    """The folder a file counts to: the module of src/rastro that it belongs to or is a test of, else its first folder."""
    parts = where.parts
    return "/".join(parts[2:4]) if parts[:3] == ("src", "rastro", "slam") and len(parts) > 4 else \
        parts[2] if parts[:2] == ("src", "rastro") and len(parts) > 3 else parts[0]


def measure_file(where, text, sizes):
    test = check_layers.is_test(where) or where.parts[0] == "tests"
    sizes.lines[folder_of(where)][test] += text.count("\n")
    for block in check_layers.blocks(check_layers.without_comments_and_strings(text)):
        length = block.last - block.first + 1
        if block.kind == "function":
            sizes.functions[test] += 1
            if length > LONG_FUNCTION:
                sizes.long_functions.append((test, length, f"{where}:{block.first}"))
        else:
            name = re.search(r"\b(?:class|struct|union)\s+(?:alignas\(\w+\)\s+)?([\w:]+)", block.head)
            members = sum(data_members(statement) for statement in block.statements)
            if name and not OPTIONS.search(name.group(1)):
                sizes.classes.append((members, name.group(1), f"{where}:{block.first}"))


def measure(root):
    sizes = Sizes()
    for top in ("src", "bench", "examples", "tests"):
        for path in sorted((root / top).rglob("*")) if (root / top).is_dir() else []:
            if path.suffix in (".h", ".cpp"):
                measure_file(path.relative_to(root), path.read_text(errors="replace"), sizes)
    sizes.long_functions.sort(key=lambda found: (found[0], -found[1], found[2]))
    sizes.classes.sort(key=lambda found: (-found[0], found[2]))
    return sizes


def breaches(sizes):
    found = []
    if sizes.long_share() > MOST_LONG_SHARE:
        found.append(f"{sizes.long_share():.2%} of the functions are over {LONG_FUNCTION} lines (limit {MOST_LONG_SHARE:.0%})")
    found += [f"{where}: {name} has {members} data members (limit {MOST_MEMBERS})"
              for members, name, where in sizes.classes if members > MOST_MEMBERS]
    if sizes.test_share() < LEAST_TEST_SHARE:
        found.append(f"{sizes.test_share():.2f} test lines per program line (at least {LEAST_TEST_SHARE})")
    return found


def report(sizes, most):
    print(f"functions over {LONG_FUNCTION} lines")
    for test, length, where in sizes.long_functions:
        print(f"  {length:4d}  {where}{' (test)' if test else ''}")
    long_programs = sum(1 for test, _, _ in sizes.long_functions if not test)
    print(f"  {len(sizes.long_functions)} of {sum(sizes.functions.values())} ({sizes.long_share():.2%}); "
          f"{long_programs} of {sizes.functions[False]} in programs\n")
    print("data members of the largest classes, options apart")
    for members, name, where in sizes.classes[:most]:
        print(f"  {members:4d}  {name}  {where}")
    print("\nprogram lines, test lines, test lines per program line")
    for folder, (program, test) in sorted(sizes.lines.items()):
        print(f"  {program:6d} {test:6d}  {test / program if program else 0:5.2f}  {folder}" if program else f"  {program:6d} {test:6d}         {folder}")
    program, test = (sum(counts[i] for counts in sizes.lines.values()) for i in (0, 1))
    print(f"  {program:6d} {test:6d}  {sizes.test_share():5.2f}  in all\n")


def main():
    parser = argparse.ArgumentParser(description="how large functions, classes and tests are")
    parser.add_argument("--check", action="store_true", help="fail where a limit is passed")
    parser.add_argument("--most", type=int, default=10, help="how many classes to list")
    parser.add_argument("root", nargs="?", default=Path(__file__).parent.parent, type=Path)
    arguments = parser.parse_args()
    sizes = measure(arguments.root.resolve())
    report(sizes, arguments.most)
    found = breaches(sizes)
    for line in found:
        print(f"breach: {line}")
    print(f"code_size: {sum(sizes.functions.values())} functions, {len(sizes.classes)} classes, {len(found)} breaches")
    return 1 if arguments.check and found else 0


if __name__ == "__main__":
    sys.exit(main())
