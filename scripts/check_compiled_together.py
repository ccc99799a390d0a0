#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Sources of a module that are compiled as one (RASTRO_UNITY) must not share names in anonymous namespaces.

Finds those that do and are not in cmake/compiled_alone.txt; with --fix adds as few as it takes to that list.
"""
import collections
import pathlib
import re
import sys

ROOT = pathlib.Path(__file__).resolve().parent.parent
LIST = ROOT / "cmake/compiled_alone.txt"
DEFINITIONS = [re.compile(form) for form in (
    r"^(?:struct|class|enum class|enum) (\w+)",
    r"^using (\w+) =",
    r"^(?:\[\[\w+\]\] )?(?:constexpr |inline )?[\w:<>,*& ]+? [*&]?(\w+)\(",
    r"^(?:constexpr |const |inline |static )*[\w:<>,&*\s]+?[\s*&](\w+)\s*(?:=|\{|;|\[|\()",
)]


def module_of(path):
    """The nearest folder around it with a CMakeLists.txt, of which tests are compiled apart."""
    folder = next(parent for parent in path.parents if (parent / "CMakeLists.txt").is_file())
    tests = " (tests)" if re.search(r"_(test|testing)\.cpp$", path.name) else ""
    return str(folder.relative_to(ROOT)) + tests


def names_of(path):
    """Names at the outermost level of the source's anonymous namespaces, with the namespaces around them."""
    text = path.read_text()
    found = set()
    for block in re.finditer(r"^namespace \{\n(.*?)^\}  // namespace\n", text, re.MULTILINE | re.DOTALL):
        around = tuple(re.findall(r"^namespace ([\w:]+) \{", text[:block.start()], re.MULTILINE))
        depth = 0
        for line in block.group(1).split("\n"):
            match = next((m for m in (form.match(line) for form in DEFINITIONS) if m), None) if depth == 0 else None
            if match:
                found.add((around, match.group(1)))
            depth += line.count("{") - line.count("}")
    return found


def meetings(files, names):
    """How many names each file shares with others."""
    users = collections.defaultdict(list)
    for file in files:
        for name in names[file]:
            users[name].append(file)
    return collections.Counter(file for shared in users.values() if len(shared) > 1 for file in shared)


def main():
    listed = set(LIST.read_text().split("\n"))
    modules = collections.defaultdict(list)
    for path in sorted((ROOT / "src/rastro").rglob("*.cpp")):
        relative = str(path.relative_to(ROOT))
        if relative not in listed and not re.search(r"^src/rastro/cli/|_avx2\.cpp$", relative):
            modules[module_of(path)].append(path)
    alone = []
    for module, files in sorted(modules.items()):
        names = {file: names_of(file) for file in files}
        while counts := meetings(files, names):
            worst = max(sorted(counts), key=counts.get)
            files.remove(worst)
            alone.append(str(worst.relative_to(ROOT)))
    if not alone:
        return 0
    if "--fix" in sys.argv:
        with LIST.open("a") as file:
            file.writelines(name + "\n" for name in sorted(alone))
        return 0
    for name in sorted(alone):
        print(f"{name}: shares names of its anonymous namespace with other sources; run "
              "scripts/check_compiled_together.py --fix, or rename them", file=sys.stderr)
    return 1


if __name__ == "__main__":
    sys.exit(main())
