#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Writes the man page and the bash completion of the program from its own --help texts.

  scripts/program_pages.py PROGRAM FOLDER      writes FOLDER/rastro.1 and FOLDER/rastro.bash
"""
import re
import subprocess
import sys
from pathlib import Path


def output_of(program, *words):
    done = subprocess.run([program, *words], capture_output=True, text=True, timeout=30)
    if done.returncode != 0:
        sys.exit(f"program_pages: '{' '.join([Path(program).name, *words])}' failed: {done.stderr.strip()}")
    return done.stdout


def subcommands(help_text):
    """The names listed below 'Subcommands:'."""
    names = []
    listed = False
    for line in help_text.splitlines():
        if re.match(r"^\S", line):
            listed = line.startswith("Subcommands:")
        match = re.match(r"^  ([a-z][a-z-]*)(\s|$)", line)
        if listed and match:
            names.append(match.group(1))
    return names


def collect(program, words=()):
    """[(words, help)] of the command and everything below it, depth first."""
    text = output_of(program, *words, "--help")
    found = [(words, text)]
    for name in subcommands(text):
        found += collect(program, (*words, name))
    return found


def flags(help_text):
    """The flags that are described, not those that examples and notes mention."""
    return sorted(set(re.findall(r"^ +(?:-\w,)?(--[a-z][a-z-]*)", help_text, re.MULTILINE)))


def roff(text):
    escaped = text.rstrip().replace("\\", "\\e").replace("-", "\\-")
    return "\n".join("\\&" + line if line.startswith((".", "'")) else line for line in escaped.splitlines())


def man_page(pages, version):
    parts = [f'.TH RASTRO 1 "" "{version}" "User commands"', ".SH NAME",
             "rastro \\- feature tracks, trajectories and maps from camera and laser recordings", ".SH SYNOPSIS",
             ".B rastro", "COMMAND [flags]"]
    for words, text in pages:
        parts += [f".SH {' '.join(words).upper() or 'DESCRIPTION'}", ".nf", roff(text), ".fi"]
    return "\n".join(parts) + "\n"


def methods(program):
    """[(command, name)] of every method that `rastro methods` lists."""
    found, command = [], ""
    for line in output_of(program, "methods").splitlines():
        if header := re.search(r": rastro (\w+) DATA --method NAME$", line):
            command = header[1]
        elif name := re.match(r"^  (\w+)", line):
            found.append((command, name[1]))
    return found


def choices(kind, description):
    """The values that a flag takes, by its type (a|b) or the list that its description is or begins with."""
    if "|" in kind:
        return [word for word in kind.split("|") if word.islower()]
    if quoted := re.findall(r"'([a-z-]+)':", description):
        return quoted
    plain = re.sub(r" \([^)]*\)", "", description).split(";")[0].rsplit(": ", 1)[-1]
    words = re.split(r", | or ", plain)
    return words if kind in ("FORMAT", "KIND", "MODE", "TEXT") and all(map(re.compile("[a-z0-9-]+").fullmatch, words)) else []


def valued_flags(help_text):
    """{flag: values} of the flags that take a value; no values: a file, or something that nobody can guess."""
    found = {}
    for flag, kind, description in re.findall(r"^ +(?:-\w,)?(--[a-z][a-z-]*) ([A-Za-z][^ ]*)(?: REQUIRED)?(?: \.\.\.)? {2,}(.*)",
                                              help_text, re.MULTILINE):
        found[flag] = choices(kind.split("=")[0], description)
    return found


def worlds(program):
    return re.findall(r"^([a-z]+) +", output_of(program, "simulate"), re.MULTILINE)


def case(words, text, names, methods_of):
    """What may stand after a command: values after a flag that takes one, flags after a dash, else names or files."""
    lines = []
    for flag, values in valued_flags(text).items():
        values = methods_of if flag == "--method" else values
        lines.append(f'      {flag}) candidates="{" ".join(values)}" ;;')
    return f"""    "{' '.join(words)}")
      flags="{' '.join(flags(text))}"
      names="{' '.join(names)}"
      case "$before" in
{chr(10).join(lines + ["      *) known=no ;;"])}
      esac ;;"""


def completion(pages, listed, world_names):
    cases = []
    for words, text in pages:
        names = subcommands(text)
        if words == ("options",):
            names = ["track", *sorted({name for _, name in listed})]
        if words == ("simulate",):
            names = world_names
        cases.append(case(words, text, names, [name for command, name in listed if (command,) == words]))
    return f"""# bash completion of rastro, made from its --help texts
_rastro() {{
  local word words="" flags="" names="" candidates="" known=yes
  local current="${{COMP_WORDS[COMP_CWORD]}}" before="${{COMP_WORDS[COMP_CWORD-1]}}"
  for word in "${{COMP_WORDS[@]:1:COMP_CWORD-1}}"; do
    case "$words${{words:+ }}$word" in
      {" | ".join(chr(34) + " ".join(words) + chr(34) for words, _ in pages if words)}) words="$words${{words:+ }}$word" ;;
    esac
  done
  case "$words" in
{chr(10).join(cases)}
  esac
  if [[ $known == no ]]; then
    candidates=$names
    [[ $current == -* ]] && candidates=$flags
  fi
  # Without candidates bash completes names of files.
  mapfile -t COMPREPLY < <(compgen -W "$candidates" -- "$current")
}}
complete -o default -F _rastro rastro
"""


def main():
    if len(sys.argv) != 3:
        sys.exit("usage: scripts/program_pages.py PROGRAM FOLDER")
    program, folder = sys.argv[1], Path(sys.argv[2])
    pages = collect(program)
    folder.mkdir(parents=True, exist_ok=True)
    (folder / "rastro.1").write_text(man_page(pages, output_of(program, "--version").splitlines()[0]))
    (folder / "rastro.bash").write_text(completion(pages, methods(program), worlds(program)))


if __name__ == "__main__":
    main()
