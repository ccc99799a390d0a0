#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Runs every command on generated inputs that were broken in one place: broken_inputs.py PROGRAM WORK_FOLDER [--count N] [--seed S]

Each must end with exit code 0, 1 or 2, within 10 s, with at most two lines on standard error. A failure names the number of its
input; --only NUMBER repeats it and keeps its files. ctest runs 48; before a release: --count 5000."""
import argparse
import os
import random
import re
import shutil
import signal
import subprocess
import sys
import time
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

LONGEST_S = 10.0
MOST_LINES = 2
NUMBERS = [b"nan", b"inf", b"-1", b"0", b"1e308", b"1e-320", b"99999999999999999999", b"2147483648", b"-9223372036854775808", b"", b"x"]

# What is broken, relative to the folder of originals: a file or folder. Then the commands run on it: {in} is the broken copy,
# {out} a new path, other names in braces are originals.
CASES = [
    ("euroc", ["info {in}", "check {in}", "track {in} --out {out}", "odometry {in} --out {out}", "slam {in} --method orb --out {out}",
               "localize {in} --map {mono} --out {out}", "occlude {in} --out {out}", "vocabulary {in} --depth 2 --out {out}",
               "evaluate trajectory {in} {mono}", "evaluate tracks {tracks} --ground-truth {in}",
               "slam {in} --map {mono} --continue --out {out}", "odometry {in} --method profiles --out {out}",
               "slam {in} --method lsd --out {out}", "slam {in} --out {out}", "slam replay:{in} --method orb --out {out}",
               "record replay:{in} --out {out}", "odometry {in} --method classic --out {out}", "odometry {in} --method hybrid --out {out}",
               "calibrate {in}/mav0/cam0/data --board chessboard:9x6:0.025 --out {out}", "compare {in} --methods odometry/profiles --out {out}"]),
    ("kitti", ["info {in}", "check {in}", "track {in} --out {out}", "odometry {in} --out {out}", "slam {in} --method orb --out {out}"]),
    ("kitti_raw/2014_06_24/2014_06_24_drive_0001_sync", ["info {in}", "check {in}", "track {in} --out {out}"]),
    ("tum", ["info {in}", "check {in}", "odometry {in} --method rgbd --out {out}", "slam {in} --method rgbd --out {out}",
             "slam {in} --method orb --out {out}", "slam {in} --method rtabmap --out {out}", "slam {in} --method lsd --out {out}",
             "localize {in} --map {rgbd} --out {out}", "convert {in} --to scan --out {out}", "slam {in} --out {out}",
             "slam {in} --method fusion --out {out}", "localize {in} --map {rtabmap} --out {out}", "localize {in} --map {fusion} --out {out}",
             "calibrate {in} --board chessboard:9x6:0.06 --depth --out {out}"]),
    ("corridor", ["info {in}", "check {in}", "slam {in} --method hector --out {out}", "slam {in} --method ekf --out {out}",
                  "convert {in} --to scan --out {out}", "slam {in}/landmarks.txt --method ekf --out {out}",
                  "evaluate relations {hector} --relations {in}/relations.txt", "evaluate map {hector} {in}/floor_plan.yaml"]),
    ("orb", ["info {in}", "recover {in} --out {out}", "localize {tum} --map {in} --out {out}", "export {in} --to g2o --out {out}",
             "export {in} --to colmap --out {out}", "export {in} --to landmarks --out {out}", "export {in} --to svg --out {out}",
             "export {in} --to html --out {out}", "export {in} --to mcap --out {out}",
             "export {in} --to tum --out {out}", "evaluate trajectory {tum} {in}", "slam {tum} --map {in} --continue --out {out}",
             "measure {in} --between 0,0,1,1,1,1"]),
    ("mono", ["scale {in} --length f2,f20,1.5", "scale {in} --camera-height 1.5", "export {in} --to ply --out {out}"]),
    ("rgbd", ["info {in}", "recover {in} --out {out}", "localize {tum} --map {in} --out {out}", "export {in} --to ply --out {out}",
              "export {in} --to mesh --out {out}", "export {in} --to html --out {out}", "export {in} --to mcap --out {out}",
              "evaluate cloud {in}/cloud.ply {rgbd}/cloud.ply"]),
    ("hector", ["info {in}", "recover {in} --out {out}", "export {in} --to pgm --out {out}", "export {in} --to ply --out {out}",
                "evaluate map {in} {corridor}/floor_plan.yaml"]),
    ("rtabmap", ["info {in}", "recover {in} --out {out}", "localize {tum} --map {in} --out {out}", "export {in} --to ply --out {out}",
                 "export {in} --to word-images --out {out}", "slam {tum} --map {in} --continue --out {out}"]),
    ("fusion", ["localize {tum} --map {in} --out {out}", "export {in} --to ply --out {out}", "slam {tum} --map {in} --continue --out {out}"]),
    ("lsd", ["info {in}", "recover {in} --out {out}", "export {in} --to ply --out {out}", "export {in} --to depth-images --out {out}",
             "export {in} --to html --out {out}", "export {in} --to depth-video --out {out}"]),
    ("tracks", ["evaluate tracks {in} --ground-truth {euroc}", "export {in} --to colmap --out {out}"]),
    ("orb/map.rastro", ["info {in}", "recover {in} --out {out}", "localize {tum} --map {in} --out {out}"]),
    ("rtabmap/map.rastro", ["info {in}", "recover {in} --out {out}", "localize {tum} --map {in} --out {out}"]),
    ("lsd/map.rastro", ["info {in}", "recover {in} --out {out}", "export {in} --to ply --out {out}"]),
    ("mono/map.rastro", ["recover {in} --out {out}", "localize {euroc} --map {in} --out {out}", "scale {in} --length 1,2,3"]),
    ("mono/trajectory.txt", ["evaluate trajectory {longer} {in}", "evaluate trajectory {in} {in}", "export {in} --to kitti --out {out}",
                            "odometry {euroc} --scale reference={in} --out {out}", "scale {mono_copy} --reference {in}"]),
    ("orb/options.yaml", ["slam {euroc} --method orb --options {in} --out {out}", "track {euroc} --options {in} --out {out}"]),
    ("euroc/mav0/cam0/sensor.yaml", ["info {euroc} --calibration {in}", "track {euroc} --calibration {in} --out {out}"]),
    ("kitti/calib.txt", ["info {euroc} --calibration {in}", "slam {kitti} --calibration {in} --method orb --out {out}"]),
    ("tum/camera.yaml", ["info {tum} --calibration {in}", "odometry {tum} --calibration {in} --method rgbd --out {out}"]),
    ("mask.png", ["track {euroc} --mask {in} --out {out}", "slam {euroc} --method orb --mask {in} --out {out}"]),
    ("list.yaml", ["benchmark {in} --out {out}", "compare {in} --out {out}"]),
    ("objects.yaml", ["measure {rgbd} --objects {in}"]),
]


def run(program, words):
    subprocess.run([program, *words.split(), "--quiet"], check=True)


def make_originals(program, folder):
    """Small ones, of every format and kind of map."""
    shutil.rmtree(folder, ignore_errors=True)
    folder.mkdir(parents=True)
    for name, frames in {"euroc": 4, "kitti": 3, "kitti-raw": 3, "tum": 4}.items():
        run(program, f"simulate hall --frames {frames} --format {name} --out {folder}/{name.replace('-', '_')}")
    run(program, f"simulate corridor --frames 25 --out {folder}/corridor")
    run(program, f"simulate hall --frames 24 --no-ground-truth --out {folder}/longer")  # as many as one camera needs for a map
    run(program, f"slam {folder}/longer --method orb --out {folder}/mono")
    run(program, f"slam {folder}/tum --method orb --out {folder}/orb")
    run(program, f"slam {folder}/tum --method rgbd --out {folder}/rgbd")
    run(program, f"slam {folder}/tum --method rtabmap --out {folder}/rtabmap")
    run(program, f"slam {folder}/tum --method fusion --out {folder}/fusion")
    run(program, f"slam {folder}/longer --method lsd --out {folder}/lsd")
    run(program, f"slam {folder}/corridor --method hector --out {folder}/hector")
    run(program, f"track {folder}/euroc --out {folder}/tracks")
    shutil.copy(next((folder / "euroc/mav0/cam0/data").iterdir()), folder / "mask.png")
    (folder / "list.yaml").write_text(f"entries:\n  - {{data: {folder}/euroc, command: odometry, method: profiles}}\n")
    (folder / "objects.yaml").write_text("objects:\n  - {name: box, a: [0, 0, 1], b: [1, 0, 1], length_m: 1}\n")


def copy(source, target):
    if source.is_dir():
        shutil.copytree(source, target)
    else:
        target.parent.mkdir(parents=True, exist_ok=True)
        shutil.copy(source, target)


def with_number(data, rng):
    places = list(re.finditer(rb"-?\d+(\.\d+)?(e[+-]?\d+)?", data[:100_000]))
    if not places:
        return data + b"1e308"
    place = rng.choice(places)
    return data[:place.start()] + rng.choice(NUMBERS) + data[place.end():]


def with_lines(data, rng):
    lines = data.split(b"\n")
    first, last = sorted(rng.randrange(len(lines)) for _ in range(2))
    return b"\n".join(rng.choice([lines[:first] + lines[last:], lines[:last] + lines[first:], lines[::-1], lines[:1] * 50 + lines]))


def with_flips(data, rng):
    data = bytearray(data)
    for _ in range(rng.choice([1, 1, 3, 30])):
        if data:
            data[rng.randrange(len(data))] ^= 1 << rng.randrange(8)
    return bytes(data)


def with_hole(data, rng):
    first, last = sorted(rng.randrange(len(data) + 1) for _ in range(2))
    return data[:first] + rng.choice([b"", bytes(last - first), rng.randbytes(last - first)]) + data[last:]


BREAKS = {
    "cut": lambda data, rng: data[:rng.randrange(len(data) + 1)],
    "flips": with_flips,
    "number": with_number,
    "lines": with_lines,
    "hole": with_hole,
    "empty": lambda data, rng: b"",
    "garbage": lambda data, rng: rng.randbytes(rng.choice([1, 100, 5000])),
    "zeros": lambda data, rng: bytes(rng.choice([1, 100, 1_000_000])),
    "mark": lambda data, rng: b"\xef\xbb\xbf" + data,
    "twice": lambda data, rng: data + data,
}


def break_one(victim, others, rng):
    """Replaces a file by a broken one, or by something that is no file; returns what was done."""
    kind = rng.choice([*BREAKS, *BREAKS, "swapped", "gone", "folder", "fifo", "link", "sparse"])
    data = victim.read_bytes()
    victim.unlink()
    if kind == "swapped":
        shutil.copy(rng.choice([other for other in others if other != victim]), victim)
    elif kind == "folder":
        victim.mkdir()
    elif kind == "fifo":
        os.mkfifo(victim)
    elif kind == "link":
        victim.symlink_to(rng.choice(["nowhere", victim.name, "/dev/zero", "/"]))
    elif kind == "sparse":
        with open(victim, "wb") as file:
            file.truncate(8 << 30)
    elif kind != "gone":
        victim.write_bytes(BREAKS[kind](data, rng))
    return kind


def words_of(command, paths):
    return [word.format(**paths) for word in command.split()]


def complaint(process, seconds, errors):
    if process is None:
        return f"was not over after {seconds:.0f} s"
    lines = [line for line in errors.splitlines() if line.strip()]
    if process.returncode not in (0, 1, 2):
        return f"ended with {process.returncode}: {' | '.join(lines[-3:])}"
    if len(lines) > MOST_LINES:
        return f"said {len(lines)} lines: {' | '.join(lines[:4])}"
    return "" if seconds <= LONGEST_S else f"took {seconds:.1f} s"


def try_input(program, originals, work, seed, number, keep):
    """The complaint about one input; empty if all is well."""
    rng = random.Random(f"{seed} {number}")
    name, commands = rng.choice(CASES)
    command = rng.choice(commands)
    here = work / f"input_{number}"
    shutil.rmtree(here, ignore_errors=True)
    broken = here / Path(name).name
    copy(originals / name, broken)
    files = [path for path in sorted(broken.rglob("*")) if path.is_file()] if broken.is_dir() else [broken]
    victim = rng.choice(files)
    kind = break_one(victim, files, rng) if len(files) > 1 else break_one(victim, [originals / "mask.png"], rng)
    paths = {path.name: str(path) for path in originals.iterdir() if path.is_dir()}
    if "{mono_copy}" in command:
        copy(originals / "mono", here / "mono_copy")
    paths |= {"in": str(broken), "out": str(here / "out"), "mono_copy": str(here / "mono_copy")}
    words = words_of(command, paths)
    begin = time.monotonic()
    with subprocess.Popen([program, *words], stdin=subprocess.DEVNULL, stdout=subprocess.DEVNULL, stderr=subprocess.PIPE) as process:
        try:
            errors = process.communicate(timeout=2 * LONGEST_S)[1].decode(errors="replace")
            ended = process
        except subprocess.TimeoutExpired:
            process.send_signal(signal.SIGKILL)
            ended, errors = None, ""
    found = complaint(ended, time.monotonic() - begin, errors)
    if not keep:
        shutil.rmtree(here, ignore_errors=True)
    return f"input {number} ({victim.name}: {kind}): rastro {' '.join(words)}: {found}" if found else ""


def main():
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("program", type=Path)
    parser.add_argument("work", type=Path)
    parser.add_argument("--count", type=int, default=100)
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--only", type=int)
    parser.add_argument("--jobs", type=int, default=os.cpu_count())
    options = parser.parse_args()
    program, work = str(options.program.resolve()), options.work.resolve()
    originals = work / "originals"
    make_originals(program, originals)
    numbers = range(options.count) if options.only is None else [options.only]
    with ThreadPoolExecutor(options.jobs) as pool:
        found = [line for line in pool.map(
            lambda number: try_input(program, originals, work, options.seed, number, options.only is not None), numbers) if line]
    print(*found, f"{len(numbers)} broken inputs, {len(found)} failures", sep="\n")
    return 1 if found else 0


if __name__ == "__main__":
    sys.exit(main())
