#!/usr/bin/env bash
# SPDX-License-Identifier: Apache-2.0
# What the program does at its limits: limits_test.sh PROGRAM SCRATCH_FOLDER CASE
# Needs the hall of cli_test.sh's make_hall.
set -euo pipefail
rastro=$1
scratch=$2
case_name=$3
hall=$scratch/hall
here=$scratch/limits_$case_name
rm -rf "$here" && mkdir -p "$here"

fail() {
  echo "FAILED: $*" >&2
  exit 1
}

# run CODE ARGUMENTS...: as in cli_test.sh, and within 10 s: a wait on a FIFO never ends.
run() {
  local wanted=$1 code=0
  shift
  timeout -s KILL 10 "$rastro" "$@" >"$here/stdout" 2>"$here/stderr" || code=$?
  [[ $code -eq $wanted ]] || fail "'rastro $*' ended with $code, not $wanted: $(cat "$here/stderr")"
}

refused() {
  local text=$1
  shift
  run 2 "$@"
  [[ $(wc -l <"$here/stderr") -eq 1 ]] || fail "'rastro $*' should say one line: $(cat "$here/stderr")"
  grep -qF -- "$text" "$here/stderr" || fail "'rastro $*' should say '$text': $(cat "$here/stderr")"
}

said() { grep -qF -- "$1" "$here/stdout" "$here/stderr" || fail "'$1' was not said: $(cat "$here/stdout" "$here/stderr")"; }
value_of() { sed -n "s/^  \"$1\": \"\{0,1\}\([^\",]*\).*/\1/p" "$2"; }
pause() { read -r -t "$1" <> <(:) || true; }

# An address sanitizer reserves terabytes: it cannot run below a limit.
has_sanitizer() { ldd "$rastro" | grep -q 'lib[at]san'; }

threads() {
  has_sanitizer && return
  (ulimit -v 3000000 && run 0 track "$hall" --out "$here/few" --frames 0:3 --threads 1000)
  said 'of 1000 threads are used'
  (ulimit -v 3000000 && run 0 slam "$hall" --method orb --out "$here/slam" --frames 0:3 --threads 1000)
  (ulimit -v 1500000 && run 0 track "$hall" --out "$here/fewer" --frames 0:3 --threads 64)
  cmp "$here/few/tracks.csv" "$here/fewer/tracks.csv" || fail "the result depends on the threads"
}

# Every place that takes a file, with something that is none.
special() {
  local map=$here/run text=$here/poses.txt what
  printf '%s 0 0 0 0 0 0 1\n' 1 2 3 >"$text"
  run 0 slam "$hall" --method orb --out "$here/run" --frames 0:6
  mkfifo "$here/fifo" "$here/fifo.png" "$here/fifo.yaml" "$here/fifo.rastro" "$here/fifo.log" "$here/fifo.mp4" "$here/fifo.bag"
  for what in fifo fifo.png fifo.log fifo.mp4 fifo.bag; do
    for command in info check; do refused "$what" $command "$here/$what"; done
    refused "$what" track "$here/$what" --out "$here/no"
  done
  mkdir "$here/images" && ln -s "$here/fifo.png" "$here/images/0.png"
  refused '0.png' track "$here/images" --out "$here/no"
  for what in "$here/fifo.yaml" /dev/zero /dev/null "$here"; do
    refused "$what" slam "$hall" --method orb --calibration "$what" --out "$here/no"
    refused "$what" track "$hall" --options "$what" --out "$here/no"
    refused "$what" track "$hall" --mask "$what" --out "$here/no"
    refused "$what" odometry "$hall" --scale "reference=$what" --out "$here/no"
    refused "$what" evaluate trajectory "$what" "$text"
    refused "$what" evaluate trajectory "$text" "$what"
    refused "$what" evaluate relations "$here/run" --relations "$what"
    refused "$what" measure "$map" --objects "$what"
    refused "$what" scale "$map" --reference "$what"
    refused "$what" localize "$hall" --map "$what" --out "$here/no"
    refused "$what" recover "$what" --out "$here/no"
    refused "$what" export "$what" --to g2o --out "$here/no"
  done
  refused 'fifo.rastro' info "$here/fifo.rastro"
  refused '/dev/zero' info /dev/zero
  refused '/dev/zero' track /dev/zero --out "$here/no"
  [[ ! -e $here/no ]] || fail "a refused run left something"
}

# A PNG of 20000x20000 black pixels.
huge_png() {
  python3 - "$1" <<'END'
import struct, sys, zlib
def chunk(kind, data):
    return struct.pack('>I', len(data)) + kind + data + struct.pack('>I', zlib.crc32(kind + data))
side = 20000
packer = zlib.compressobj(1)
rows = b''.join(packer.compress(bytes(side + 1)) for _ in range(side)) + packer.flush()
head = struct.pack('>IIBBBBB', side, side, 8, 0, 0, 0, 0)
open(sys.argv[1], 'wb').write(b'\x89PNG\r\n\x1a\n' + chunk(b'IHDR', head) + chunk(b'IDAT', rows) + chunk(b'IEND', b''))
END
}

large() {
  local what
  for what in big.yaml big.png big.txt big.rastro; do truncate -s 8G "$here/$what"; done
  refused 'big.yaml' track "$hall" --calibration "$here/big.yaml" --out "$here/no"
  refused 'big.yaml' track "$hall" --options "$here/big.yaml" --out "$here/no"
  refused 'big.png' track "$here/big.png" --out "$here/no"
  refused 'big.png' track "$hall" --mask "$here/big.png" --out "$here/no"
  refused 'big.txt' evaluate trajectory "$here/big.txt" "$here/big.txt"
  refused 'big.rastro' localize "$hall" --map "$here/big.rastro" --out "$here/no"
  refused 'big.rastro' recover "$here/big.rastro" --out "$here/no"
  run 2 info "$here/big.txt"
  huge_png "$here/huge.png"
  refused 'claims 20000x20000 pixels' track "$here/huge.png" --out "$here/no"
  refused 'claims 20000x20000 pixels' track "$hall" --mask "$here/huge.png" --out "$here/no"
  run 2 vocabulary "$here/huge.png" --out "$here/no"
  said 'claims 20000x20000 pixels'
  run 2 check "$here/huge.png"
  said 'claims 20000x20000 pixels'
  [[ ! -e $here/no ]] || fail "a refused run left something"
}

# Libraries print nothing, and whatever is unusable is one line on standard error.
quiet() {
  mkdir "$here/data"
  cp "$hall"/mav0/cam0/data/*.png "$here/data"
  local victim
  victim=$(ls "$here"/data/*.png | sed -n 4p)
  printf '\xff\xff\xff\xff' | dd of="$victim" bs=1 seek=20000 conv=notrunc status=none
  run 0 track "$here/data" --out "$here/run" --quiet
  [[ ! -s $here/stderr ]] || fail "--quiet is not: $(cat "$here/stderr")"
  run 0 check "$here/data"
  ! grep -q libpng "$here/stderr" || fail "libpng prints: $(cat "$here/stderr")"
  mkdir "$here/broken" && cp "$victim" "$here/broken/0.png"
  refused 'unusable: no frame can be read' check "$here/broken"
  refused 'unusable: no frame can be read' check "$here/broken" --json --quiet
  refused '--out=: has no value' track "$hall" --out= --quiet
  refused '--out=: has no value' slam "$hall" --method orb --out= --quiet
  refused '--out=: has no value' simulate hall --out= --quiet
  refused '--options=: has no value' track "$hall" --out "$here/no" --options= --quiet
  refused 'no folder given' track "$hall" --out '' --quiet
  refused "unknown option 'intrinsics'" track "$hall" --out "$here/no" --set intrinsics=3
  ! grep -q 'did you mean' "$here/stderr" || fail "a far name is suggested: $(cat "$here/stderr")"
  printf 'sensor_type: camera\ncomment: none\nresolution: [752, 480]\ncamera_model: pinhole\n' >"$here/camera.yaml"
  refused "no key 'intrinsics'" info "$hall" --calibration "$here/camera.yaml"
  ! grep -q 'did you mean' "$here/stderr" || fail "a far name is suggested: $(cat "$here/stderr")"
  refused '1 .. 254' slam "$hall" --method orb --out "$here/no" --set fast_threshold=255
  run 0 slam "$hall" --method orb --out "$here/slam" --set fast_threshold=254 --frames 0:3 --quiet
}

sensor() {
  run 0 slam "$hall" --method orb --out "$here/run"
  run 0 localize "$hall" --map "$here/run" --sensor mono --out "$here/found"
  said 'localized'
  run 2 localize "$hall" --map "$here/run" --sensor stereo --out "$here/no"
}

laser() {
  run 0 simulate corridor --out "$here/corridor" --frames 30 --quiet
  { printf '\xef\xbb\xbf'; sed '20s/ /\x01/' "$here/corridor/scans.log"; } >"$here/a.log"
  run 0 info "$here/a.log"
  said '1 damaged lines with control characters are skipped'
  run 0 slam "$here/a.log" --method hector --out "$here/run"
  said 'hector: 29 frames'
}

# starts the program in the background; then wait_for FILE LINES, and stop SIGNAL...: sends the signals and wants the end within 2 s (5 with a sanitizer)
start() {
  "$rastro" "$@" >"$here/stdout" 2>"$here/stderr" &
  process=$!
}
wait_for() {
  until [[ -f $1 && $(wc -l <"$1") -ge $2 ]]; do
    kill -0 $process 2>/dev/null || fail "it ended before it could be stopped: $(cat "$here/stderr")"
    pause 0.05
  done
}
stop() {
  local code=0 signal begin=$EPOCHREALTIME most=2000000
  has_sanitizer && most=20000000
  for signal in "$@"; do
    kill "-$signal" $process 2>/dev/null || true
    pause 0.1
  done
  wait $process || code=$?
  [[ $code -eq 0 ]] || fail "$* ended it with $code: $(cat "$here/stderr")"
  local took=$((${EPOCHREALTIME/./} - ${begin/./}))
  ((took < most)) || fail "it took $took us to end"
}

interrupt() {
  run 0 simulate corridor --out "$here/office" --quiet
  start slam "$here/office" --method hector --out "$here/hector"
  wait_for "$here/hector/trajectory_online.txt" 100
  stop INT INT
  [[ $(value_of interrupted "$here/hector/result.json") == true ]] || fail "result.json does not say it"
  [[ -s $here/hector/map.rastro && -s $here/hector/trajectory.txt ]] || fail "not all is saved"

  start simulate hall --frames 100000 --no-ground-truth --out "$here/long"
  wait_for "$here/long/mav0/cam0/data.csv" 17
  stop HUP
  said 'interrupted: '
  run 0 check "$here/long"

  start occlude "$here/long/mav0/cam0/data" --out "$here/occluded"
  wait_for "$here/occluded/mav0/cam0/data.csv" 17
  stop INT INT
  run 0 check "$here/occluded"

  for _ in $(seq 1 40); do grep -v '^#' "$here/office/scans.log"; done >"$here/long.log"
  start convert "$here/long.log" --to scan --out "$here/converted.log"
  wait_for "$here/converted.log" 100
  stop TERM
  said 'interrupted: '
  run 0 check "$here/converted.log" --frames 0:50
}

lock() {
  start simulate hall --frames 100000 --no-ground-truth --out "$here/long"
  wait_for "$here/long/mav0/cam0/data.csv" 17
  refused 'another run is writing to this folder' simulate hall --frames 3 --out "$here/long" --force
  stop INT
  local number=0 image
  mkdir "$here/data"
  for _ in $(seq 1 200); do
    for image in "$hall"/mav0/cam0/data/*.png; do
      ln -s "$image" "$here/data/$(printf '%06d' $number).png"
      number=$((number + 1))
    done
  done
  start track "$here/data" --out "$here/run"
  wait_for "$here/run/tracks.jsonl" 3
  refused 'another run is writing to this folder' track "$hall" --out "$here/run" --force
  refused 'another run is writing to this folder' slam "$hall" --method orb --out "$here/run" --force
  stop INT
  [[ $(value_of interrupted "$here/run/result.json") == true ]] || fail "the first run was disturbed"
  run 0 track "$hall" --out "$here/run" --force --frames 0:2
}

"$case_name"
echo "passed"
