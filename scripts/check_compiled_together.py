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
MOST_IN_GROUP = {True: 18, False: 9}  # of tests, most of whose time goes into headers; of others
ROOTS = ["src/rastro", "tests/contract", "tests/real"]
NEVER = re.compile(r"_avx2\.cpp$|/main\.cpp$")
DEFINITIONS = [re.compile(form) for form in (
    r"^(?:struct|class|enum class|enum) (\w+)",
    r"^using (\w+) =",
    r"^(?:\[\[\w+\]\] )?(?:constexpr |inline )?[\w:<>,*& ]+? [*&]?(\w+)\(",
    r"^(?:constexpr |const |inline |static )*[\w:<>,&*\s]+?[\s*&](\w+)\s*(?:=|\{|;|\[|\()",
)]
FURTHER = re.compile(r", (\w+) = ")  # constexpr double a = 1.0, b = 2.0;


def module_of(path):
    """The nearest folder around it with a CMakeLists.txt, of which tests are compiled apart."""
    folder = next(parent for parent in (ROOT / path).parents if (parent / "CMakeLists.txt").is_file())
    return str(folder.relative_to(ROOT)) + (" (tests)" if is_test(path) else "")


def is_test(path):
    return re.search(r"_(test|testing)\.cpp$", path) is not None


def most_beside(path):
    return MOST_IN_GROUP[is_test(path)]


def names_of(path):
    """Names at the outermost level of the source's anonymous namespaces, with the namespaces around them."""
    text = (ROOT / path).read_text()
    found = set()
    for block in re.finditer(r"^namespace \{\n(.*?)^\}  // namespace\n", text, re.MULTILINE | re.DOTALL):
        around = tuple(re.findall(r"^namespace ([\w:]+) \{", text[:block.start()], re.MULTILINE))
        depth = 0
        for line in block.group(1).split("\n"):
            match = next((m for m in (form.match(line) for form in DEFINITIONS) if m), None) if depth == 0 else None
            if match:
                found |= {(around, name) for name in (match.group(1), *FURTHER.findall(line[match.end():]))}
            depth += line.count("{") - line.count("}")
    return found


def public_types():
    """Types that headers declare: a source with one of that name in its anonymous namespace would hide it from others."""
    form = re.compile(r"^(?:struct|class|enum class|enum|using) (\w+)(?: final)?(?: :| \{| =|$)", re.MULTILINE)
    return {name for path in (ROOT / "src/rastro").rglob("*.h") if not path.name.endswith("_testing.h")
            for name in form.findall(path.read_text())}


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


def grouped(files, groups, names):
    """The groups with what can stay in them, and every other file where it meets no name of its own."""
    taken = {}
    result = []
    for group in groups:
        kept, used = [], set()
        for path in group:
            if path in files and path not in taken and not names[path] & used and len(kept) < most_beside(path):
                kept.append(path)
                used |= names[path]
                taken[path] = True
        if kept:
            result.append((kept, used))
    for path in sorted((path for path in files if path not in taken), key=lambda path: (-len(names[path]), path)):
        module = module_of(path)
        place = next(((kept, used) for kept, used in result
                      if len(kept) < most_beside(path) and module_of(kept[0]) == module and not names[path] & used), None)
        if place is None:
            place = ([], set())
            result.append(place)
        place[0].append(path)
        place[1].update(names[path])
    return [sorted(kept) for kept, _ in result]


def main():
    groups, alone = read_list()
    every = sources()
    names = {path: names_of(path) for path in every}
    types = public_types()
    hiding = {path for path in every if any(name in types for _, name in names[path])}
    alone = sorted(set(alone) & set(every) | hiding)
    files = {path for path in every if path not in alone}
    wanted = sorted(grouped(files, groups, names))
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
