#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Checks README.md and docs/ without running what they show: every subcommand, flag, method and option named exists in
the program's own help, every link, anchor and image leads somewhere, and every code location named in docs/derivations
exists.
    scripts/check_docs.py [PROGRAM]      default: build/release/rastro
    scripts/check_docs.py --list         the commands of the pages, a line each: PAGE<tab>COMMAND
Exit code 1 when something is wrong, with a line for each."""
import pathlib
import re
import shlex
import subprocess
import sys

ROOT = pathlib.Path(__file__).resolve().parent.parent
PAGES = [ROOT / "README.md", *sorted((ROOT / "docs").rglob("*.md"))]
NOT_RUN = re.compile(r"benchmarks|reference-")  # commands there use letters for programs and folders
FLAG = re.compile(r"(?<![\w-])--[a-z][a-z-]*")


def blocks(text):
    """Lines of fenced blocks without a language or in console."""
    for language, body in re.findall(r"^```(\w*)\n(.*?)^```", text, re.M | re.S):
        if language in ("", "console", "sh"):
            yield from re.sub(r"\\\n\s*", " ", body).splitlines()


def commands(text):
    """Commands in blocks, comments left out; several with && are several."""
    for line in blocks(text):
        for part in re.sub(r"(^|\s)#.*", "", line).removeprefix("$ ").split(" && "):
            if re.match(r"(RASTRO_\w+=\S+ )?(rastro|make|cmake|scripts/\S+|build/\S+|cd|export|git|colmap|evo_\w+) ", part.strip() + " "):
                yield part.strip()


def inline_commands(text):
    prose = re.sub(r"^```.*?^```", "", text, flags=re.M | re.S)
    return re.findall(r"`(rastro [a-z][^`]*)`", prose), FLAG.findall(" ".join(re.findall(r"`(--[^`]*)`", prose)))


class Program:
    """What the program says of itself."""

    def __init__(self, path):
        self.path = path
        self.help = {"": self.ask("--help")}
        for name in self.subcommands(""):
            self.help[name] = self.ask(name, "--help")
            for second in self.subcommands(name):
                self.help[f"{name} {second}"] = self.ask(name, second, "--help")
        self.methods = set(re.findall(r"^  (\w+)\s{2,}\S", self.ask("methods"), re.M))
        names = ["track", *self.methods, "odometry/rgbd"]
        self.options = {o for m in names for o in re.findall(r"^(\w+) = ", self.ask("options", m), re.M)}
        self.flags = {f for text in self.help.values() for f in FLAG.findall(text)}

    def ask(self, *words):
        done = subprocess.run([self.path, *words], capture_output=True, text=True, check=False)
        if done.returncode != 0:
            sys.exit(f"{self.path} {' '.join(words)}: {done.stderr.strip()}")
        return done.stdout

    def subcommands(self, of):
        listed = re.search(r"^Subcommands:\n((?:  .*\n)+)", self.help[of], re.M)
        return re.findall(r"^  (\w+)", listed[1], re.M) if listed else []


def check_command(command, program, complain):
    try:
        words = shlex.split(command)[1:]
    except ValueError:
        return complain(f"no shell would read `{command}`")
    if not words or words[0].startswith("--"):
        name = ""
    else:
        name = " ".join(words[:2]) if " ".join(words[:2]) in program.help else words[0]
    if name not in program.help:
        return complain(f"`{command}`: no subcommand '{name}'")
    known = FLAG.findall(program.help[name]) + ["--help"]
    for i, word in enumerate(words):
        flag, value = (word.split("=", 1) + [""])[:2]
        following = value or (words[i + 1] if i + 1 < len(words) else "")
        if word.startswith("--") and flag not in known:
            complain(f"`{command}`: '{name}' has no {flag}")
        if flag == "--method" and re.fullmatch(r"[a-z]+", following) and following not in program.methods:
            complain(f"`{command}`: no method '{following}'")
        if flag == "--set" and re.match(r"\w+=", following) and following.split("=")[0] not in program.options:
            complain(f"`{command}`: no option '{following.split('=')[0]}'")
        if flag == "--to" and re.fullmatch(r"[a-z0-9-]+", following) and not re.search(rf"\b{following}\b", program.help[name]):
            complain(f"`{command}`: {name} writes no '{following}'")


def anchors(page):
    prose = re.sub(r"^```.*?^```", "", page.read_text(), flags=re.M | re.S)
    return {re.sub(r"[^\w\- ]", "", h.lower()).strip().replace(" ", "-") for h in re.findall(r"^#+ (.*)", prose, re.M)}


def check_links(page, text, complain):
    for target in re.findall(r"\]\(([^)\s]+)\)", re.sub(r"^```.*?^```", "", text, flags=re.M | re.S)):
        if re.match(r"https?:|mailto:", target):
            continue
        path, _, anchor = target.partition("#")
        there = (page.parent / path).resolve() if path else page
        if not there.exists():
            complain(f"link to {target}: nothing there")
        elif anchor and there.suffix == ".md" and anchor not in anchors(there):
            complain(f"link to {target}: no such heading")


def check_code_locations(text, complain):
    """`module/file.cpp` (`name`, `name`): the file is below src/rastro and has the names."""
    for file, names in re.findall(r"`([\w/]+/\w+\.(?:h|cpp))`(?: \(((?:`[\w:]+`(?:, )?)+)\))?", text):
        path = ROOT / "src" / "rastro" / file
        if not path.exists():
            complain(f"no file src/rastro/{file}")
            continue
        source = path.read_text()
        for name in re.findall(r"`([\w:]+)`", names):
            if not re.search(rf"\b{name}\b", source):
                complain(f"src/rastro/{file} has no {name}")


def main():
    arguments = sys.argv[1:]
    if arguments == ["--list"]:
        for page in PAGES:
            for command in commands(page.read_text()) if not NOT_RUN.search(page.name) else []:
                print(f"{page.relative_to(ROOT)}\t{command}")
        return 0
    program = Program(arguments[0] if arguments else str(ROOT / "build/release/rastro"))
    wrong = []
    for page in PAGES:
        text, where = page.read_text(), page.relative_to(ROOT)
        complain = lambda what, where=where: wrong.append(f"{where}: {what}")
        check_links(page, text, complain)
        inline, flags = inline_commands(text)
        if not NOT_RUN.search(page.name):
            for command in [c for c in commands(text) if c.startswith("rastro ")] + inline:
                check_command(command, program, complain)
        for flag in set(flags) - program.flags - {"--help", "--prefix", "--version"}:
            complain(f"no command has {flag}")
        if page.parent.name == "derivations":
            check_code_locations(text, complain)
    print("\n".join(wrong) or f"{len(PAGES)} pages: all they name exists")
    return 1 if wrong else 0


if __name__ == "__main__":
    sys.exit(main())
