#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""How many small faults the tests would notice: changes one spot of a source at a time and runs the tests that fit.

A mutation is drawn (seeded) from the sources of the folders given, without tests, texts, checks and option tables;
applied, compiled with the build tree given, and run against the module's own test program. Where that passes, the
test programs of its users are linked and run, then the contract tests of the methods that use it, up to the first
failure. It is caught when a test fails, crashes or hangs. What does not compile is drawn again. The source is put back
after each one, also when this is interrupted; after kill -9 the next start puts it back.

  scripts/mutate.py track slam/orb optimize map --count 100 --seed 1 --out mutations
  scripts/mutate.py slam/hector --count 5 --list          # only show what would be drawn
  scripts/mutate.py slam/orb --unit-only                  # what the module's own tests notice, in a tenth of the time

--out DIR gets mutations.csv, survivors.diff and summary.txt.
"""
import argparse
import csv
import difflib
import os
import pathlib
import random
import re
import shlex
import signal
import subprocess
import sys
import time

ROOT = pathlib.Path(__file__).resolve().parent.parent
SOURCES = ROOT / "src/rastro"

# A statement with one of these is a text for people, a promise, a table of options or only about speed.
UNSUITABLE = re.compile(r"fmt::|\bthrow\b|\bError\b|RASTRO_CHECK|static_assert|\blog_\w+\(|\bdetail\b|table\.add|\.add\(\{|"
                        r"\.reserve\(|name_of|Stopwatch|milliseconds|\busing\b|\btemplate\b|\boperator\b|^\s*#|why\b|"
                        r"\bstd::(move|string|to_string)\b")
ARITHMETIC = ["+", "-", "*", "/"]
BOUNDARY = {"<": "<=", "<=": "<", ">": ">=", ">=": ">"}
OPPOSITE = {"<": ">=", "<=": ">", ">": "<=", ">=": "<", "==": "!=", "!=": "=="}

# Which contract tests see a module or a part of it; the accuracy rows of tests/golden/accuracy.csv are filtered the
# same way. The first whose folder or file name begins like the mutated one counts.
CONTRACT = [
    ("slam/orb/initialization/initializer", "OrbStarts.*:Methods/SlamContract.*/orb_mono", "Golden/*orb_mono*"),
    ("slam/orb/tracking/stereo_matching", "Methods/SlamContract.*/orb_stereo", "Golden/*orb_stereo*"),
    ("slam/orb", "Methods/SlamContract.*/orb*:OrbStarts.*", "Golden/*orb_*"),
    ("backend/rgbd", "Methods/SlamContract.*/rgbd", "Golden/*/rgbd_*"),
    ("slam/hector", "Methods/SlamContract.*/hector", "Golden/*hector*"),
    ("slam/ekf", "Methods/SlamContract.*/ekf", "Golden/*ekf*"),
    ("odometry", "Methods/SlamContract.*/rgbd", "Golden/*/features*:Golden/*/classic*:Golden/*/profiles*:Golden/*/hybrid*:Golden/*/rgbd*"),
    ("optimize", "Methods/SlamContract.*/rgbd:Methods/SlamContract.*/orb*:Methods/SlamContract.*/hector", "Golden/*"),
    ("map", "Methods/SlamContract.*", ""),
    ("track", "", "Golden/*/features*:Golden/*/hybrid*"),
    ("", "Methods/SlamContract.*", "Golden/*"),
]
# Test programs of modules that use another: run after its own.
USERS = {"optimize": ["rastro_slam_orb_test", "rastro_slam_hector_test"], "track": ["rastro_odometry_test"],
         "map": ["rastro_export_test"]}


def blanked(text):
    """The text with comments, strings and characters as spaces, at the same places."""
    pattern = re.compile(r'//[^\n]*|/\*.*?\*/|R"(\w*)\(.*?\)\1"|"(?:\\.|[^"\\\n])*"|\'(?:\\.|[^\'\\\n])\'', re.S)
    return pattern.sub(lambda m: re.sub(r"[^\n]", " ", m.group(0)), text)


def unsuitable_spans(text):
    """Where nothing is to be changed: whole statements, and preprocessor lines."""
    spans, begin = [], 0
    for mark in re.finditer(r"[;{}]", text):
        statement = text[begin:mark.end()]
        if UNSUITABLE.search(statement):
            spans.append((begin, mark.end()))
        begin = mark.end()
    spans += [m.span() for m in re.finditer(r"^[ \t]*#[^\n]*", text, re.M)]
    return spans


class Mutation:
    def __init__(self, path, begin, end, new, kind, old):
        self.path, self.begin, self.end, self.new, self.kind, self.old = path, begin, end, new, kind, old

    def key(self):
        return (str(self.path), self.begin, self.end, self.new)

    def applied(self, text):
        return text[: self.begin] + self.new + text[self.end:]


def operators(text):
    for m in re.finditer(r"(?<=[\w\])] )([-+*/])(?= [\w(*!-])", text):
        yield m, "arithmetic", [o for o in ARITHMETIC if o != m.group(1)]
    for m in re.finditer(r"(?<= )([-+*/])=(?= )", text):
        yield m, "arithmetic", [o + "=" for o in ARITHMETIC if o != m.group(1)]
    for m in re.finditer(r"(?<=[\w\])] )(<=|>=|==|!=|<|>)(?= [\w(*!-])", text):
        yield m, "comparison", [OPPOSITE[m.group(1)]]
        if m.group(1) in BOUNDARY:
            yield m, "off by one", [BOUNDARY[m.group(1)]]
    for m in re.finditer(r"(?<= )(&&|\|\|)(?= )", text):
        yield m, "logical", ["||" if m.group(1) == "&&" else "&&"]


def constants(text):
    for m in re.finditer(r"(?<![\w.])(\d+\.\d+(?:e[-+]?\d+)?|\d+)([uUlLfF]*)(?![\w.])", text):
        number, suffix = m.group(1), m.group(2)
        if "." in number or "e" in number:
            value = float(number)
            yield m, "constant", [f"{v!r}{suffix}" for v in (value + 1.0, value - 1.0, 2.0 * value) if v != value]
        else:
            value = int(number)
            yield m, "constant", [f"{v}{suffix}" for v in {value + 1, max(0, value - 1), 2 * value} if v != value]


def balanced_end(text, at):
    """Behind the parenthesis that closes the one at `at`; -1 where there is none."""
    depth = 0
    for i in range(at, min(len(text), at + 600)):
        depth += {"(": 1, ")": -1}.get(text[i], 0)
        if depth == 0:
            return i + 1
    return -1


def statements(text):
    call = r"[A-Za-z_][\w.:>\[\]-]*(?:\(|\s(?:[-+*/]?=)\s)"
    for m in re.finditer(r"^[ \t]+((?!return\b|const\b|auto\b|using\b|static\b|case\b|else\b|if\b|for\b|while\b)" + call +
                         r"[^\n;{}]*;|continue;|break;)$", text, re.M):
        if text[: m.start()].rstrip()[-1:] in (";", "{", "}", ":"):
            yield m, "removed statement", [";"]
    for m in re.finditer(r"\b(?:if|while) (\()", text):
        end = balanced_end(text, m.start(1))
        inside = text[m.start(1) + 1: end - 1]
        if end > 0 and ";" not in inside and not re.search(r"\b(auto|const)\b", inside):
            yield (m.start(1), end), "negated condition", [f"(!({inside}))"]
    simple = r"[\w.\[\]:>-]+"
    for m in re.finditer(r"(?<=\w)\((" + simple + "), (" + simple + r")(?=[,)])", text):
        if m.group(1) != m.group(2):
            yield m, "swapped arguments", [f"({m.group(2)}, {m.group(1)}"]


def candidates(path):
    raw = path.read_text()
    text = blanked(raw)
    closed = unsuitable_spans(text)
    found = {}
    for maker in (operators, constants, statements):
        for match, kind, news in maker(text):
            begin, end = match if isinstance(match, tuple) else match.span(1 if kind == "removed statement" else 0)
            if any(b < end and begin < e for b, e in closed):
                continue
            # A condition or an argument list is taken from the raw text, with what was blanked.
            for new in news:
                if raw[begin:end] != text[begin:end] and kind != "removed statement":
                    continue
                found.setdefault(kind, []).append(Mutation(path, begin, end, new, kind, raw[begin:end]))
    return found


def source_files(folders):
    files = []
    for folder in folders:
        base = SOURCES / folder
        paths = sorted(base.rglob("*.cpp")) if base.is_dir() else [base]
        if not paths or not paths[0].exists():
            sys.exit(f"mutate: no sources in {base}")
        files += [p for p in paths
                  if not re.search(r"(_test|_testing|/options|/main|/method|/names)\.cpp$", str(p))]
    return files


class Drawer:
    """Draws without repeating: a kind first, so that rare kinds come too, then a spot."""

    def __init__(self, files, seed):
        self.random = random.Random(seed)
        self.by_kind = {}
        for path in files:
            for kind, mutations in candidates(path).items():
                self.by_kind.setdefault(kind, []).extend(mutations)
        self.seen = set()

    def draw(self):
        while any(self.by_kind.values()):
            kind = self.random.choice(sorted(k for k, all_ in self.by_kind.items() if all_))
            mutation = self.by_kind[kind].pop(self.random.randrange(len(self.by_kind[kind])))
            if mutation.key() not in self.seen:
                self.seen.add(mutation.key())
                return mutation
        return None


class Workspace:
    """One changed source at a time, put back whatever happens."""

    def __init__(self, build):
        self.journal = ROOT / build / "mutate-journal"

    def recover(self):
        if self.journal.exists():
            name, _, original = self.journal.read_text().partition("\n")
            pathlib.Path(name).write_text(original)
            self.journal.unlink()
            print(f"put back {name}, which an earlier run had left changed")

    def apply(self, mutation):
        original = mutation.path.read_text()
        partial = self.journal.with_suffix(".part")
        partial.write_text(f"{mutation.path}\n{original}")
        partial.rename(self.journal)
        mutation.path.write_text(mutation.applied(original))
        return original

    def restore(self, mutation, original):
        # With a new time, so that what was compiled of the changed text is compiled again.
        mutation.path.write_text(original)
        self.journal.unlink(missing_ok=True)


class Tests:
    def __init__(self, options):
        self.build, self.prefix, self.jobs = options.build, shlex.split(options.prefix), options.jobs
        self.accuracy, self.extra, self.unit_only = options.accuracy, options.tests, options.unit_only
        self.modules = [line.split(":")[0].split(" ", 1)[1] for line in (ROOT / "layers.txt").read_text().splitlines()
                        if re.match(r"\d", line)]
        self.modules = [name.strip() for line in self.modules for name in line.split(",")]
        # `slam/*` stands for every folder of a method.
        self.modules = [folder.relative_to(SOURCES).as_posix() if "*" in name else name for name in self.modules
                        for folder in (SOURCES.glob(name + "/CMakeLists.txt") if "*" in name else [SOURCES / name])]
        self.modules = [name.removesuffix("/CMakeLists.txt") for name in self.modules]
        self.limits = {}

    def module_of(self, path):
        folder = path.relative_to(SOURCES).parent.as_posix()
        return max((m for m in self.modules if folder == m or folder.startswith(m + "/")), key=len)

    def programs_for(self, path):
        """(program, filter), the quickest to fail first."""
        module, source = self.module_of(path), path.relative_to(SOURCES).as_posix()
        own = f"rastro_{module.replace('/', '_')}_test"
        found = [(own, "*")] if any((SOURCES / module).rglob("*_test.cpp")) else []
        found += [(program, "*") for program in USERS.get(module, [])]
        if self.unit_only:
            return found
        contract, accuracy = next((c, a) for prefix, c, a in CONTRACT if source.startswith(prefix))
        found += [("rastro_contract_test", contract)] if contract else []
        found += [("rastro_real_test", accuracy)] if accuracy and self.accuracy else []
        return found + [tuple(t.split("=", 1)) if "=" in t else (t, "*") for t in self.extra]

    def build_programs(self, programs):
        command = ["cmake", "--build", str(self.build), "--parallel", str(self.jobs), "--target",
                   *sorted({program for program, _ in programs})]
        return self.run(command, 3600)

    def run(self, command, limit_s):
        """(exit code, last lines); None as the code: it took longer than the limit."""
        process = subprocess.Popen(self.prefix + command, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True,
                                   cwd=ROOT, start_new_session=True, errors="replace")
        try:
            text = process.communicate(timeout=limit_s)[0]
            return process.returncode, text
        except subprocess.TimeoutExpired:
            return None, ""
        finally:
            if process.poll() is None:
                try:
                    os.killpg(process.pid, signal.SIGKILL)
                except ProcessLookupError:
                    pass
                process.wait()

    def test(self, program, filter_, limit_s):
        return self.run([str(self.build / program), f"--gtest_filter={filter_}", "--gtest_brief=1",
                         "--gtest_fail_fast"], limit_s)

    def baseline(self, programs):
        """All must pass as things stand; how long that takes sets the limits."""
        for program, filter_ in programs:
            if (program, filter_) in self.limits:
                continue
            begin = time.monotonic()
            code, text = self.test(program, filter_, 1200)
            if code != 0:
                sys.exit(f"mutate: {program} --gtest_filter={filter_} does not pass as things stand:\n{text[-2000:]}")
            took = time.monotonic() - begin
            self.limits[(program, filter_)] = max(20.0, 5.0 * took)
            print(f"{program} {filter_}: {took:.1f} s as things stand", flush=True)

    def verdict(self, programs):
        """"does not compile", "caught" or "survived", and by what. A program is linked when those before it pass."""
        for program, filter_ in programs:
            if self.build_programs([(program, filter_)])[0] != 0:
                return "does not compile", ""
            code, text = self.test(program, filter_, self.limits[(program, filter_)])
            if code is None:
                return "caught", f"{program} (hangs)"
            if code != 0:
                failed = re.search(r"\[  FAILED  \] ([\w./]+)", text)
                return "caught", f"{program} {failed.group(1)}" if failed else f"{program} (exit code {code})"
        return "survived", ""


def diff_of(mutation, original):
    name = mutation.path.relative_to(ROOT).as_posix()
    lines = difflib.unified_diff(original.splitlines(True), mutation.applied(original).splitlines(True),
                                 f"a/{name}", f"b/{name}", n=2)
    return "".join(lines)


def run_one(mutation, workspace, tests):
    """"does not compile", "caught" or "survived", by what, and the diff."""
    programs = tests.programs_for(mutation.path)
    original = workspace.apply(mutation)
    try:
        return *tests.verdict(programs), diff_of(mutation, original)
    finally:
        workspace.restore(mutation, original)


def summary_of(rows):
    lines = []
    modules = sorted({row["module"] for row in rows})
    kinds = sorted({row["kind"] for row in rows})
    for title, key, values in (("module", "module", modules), ("kind", "kind", kinds)):
        for value in values:
            of = [row for row in rows if row[key] == value]
            caught = sum(row["result"] == "caught" for row in of)
            lines.append(f"{title:8} {value:20} {caught:4} of {len(of):4} caught")
    caught = sum(row["result"] == "caught" for row in rows)
    if rows:
        lines.append(f"all      {'':20} {caught:4} of {len(rows):4} caught, {100.0 * caught / len(rows):.0f} %")
    return "\n".join(lines) + "\n"


def write_results(out, rows, survivors):
    out.mkdir(parents=True, exist_ok=True)
    with open(out / "mutations.csv", "w", newline="") as file:
        writer = csv.DictWriter(file, ["number", "module", "file", "line", "kind", "old", "new", "result", "caught_by",
                                       "seconds"])
        writer.writeheader()
        writer.writerows(rows)
    (out / "survivors.diff").write_text("\n".join(survivors))
    (out / "summary.txt").write_text(summary_of(rows))


def mutate(options):
    workspace, tests = Workspace(options.build), Tests(options)
    workspace.recover()
    drawer = Drawer(source_files(options.folders), options.seed)
    # By file: what is compiled to put one back is then compiled for the next one anyway.
    drawn = sorted(filter(None, (drawer.draw() for _ in range(options.count))), key=lambda m: (str(m.path), m.begin))
    if options.list:
        for m in drawn:
            line = m.path.read_text()[: m.begin].count("\n") + 1
            print(f"{m.path.relative_to(ROOT)}:{line}: {m.kind}: {' '.join(m.old.split())} -> {m.new}")
        return
    everything = sorted({p for m in drawn for p in tests.programs_for(m.path)})
    if tests.build_programs(everything)[0] != 0:
        sys.exit("mutate: the tree does not build as it stands")
    tests.baseline(everything)
    rows, survivors = [], []
    try:
        while drawn:
            mutation = drawn.pop(0)
            begin = time.monotonic()
            original = mutation.path.read_text()
            result, caught_by, diff = run_one(mutation, workspace, tests)
            line = original[: mutation.begin].count("\n") + 1
            where = f"{mutation.path.relative_to(ROOT)}:{line}"
            print(f"{len(rows) + 1:4} {result:16} {where}: {mutation.kind}: {' '.join(mutation.old.split())} -> "
                  f"{mutation.new}  {caught_by}", flush=True)
            if result == "does not compile":
                drawn[:0] = filter(None, [drawer.draw()])
                continue
            rows.append({"number": len(rows) + 1, "module": tests.module_of(mutation.path),
                         "file": str(mutation.path.relative_to(ROOT)), "line": line, "kind": mutation.kind,
                         "old": " ".join(mutation.old.split()), "new": mutation.new, "result": result,
                         "caught_by": caught_by, "seconds": f"{time.monotonic() - begin:.0f}"})
            survivors += [diff] if result == "survived" else []
            write_results(options.out, rows, survivors)
    finally:
        print(summary_of(rows), end="")
    # What lies in the build tree is to be of the sources as they are.
    tests.build_programs(everything)


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("folders", nargs="+", help="of src/rastro, such as slam/orb, or single sources below it")
    parser.add_argument("--count", type=int, default=20, help="mutations that compile (20)")
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--build", type=pathlib.Path, default=pathlib.Path("build/release"), help="build tree (build/release)")
    parser.add_argument("--out", type=pathlib.Path, default=pathlib.Path("mutations"), help="folder of the results")
    parser.add_argument("--jobs", type=int, default=2, help="compilers at once (2)")
    parser.add_argument("--tests", action="append", default=[], metavar="PROGRAM[=FILTER]", help="one more test program to run")
    parser.add_argument("--unit-only", action="store_true", help="run the module's own tests and those of its users alone")
    parser.add_argument("--accuracy", action="store_true", help="run the rows of tests/golden/accuracy.csv that fit, too")
    parser.add_argument("--prefix", default="", help="command put before every build and test")
    parser.add_argument("--list", action="store_true", help="show what is drawn, and do nothing")
    options = parser.parse_args()
    # As an exception, so that the source is put back.
    signal.signal(signal.SIGTERM, lambda *_: sys.exit(143))
    signal.signal(signal.SIGHUP, lambda *_: sys.exit(129))
    try:
        mutate(options)
    except KeyboardInterrupt:
        sys.exit(130)


if __name__ == "__main__":
    main()
