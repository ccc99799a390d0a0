#!/usr/bin/env bash
# SPDX-License-Identifier: Apache-2.0
# Map files as a user meets them: map_test.sh PROGRAM SCRATCH_FOLDER CASE [--twenty]
# CASE is make_room (first), files, landmarks, places, view, kill, kill_locations or kill_landmarks: a run killed with -9 at three moments (twenty with --twenty) leaves a
# map that opens and has all but the last second; a map of landmarks, which is written whole, all but the last two; one of locations all but the last location.
set -euo pipefail
rastro=$1
scratch=$2
case_name=$3
kills=3
[[ ${4:-} == --twenty ]] && kills=20
room=$scratch/room
here=$scratch/$case_name
rm -rf "$here" && mkdir -p "$here"

fail() {
  echo "FAILED: $*" >&2
  exit 1
}

# run CODE ARGUMENTS...: as in cli_test.sh.
run() {
  local wanted=$1 code=0
  shift
  "$rastro" "$@" >"$here/stdout" 2>"$here/stderr" || code=$?
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

make_room() {
  rm -rf "$room"
  run 0 simulate bedroom --out "$room" --frames 24
}

files() {
  local map=$here/run/map.rastro
  run 0 slam "$room" --method rgbd --out "$here/run" --max-memory 2GB --set keyframe_frames=4
  said 'map.rastro'
  local file
  for file in map.rastro cloud.ply map.png trajectory.txt result.json; do
    [[ -s $here/run/$file ]] || fail "$file is missing"
  done
  [[ $(cat "$here/run/trajectory.txt" "$map" | sha256sum | cut -d' ' -f1) == $(value_of result_sha256 "$here/run/result.json") ]] ||
    fail "the hash is not that of trajectory and map"
  run 0 slam "$room" --method rgbd --out "$here/step" --mode step --threads 1 --set keyframe_frames=4 --quiet
  cmp "$map" "$here/step/map.rastro" || fail "another map with one thread, one step after the other"
  run 2 localize "$room" --map "$map" --out "$here/run" --force --quiet
  said 'would be overwritten'
  (cd "$here/run" && run 2 localize "$room" --map map.rastro --out . --force --quiet)
  said 'would be overwritten'
  ln -s "$map" "$here/link.rastro"
  run 2 localize "$room" --map "$here/link.rastro" --out "$here/run" --force --quiet
  said 'would be overwritten'
  [[ -s $map ]] || fail "localize removed the map that it should localize in"
  touch "$here/file"
  refused 'cannot be made' measure "$here/run" --between -0.3,0.05,2.1 -0.05,0.02,2.1 --out "$here/file/images"
  run 0 measure "$here/run" --objects "$room/objects.yaml" --only 'blue box width' --only 'blue box height' \
    --out "$here/images" --require 'measured>=1' --require 'max_error_m<=0.015'
  said 'blue box width'
  [[ $(find "$here/images" -name '*.png' | wc -l) -eq 2 ]] || fail "no image of each length"
  run 0 measure "$here/run" "$here/run/map.rastro" --between -0.3,0.05,2.1 -0.05,0.02,2.1 --csv
  [[ $(wc -l <"$here/stdout") -eq 3 ]] || fail "a line for each of two maps"
  refused "did you mean 'blue box width'?" measure "$here/run" --objects "$room/objects.yaml" --only 'blue bx width'
  refused 'give --objects FILE or --between' measure "$here/run"
  run 0 info "$here/run"
  said 'complete, every checksum is valid'
  run 0 localize "$room" --map "$here/run" --out "$here/found" --every 3 --require 'recall>=60'
  [[ -s $here/found/trajectory.txt && ! -e $here/found/map.rastro ]] || fail "localize leaves a trajectory and no map"

  head -c $(($(stat -c %s "$map") / 2)) "$map" >"$here/cut.rastro"
  run 2 info "$here/cut.rastro"
  said 'damaged'
  [[ $(wc -l <"$here/stderr") -eq 1 ]] || fail "a damaged map is one line: $(cat "$here/stderr")"
  refused 'rastro recover' localize "$room" --map "$here/cut.rastro" --out "$here/no"
  run 0 recover "$here/cut.rastro" --out "$here/saved.rastro"
  said 'lost'
  run 0 info "$here/saved.rastro"
  said 'complete'
  head -c 12288 "$map" >"$here/head.rastro"
  refused 'nothing to recover' recover "$here/head.rastro" --out "$here/none.rastro"
  [[ ! -e $here/none.rastro ]] || fail "an empty map is written"
  run 0 recover "$map" --out "$here/again.rastro"
  said 'nothing'
  cmp "$map" "$here/again.rastro" || fail "read and written again, the map has other bytes"

  mkdir -p "$here/broken/depth"
  cp -r "$room"/*.txt "$room"/*.yaml "$room/rgb" "$here/broken"
  for file in "$room"/depth/*; do : >"$here/broken/depth/$(basename "$file")"; done
  echo kept >"$here/scans.log"
  run 2 convert "$here/broken" --to scan --out "$here/scans.log" --quiet
  [[ $(<"$here/scans.log") == kept ]] || fail "a conversion without a scan emptied an existing file"

  refused 'already exists' recover "$map" --out "$here/saved.rastro"
  refused 'not a map of rastro' localize "$room" --map "$room/rgb.txt" --out "$here/no"
  refused "did you mean 600MB" slam "$room" --method rgbd --out "$here/no" --max-memory 600mb
  refused "did you mean 'step'" slam "$room" --method rgbd --out "$here/no" --mode stp
  [[ ! -e $here/no ]] || fail "a refused run left a folder"
  refused '--max-memory' slam "$room" --method rgbd --out "$here/small" --max-memory 20MB
}

landmarks() {
  local map=$here/run/map.rastro file
  run 0 slam "$room" --method orb --sensor rgbd --out "$here/run"
  said 'scale        meters'
  for file in map.rastro map.png keyframes.txt trajectory.txt trajectory_online.txt result.json; do
    [[ -s $here/run/$file ]] || fail "$file is missing"
  done
  [[ $(cat "$here/run/trajectory.txt" "$here/run/keyframes.txt" "$map" | sha256sum | cut -d' ' -f1) == $(value_of result_sha256 "$here/run/result.json") ]] ||
    fail "the hash is not that of trajectory, keyframes and map"
  run 0 info "$here/run"
  said 'complete, every checksum is valid'
  run 0 localize "$room" --map "$here/run" --out "$here/found" --require 'recall>=60'
  [[ -s $here/found/trajectory.txt && ! -e $here/found/map.rastro ]] || fail "localize leaves a trajectory and no map"
  run 2 slam "$room" --map "$here/run" --continue --out "$here/run" --force --quiet
  said 'would be overwritten'
  [[ -s $map ]] || fail "a map was removed by the run that should continue it"
  run 0 slam "$room" --map "$here/run" --continue --out "$here/longer" --quiet
  run 0 info "$here/longer"
  said 'complete'
  run 0 recover "$map" --out "$here/again.rastro"
  cmp "$map" "$here/again.rastro" || fail "read and written again, the map has other bytes"
  for file in points.ply landmarks.csv graph.g2o above.svg above.png poses.tum; do
    local kind=${file##*.}
    [[ $kind == csv ]] && kind=landmarks
    run 0 export "$here/run" --to "$kind" --out "$here/$file"
    [[ -s $here/$file ]] || fail "$file is missing"
  done
  run 0 export "$here/run" --to mcap --out "$here/run.mcap"
  said '/camera/image'
  [[ ! -e $here/run.mcap.images ]] || fail "images of the recording were left beside the file"
  run 0 export "$map" --to colmap-binary --out "$here/colmap"
  [[ -s $here/colmap/points3D.bin ]] || fail "no points3D.bin"
  refused '--submap all' export "$map" --to tum --submap all --out "$here/no"
  cp "$map" "$here/alone.rastro"
  refused "no layer 'images'" measure "$here/alone.rastro" --between 0,0,1 0,0,2
  run 0 measure "$here/alone.rastro" --images "$room" --objects "$room/objects.yaml" --only 'blue box width' --require 'max_error_m<=0.01'
  run 0 measure "$here/run" --objects "$room/objects.yaml" --only 'blue box width' --require 'measured>=1'
  refused "no layer 'images'" export "$here/run" --to mesh --out "$here/no"
  refused 'is metric already' scale "$here/run" --camera-height 1
  # What is made without --method can be used with a depth camera, or one without depth.
  run 0 slam "$room" --out "$here/chosen"
  said 'fusion: a depth camera'
  run 0 localize "$room" --map "$here/chosen" --out "$here/chosen_found" --require 'recall>=60'
  cp -r "$room" "$here/gray"
  rm -r "$here/gray/depth" "$here/gray/depth.txt"
  run 0 localize "$here/gray" --map "$here/chosen" --out "$here/chosen_gray"
  refused 'only localizes in its maps' slam "$here/gray" --method fusion --out "$here/no"
  refused 'use '"'"'rastro localize' slam "$room" --method orb --map "$map" --out "$here/no"
  refused 'give --map' slam "$room" --method orb --continue --out "$here/no"
  [[ ! -e $here/no ]] || fail "a refused run left a folder"
  mono
  overlap
}

# A map of one camera, brought to meters twice: the second time it is there already.
mono() {
  run 0 slam "$room" --method orb --sensor mono --out "$here/mono"
  said 'scale        arbitrary'
  run 0 evaluate trajectory "$room" "$here/mono"
  grep -q 'in arbitrary units' "$here/stderr" || fail "the wrong alignment is not told"
  run 0 evaluate trajectory "$room" "$here/mono/trajectory_online.txt"
  grep -q 'in arbitrary units' "$here/stderr" || fail "the wrong alignment of the first estimates is not told"
  mkdir "$here/metric"
  cp "$here/mono/trajectory_online.txt" "$here/metric"
  sed 's/arbitrary units/meters/' "$here/mono/trajectory.txt" > "$here/metric/trajectory.txt"
  run 0 evaluate trajectory "$room" "$here/metric/trajectory_online.txt"
  [[ ! -s $here/stderr ]] || fail "meters are taken for arbitrary units: $(cat "$here/stderr")"
  run 0 evaluate trajectory "$room" "$here/mono" --align sim3
  [[ ! -s $here/stderr ]] || fail "warned of the right alignment: $(cat "$here/stderr")"
  refused 'give one of' scale "$here/mono"
  refused 'is not a length' scale "$here/mono" --length 1,2
  refused 'has no landmark' scale "$here/mono" --length 1,987654321,2
  refused 'name a known length with --known' measure "$here/mono" --objects "$room/objects.yaml"
  refused "did you mean 'blue box width'?" measure "$here/mono" --objects "$room/objects.yaml" --known 'blue bx'
  echo '{"maps": [{"lengths": []}]}' >"$here/mono/lengths.json"
  run 0 scale "$here/mono" --reference "$room"
  [[ ! -e $here/mono/lengths.json && -s $here/mono/lengths_before_scale.json ]] || fail "lengths of another unit stay with the map"
  run 0 scale "$here/mono" --reference "$room" --json
  grep -Eq '"meters_per_unit": (1|0.99999|1.00000)[0-9]*,$' "$here/stdout" || fail "not in meters: $(cat "$here/stdout")"
  cp -r "$here/mono" "$here/mono_again"
  run 0 scale "$here/mono_again/map.rastro" --length f0,f15,100
  grep -q 'was in meters already, by a reference trajectory' "$here/stderr" || fail "the contradiction is not told"
  cmp -s "$here/mono/trajectory.txt" "$here/mono_again/trajectory.txt" && fail "the run of a scaled map file stays as it was"
  run 0 info "$here/mono"
  said 'meters, from a reference trajectory'
  run 0 evaluate trajectory "$room" "$here/mono" --align se3 --require 'ate_rmse<=0.1'
  run 0 measure "$here/mono" --objects "$room/objects.yaml" --known 'blue box height' --only 'blue box width' --require 'max_error_percent<=10'
  ! grep -q 'blue box height' "$here/stdout" || fail "the known length is no result"
}

# A second recording whose clock begins where that of the first does: their poses are not merged by their stamps.
overlap() {
  run 0 slam "$room" --method orb --sensor mono --out "$here/first" --quiet
  cp -r "$room" "$here/again"
  run 0 slam "$here/again" --sensor mono --map "$here/first" --continue --out "$here/both" --quiet
  run 0 info "$here/both" --json
  local all last
  all=$(value_of poses "$here/stdout")
  run 0 export "$here/both/map.rastro" --to tum --out "$here/last.tum"
  said 'overlap in time'
  last=$(grep -cv '^#' "$here/last.tum")
  ((last < all)) || fail "$last of $all poses are exported: those of one session"
  [[ $last -eq $(grep -cv '^#' "$here/both/trajectory.txt") ]] || fail "they are not those of the run"
  sort -c -g "$here/last.tum" || fail "the stamps go back"
  cp "$room/groundtruth.txt" "$here/elsewhere.txt"
  refused 'of the recording of no session' scale "$here/both" --reference "$here/elsewhere.txt"
  run 0 scale "$here/both" --reference "$room"
}

# The recording of the room there and back again, for minutes.
long_room() {
  local kind
  mkdir -p "$here/long"
  cp "$room"/*.yaml "$here/long" 2>/dev/null || true
  for kind in rgb depth; do
    ln -s "$room/$kind" "$here/long/$kind"
    grep -v '^#' "$room/$kind.txt" | awk '{ name[NR - 1] = $2 }
      END { n = NR; for (i = 0; i < 6000; i++) { k = i % (2 * n - 2); if (k >= n) k = 2 * n - 2 - k; printf "%.6f %s\n", 1000 + i / 30, name[k] } }' >"$here/long/$kind.txt"
  done
}

lines() { if [[ -f $1 ]]; then wc -l <"$1"; else echo 0; fi; }

# Lets it run for a while, kills it, and checks what is left against what there was a second before.
kill_one() {
  local number=$1 run=$here/run$1 process before=0 tenth back=10
  shift
  [[ $2 == orb ]] && back=20
  local -a history=()
  "$rastro" slam "$here/long" "$@" --out "$run" --quiet 2>"$here/stderr" &
  process=$!
  while [[ $(lines "$run/trajectory_online.txt") -lt 8 ]]; do
    kill -0 $process 2>/dev/null || fail "the run ended before it could be killed: $(cat "$here/stderr")"
    read -r -t 0.05 <> <(:) || true
  done
  for ((tenth = 0; tenth < back + 1 + RANDOM % 20; tenth++)); do
    history+=("$(lines "$run/trajectory_online.txt")")
    read -r -t 0.1 <> <(:) || true
  done
  kill -9 $process
  wait $process 2>/dev/null || true
  ((${#history[@]} >= back)) && before=$((history[${#history[@]} - back] - 2))
  run 0 info "$run" --json
  [[ $(value_of damage "$here/stdout") == '' ]] || fail "kill $number: $(cat "$here/stdout")"
  local kept
  kept=$(value_of poses "$here/stdout")
  ((kept >= before)) || fail "kill $number: $kept poses are left, and $((back / 10)) s before there were $before"
  local made keyframes
  made=$(grep -c '"event":"keyframe"' "$run/events.jsonl")
  keyframes=$(value_of keyframes "$here/stdout")
  [[ $case_name != kill_locations ]] || ((made - keyframes <= 1)) || fail "kill $number: $keyframes of $made locations are left"
  [[ ! -s $run/map.rastro-wal || $(value_of log_bytes "$here/stdout") -gt 0 ]] || fail "kill $number: the log is not told"
  run 0 recover "$run" --out "$here/saved$number.rastro"
  run 0 export "$run" --to tum --out "$here/killed$number.txt"
  [[ $(grep -cv '^#' "$here/killed$number.txt") -eq $kept ]] || fail "kill $number: not every pose of the map is exported"
  echo "kill $number: $kept poses, $((back / 10)) s before $before; $keyframes of $made keyframes"
}

places() {
  local run=$here/run
  run 0 slam "$room" --method rtabmap --out "$run" --set keyframe_frames=2
  said 'places.png'
  [[ -s $run/places.png ]] || fail "places.png is missing"
  run 0 slam "$room" --method rtabmap --out "$here/step" --mode step --threads 1 --set keyframe_frames=2 --quiet
  cmp "$run/places.png" "$here/step/places.png" || fail "other beliefs with one thread, one step after the other"
  cp "$run/map.rastro" "$here/alone.rastro"
  run 0 export "$here/alone.rastro" --to word-images --out "$here/words" --json
  [[ $(find "$here/words" -name '*.jpg' | wc -l) -eq $(sed -n 's/^  "locations": \([0-9]*\).*/\1/p' "$here/stdout") ]] ||
    fail "not one picture for each location: $(cat "$here/stdout")"
  [[ -s $here/words/000000.jpg ]] || fail "the first keyframe is a location"
  run 0 export "$run" --to word-images --out "$here/again" --threads 1 --quiet
  cmp "$here/words/000000.jpg" "$here/again/000000.jpg" || fail "the picture depends on the threads"
  run 0 slam "$room" --method rgbd --out "$here/rgbd" --frames 0:4 --quiet
  [[ ! -e $here/rgbd/places.png ]] || fail "rgbd recognizes no places"
  refused "no layer 'signatures'" export "$here/rgbd" --to word-images --out "$here/no"
  refused '--method rtabmap' export "$here/rgbd" --to word-images --out "$here/no"
  refused "no layer 'semi_dense'" export "$here/rgbd" --to depth-images --out "$here/no"
  refused '--voxel' export "$run" --to word-images --voxel 0.1 --out "$here/no"
  [[ ! -e $here/no ]] || fail "a refused export left a folder"
}

# Ctrl-C leaves the cloud too, or says what makes it where that takes long.
interrupt_one() {
  local run=$here/stopped process
  "$rastro" slam "$here/long" "$@" --out "$run" >"$here/stdout" 2>"$here/stderr" &
  process=$!
  while [[ $(lines "$run/trajectory_online.txt") -lt 8 ]]; do
    kill -0 $process 2>/dev/null || fail "the run ended before it could be interrupted: $(cat "$here/stderr")"
    read -r -t 0.05 <> <(:) || true
  done
  kill -INT $process
  wait $process || fail "Ctrl-C: $(cat "$here/stderr")"
  [[ -s $run/cloud.ply ]] || said 'rastro export'
}
kill_runs() {
  local number
  RANDOM=7
  long_room
  for ((number = 1; number <= kills; number++)); do kill_one $number "$@"; done
}

# fetch PATH [HOST]: status and the first bytes of what the server gives.
fetch() {
  exec 3<>"/dev/tcp/127.0.0.1/$port"
  printf 'GET %s HTTP/1.1\r\nHost: %s\r\nConnection: close\r\n\r\n' "$1" "${2:-localhost}" >&3
  tr -d '\0' <&3 | head -c 3000
  exec 3>&-
}

view() {
  local begin
  run 0 slam "$room" --method rgbd --out "$here/run" --set keyframe_frames=4 --quiet
  run 0 export "$here/run" --to html --out "$here/room.html"
  said 'bytes'
  grep -qF 'class="rastro-scene" data-name="run"' "$here/room.html" || fail "the page has no scene"
  run 0 export "$here/run/map.rastro" --to html --out "$here/map.html" --points 1000 --mesh --octree
  [[ $(wc -c <"$here/map.html") -lt $(wc -c <"$here/room.html") ]] || fail "a thinned page is as large"
  (cd "$here" && run 0 export run --to html --threads 1 --quiet)
  cmp "$here/room.html" "$here/run.html" || fail "another page with one thread"
  run 0 export "$here/run/trajectory.txt" --to html --out "$here/poses.html"
  run 0 export "$here/run" --to mcap --out "$here/room.mcap"
  said '/trajectory'
  [[ $(head -c 6 "$here/room.mcap" | tail -c 5) == MCAP0 ]] || fail "no MCAP file"
  (cd "$here" && run 0 export run --to mcap --threads 1 --quiet)
  cmp "$here/room.mcap" "$here/run.mcap" || fail "another MCAP file with one thread"
  run 0 export "$here/run/trajectory.txt" --to mcap --out "$here/poses.mcap"
  refused '--images' export "$here/run" --to mcap --images "$here" --out "$here/no"
  refused '--out' export "$here/run" --to ply
  refused '--points' export "$here/run" --to html --points 0 --out "$here/no"
  refused '--mesh' export "$here/run" --to ply --mesh --out "$here/no"
  refused '--token' view "$here/run" --listen 0.0.0.0 --token 'a b'
  refused 'is not an address' view "$here/run" --listen here
  refused '--port' view "$here/run" --port 70000
  refused 'no such file or folder' view "$here/none"
  sed -i '3s/,.*/,cut/' "$here/run/stats.csv"
  refused 'stats.csv:3' view "$here/run"
  "$rastro" view "$here/run/map.rastro" "$here/run/trajectory.txt" --port 0 --token s3cret >"$here/address" 2>"$here/stderr" &
  local process=$!
  for ((begin = SECONDS; SECONDS - begin < 60; )); do
    [[ -s $here/address ]] && break
    sleep 0.1
  done
  local port
  port=$(sed -n 's|^http://127.0.0.1:\([0-9]*\)/?token=s3cret$|\1|p' "$here/address")
  [[ -n $port ]] || fail "no address was printed: $(cat "$here/address" "$here/stderr")"
  fetch '/?token=s3cret' | grep -qF 'HTTP/1.1 200 OK' || fail "no page"
  fetch '/api/scenes?token=s3cret' | grep -qF '"index":1,"name":"run"' || fail "no list of scenes"
  fetch '/api/scene/0?token=s3cret' | grep -qF '"format":"rastro-scene"' || fail "no scene"
  fetch /api/scenes | grep -qF 'HTTP/1.1 401' || fail "no token was asked for"
  fetch '/?token=s3cret' evil.example | grep -qF 'HTTP/1.1 403' || fail "another host was served"
  fetch '/../../etc/passwd?token=s3cret' | grep -qF 'HTTP/1.1 404' || fail "another path was served"
  begin=$SECONDS
  kill -INT $process
  wait $process || fail "ended with $? after Ctrl-C"
  ((SECONDS - begin <= 2)) || fail "it took $((SECONDS - begin)) s to stop"
}

case $case_name in
  make_room | files | landmarks | places | view) $case_name ;;
  kill)
    kill_runs --method rgbd
    interrupt_one --method rgbd
    ;;
  kill_locations) kill_runs --method rtabmap --set keyframe_frames=20 ;;
  kill_landmarks) kill_runs --method orb --sensor rgbd ;;
  *) fail "no case '$case_name'" ;;
esac
