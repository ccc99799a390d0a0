#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Writes docs/reference-options.md from what the program says of its options.

  scripts/option_pages.py PROGRAM            writes the page
  scripts/option_pages.py --check PROGRAM    changes nothing; exit code 1 when the page is out of date
"""
import re
import subprocess
import sys
from pathlib import Path

PAGE = Path(__file__).resolve().parent.parent / "docs" / "reference-options.md"
TRACKER = {"track": "The tracker: `rastro track`"}
HEAD = """# Options

Made by `make pages` from the option tables in the program; do not edit. `rastro options METHOD` prints the same, and
`rastro options METHOD --yaml` prints a file to edit for `--options FILE`. Values are taken in this order: default, `--preset NAME`,
`--options FILE`, `--set key=value`. The values in force are written to `options.yaml` of every run.
"""


def output_of(program, *words):
    done = subprocess.run([program, *words], capture_output=True, text=True, timeout=30)
    if done.returncode != 0:
        sys.exit(f"option_pages: 'rastro {' '.join(words)}' failed: {done.stderr.strip()}")
    return done.stdout


def defaults(program, method):
    """Name -> default, from the YAML form, where nothing else stands beside the value."""
    lines = output_of(program, "options", method, "--yaml").splitlines()
    return dict(re.match(r"^(\w+): (.*?)(?:  # .*)?$", line).groups() for line in lines if line and line[0] != "#")


def rows(program, method):
    """One [name, default, unit, allowed, reason] per option; the reason is wrapped below its option, indented."""
    values = defaults(program, method)
    found = []
    for line in output_of(program, "options", method).splitlines():
        match = re.match(r"^(\w+) = (.*?)(?:   \((.*)\))?$", line)
        if match:
            name, shown, allowed = match.groups()
            unit = shown.removeprefix(values[name].strip('"')).strip()
            found.append([name, values[name], unit, allowed or "", ""])
        elif line.startswith(" ") and found:
            found[-1][4] = f"{found[-1][4]} {line.strip()}".strip()
    if len(found) != len(values):
        sys.exit(f"option_pages: {len(found)} options described, {len(values)} in the YAML form")
    return found


def methods(program):
    """odometry/NAME or slam/NAME -> title, of every method: the program's list is generated, and the page follows it."""
    titles, kind, label = {}, "", ""
    for line in output_of(program, "methods").splitlines():
        if header := re.match(r"^(\w+) .*: rastro (\w+) DATA --method NAME$", line):
            label, kind = header.groups()
        elif name := re.match(r"^  (\w+)", line):
            titles[f"{kind}/{name[1]}"] = f"{label} by {name[1]}: `rastro {kind} --method {name[1]}`"
    return titles


def page(program):
    parts = [HEAD]
    for method, title in {**TRACKER, **methods(program)}.items():
        parts += [f"## {title}", "", "| option | default | unit | allowed | what it does, and why |",
                  "| --- | --- | --- | --- | --- |"]
        for name, default, unit, allowed, why in rows(program, method):
            cells = [f"`{name}`", f"`{default}`", unit, allowed, why]
            parts.append("| " + " | ".join(cell.replace("|", "\\|") for cell in cells) + " |")
        parts.append("")
    return "\n".join(parts)


def main():
    words = [word for word in sys.argv[1:] if word != "--check"]
    if len(words) != 1:
        sys.exit(__doc__)
    text = page(words[0])
    if "--check" not in sys.argv:
        PAGE.write_text(text)
    elif not PAGE.exists() or PAGE.read_text() != text:
        sys.exit(f"option_pages: {PAGE.name} is out of date; run 'make pages'")


if __name__ == "__main__":
    main()
