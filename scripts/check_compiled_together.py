#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Keeps cmake/compiled_together.txt: which sources of a module are compiled as one (RASTRO_UNITY).

Those of one group must not share names in anonymous namespaces. Checks that they do not and that every source is in a
group; with --fix mends the list, leaving what stands in it where it can.
"""
import pathlib
import re
import sys

ROOT = pathlib.Path(__file__).resolve().parent.parent
LIST = ROOT / "cmake/compiled_together.txt"
HEAD = """# Sources that are compiled as one (RASTRO_UNITY): one group a line, paths from the root. Names in anonymous namespaces differ within
# a group; `alone` begins the line of a source that goes with no other for another reason, as a name that a header has. A source that is
# not here is compiled alone. scripts/check_compiled_together.py --fix keeps this list.
"""
MOST_IN_GROUP = {True: 18, False: 12}  # of tests, most of whose time goes into headers; of others
ROOTS = ["src/rastro", "tests/contract", "tests/real"]
NEVER = re.compile(r"_avx2\.cpp$|/main\.cpp$")
DEFINITIONS = [re.compile(form) for form in (
    r"^(?:struct|class|enum class|enum) (\w+)",
    r"^(?:using|namespace) (\w+) =",
    r"^(?:\[\[\w+\]\] )?(?:constexpr |inline )?[\w:<>,*& ]+? [*&]?(\w+)\(",
    r"^(?:constexpr |const |inline |static )*[\w:<>,&*\s]+?[\s*&](\w+)\s*(?:=|\{|;|\[|\()",
)]
ALIAS = re.compile(r"^(?:using|namespace) \w+ = .*;")
INCLUDED = re.compile(r'^#include "(rastro/[^"]+)"', re.MULTILINE)
DECLARED = re.compile(r"^(?:struct|class|enum class|enum|using) (?:alignas\(\w+\) )?(\w+)(?: final)?(?: :| \{| =|$)", re.MULTILINE)
FURTHER = re.compile(r", (\w+)(?: = |\{|\()")  # constexpr double a = 1.0, b = 2.0;


def module_of(path):
    """The nearest folder around it with a CMakeLists.txt, of which tests are compiled apart."""
    folder = next(parent for parent in (ROOT / path).parents if (parent / "CMakeLists.txt").is_file())
    return str(folder.relative_to(ROOT)) + (" (tests)" if is_test(path) else "")


def is_test(path):
    return re.search(r"_(test|testing)\.cpp$", path) is not None


def most_beside(path):
    return MOST_IN_GROUP[is_test(path)]


def names_of(path):
    """Names at the outermost level of the source's anonymous namespaces, with the namespaces around them; of an alias its text."""
    text = (ROOT / path).read_text()
    found = {}
    for block in re.finditer(r"^namespace \{\n(.*?)^\}  // namespace\n", text, re.MULTILINE | re.DOTALL):
        around = tuple(re.findall(r"^namespace ([\w:]+) \{", text[:block.start()], re.MULTILINE))
        depth = 0
        for line in block.group(1).split("\n"):
            match = next((m for m in (form.match(line) for form in DEFINITIONS) if m), None) if depth == 0 else None
            if match:
                alias = line if ALIAS.match(line) else None
                found |= {(around, name): alias for name in (match.group(1), *FURTHER.findall(line[match.end():]))}
            depth += line.count("{") - line.count("}")
    return found


def types_seen(path, known):
    """Types that the headers declare which the source includes, directly or not."""
    seen = set()
    for header in INCLUDED.findall((ROOT / path).read_text()):
        file = ROOT / "src" / header
        if header not in known and file.is_file():
            known[header] = set()  # ends a circle
            known[header] = set(DECLARED.findall(file.read_text())) | types_seen(file, known)
        seen |= known.get(header, set())
    return seen


class Group:
    """Sources compiled as one."""

    def __init__(self):
        self.files, self.names, self.types = [], {}, set()

    def takes(self, path, names, types):
        """Whether no name of one has another meaning for another: defined twice, or also the name of a type of a header."""
        return (len(self.files) < most_beside(path)
                and all(names[key] and self.names[key] == names[key] for key in names.keys() & self.names.keys())
                and not types & {name for _, name in self.names}
                and not self.types & {name for _, name in names})

    def add(self, path, names, types):
        self.files.append(path)
        self.names |= names
        self.types |= types


def sources():
    found = (str(path.relative_to(ROOT)) for root in ROOTS for path in (ROOT / root).rglob("*.cpp"))
    return sorted(path for path in found if not NEVER.search(path))


def read_list():
    """The groups that stand in the list, and the sources that go with no other."""
    groups, alone = [], []
    for line in LIST.read_text().split("\n") if LIST.is_file() else []:
        words = line.split()
        if not words or words[0].startswith("#"):
            continue
        if words[0] == "alone":
            alone += words[1:]
        else:
            groups.append(words)
    return groups, alone


def grouped(files, groups, names, types):
    """The groups with what can stay in them, and every other file in the first of its module that takes it."""
    result = []
    left = set(files)

    def put(group, path):
        group.add(path, names[path], types[path])
        left.discard(path)

    for former in groups:
        group = Group()
        for path in former:
            if path in left and group.takes(path, names[path], types[path]):
                put(group, path)
        if group.files:
            result.append(group)
    for path in sorted(left, key=lambda path: (-len(names[path]), path)):
        module = module_of(path)
        place = next((group for group in result
                      if module_of(group.files[0]) == module and group.takes(path, names[path], types[path])), None)
        if place is None:
            place = Group()
            result.append(place)
        put(place, path)
    return [sorted(group.files) for group in result]


def main():
    groups, alone = read_list()
    every = sources()
    alone = sorted(set(alone) & set(every))
    files = [path for path in every if path not in alone]
    names = {path: names_of(path) for path in files}
    known = {}
    types = {path: types_seen(path, known) for path in files}
    wanted = sorted(grouped(files, groups, names, types))
    if wanted == sorted(sorted(group) for group in groups) and alone == sorted(read_list()[1]):
        return 0
    if "--fix" in sys.argv:
        lines = [" ".join(group) for group in wanted] + ["alone " + path for path in alone]
        LIST.write_text(HEAD + "\n".join(lines) + "\n")
        return 0
    before = {path: tuple(sorted(group)) for group in groups for path in group}
    for group in wanted:
        for path in group:
            if before.get(path) != tuple(group):
                print(f"{path}: not listed, or shares names of its anonymous namespace with others of its group", file=sys.stderr)
    print("run scripts/check_compiled_together.py --fix, or rename them", file=sys.stderr)
    return 1


if __name__ == "__main__":
    sys.exit(main())
