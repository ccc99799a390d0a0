#!/usr/bin/env bash
# SPDX-License-Identifier: Apache-2.0
# One case of the tests of the program: cli_test.sh PROGRAM SCRATCH_FOLDER CASE
set -euo pipefail
rastro=$1
scratch=$2
case_name=$3
hall=$scratch/hall
here=$scratch/$case_name

fail() {
  echo "FAILED: $*" >&2
  exit 1
}

# run CODE ARGUMENTS...: runs the program, checks its exit code, leaves its output in $here/stdout and $here/stderr.
run() {
  local wanted=$1 code=0
  shift
  "$rastro" "$@" >"$here/stdout" 2>"$here/stderr" || code=$?
  [[ $code -eq $wanted ]] || fail "'rastro $*' ended with $code, not $wanted: $(cat "$here/stderr")"
}

# refused TEXT ARGUMENTS...: exit code 2, nothing but one line on stderr, which holds TEXT.
refused() {
  local text=$1
  shift
  run 2 "$@"
  [[ $(wc -l <"$here/stderr") -eq 1 ]] || fail "'rastro $*' should say one line: $(cat "$here/stderr")"
  [[ ! -s $here/stdout ]] || fail "'rastro $*' should leave stdout empty: $(cat "$here/stdout")"
  grep -qF -- "$text" "$here/stderr" || fail "'rastro $*' should say '$text': $(cat "$here/stderr")"
}

said() { grep -qF -- "$1" "$here/stdout" "$here/stderr" || fail "'$1' was not said: $(cat "$here/stdout" "$here/stderr")"; }
value_of() { sed -n "s/^  \"$1\": \"\{0,1\}\([^\",]*\).*/\1/p" "$here/$2/result.json"; }
frames_of() { tail -n +2 "$here/$1/tracks.csv" | cut -d, -f1 | sort -un | wc -l; }
fresh() { rm -rf "$here" && mkdir -p "$here"; }

# pgm FILE WIDTH HEIGHT: a small image with texture.
pgm() {
  { printf 'P5\n%d %d\n255\n' "$2" "$3"; seq 1 $(($2 * $3)) | tr -d '\n' | head -c $(($2 * $3)) || true; } >"$1"
}

# A recording long enough that a run on it is still going when it is stopped.
long_recording() {
  local folder=$1 number=0 repeat image
  mkdir -p "$folder"
  for repeat in $(seq 1 200); do
    for image in "$hall"/mav0/cam0/data/*.png; do
      ln -s "$image" "$folder/$(printf '%06d' $number).png"
      number=$((number + 1))
    done
  done
}

# Waits until the run in the background has written some frames, or ended.
wait_for_frames() {
  local run=$1 process=$2
  while kill -0 "$process" 2>/dev/null; do
    [[ -f $run/tracks.jsonl && $(wc -l <"$run/tracks.jsonl") -ge 5 ]] && return
    read -r -t 0.05 <> <(:) || true
  done
  fail "the run ended before it could be stopped"
}

make_hall() {
  rm -rf "$hall"
  run 0 simulate hall --out "$hall" --frames 12
}

version() {
  run 0 --version
  for word in 'rastro ' 'commit ' 'compiler ' 'video files'; do said "$word"; done
}

help() {
  run 0 --help
  local commands='track odometry slam methods evaluate simulate occlude convert info check options' command
  for word in 'Exit codes' 'Examples' '--require' $commands; do said "$word"; done
  for command in $commands; do
    run 0 "$command" --help
    said 'xample'
  done
}

# Poses on a curve in TUM format: trajectory FILE COUNT SCALE
trajectory() {
  awk -v count="$2" -v scale="$3" 'BEGIN { for (k = 0; k < count; ++k)
    printf "%.1f %.6f %.6f %.6f 0 0 0 1\n", k / 10, scale * k, scale * 9 * sin(k / 9), scale * cos(k / 5) }' >"$1"
}

odometry() {
  local method
  for method in features classic profiles hybrid; do
    run 0 odometry "$hall" --out "$here/$method" --method "$method"
    said 'poses written to'
    [[ $(grep -cv '^#' "$here/$method/trajectory.txt") -eq $(grep -cv '^#' "$here/$method/trajectory_online.txt") ]] ||
      fail "not every frame has a pose"
    grep -q 'scale: relative' "$here/$method/trajectory.txt" || fail "the scale is not said"
  done
  run 0 odometry "$hall" --out "$here/scaled" --scale "reference=$here/features/trajectory.txt" --json
  said '"scale": "meters, from reference='
  refused "did you mean 'features'" odometry "$hall" --out "$here/no" --method featurs
  refused "did you mean 'features'" odometry "$hall" --out "$here/no" --set featurs=3
  refused 'camera-height' odometry "$hall" --out "$here/no" --scale height=1
  refused 'add --method profiles' odometry "$hall" --out "$here/no" --calibrate-yaw
  refused 'has no depth' odometry "$hall" --out "$here/no" --method rgbd
  refused 'nowhere' odometry "$here/nowhere" --out "$here/no"
  refused 'nowhere' odometry "$here/nowhere" --out "$here/no" --method auto
  [[ ! -e "$here/no" ]] || fail "a refused run left a folder"
}

evaluate_trajectory() {
  trajectory "$here/truth.txt" 60 1
  trajectory "$here/half.txt" 60 0.5
  trajectory "$here/short.txt" 30 1
  run 0 evaluate trajectory "$here/truth.txt" "$here/half.txt" --align sim3 --segments 10,20 --plot "$here/plot.svg"
  said 'matched     60 of 60'
  said 'scale 2.0000'
  grep -q '</svg>' "$here/plot.svg" || fail "no plot was written"
  run 0 evaluate trajectory "$here/truth.txt" "$here/half.txt" "$here/short.txt" --plot "$here/plot.png"
  said 'coverage differs (50.0 to 100.0 %)'
  run 0 evaluate trajectory "$here/truth.txt" "$here/short.txt" --json --require 'ate_rmse<=0.001'
  said '"coverage": 50.0'
  run 1 evaluate trajectory "$here/truth.txt" "$here/short.txt" --require 'coverage>=95' --quiet
  run 0 evaluate trajectory "$here/truth.txt" "$here/short.txt" --align origin --csv "$here/curves.csv"
  grep -q '^"[^"]*short.txt",0,' "$here/curves.csv" || fail "--csv has no curves: $(head -3 "$here/curves.csv")"
  refused "did you mean 'ate_rmse'" evaluate trajectory "$here/truth.txt" "$here/short.txt" --require 'ate_rms<=1'
  refused 'no KITTI poses' evaluate trajectory "$here/truth.txt" "$here/short.txt" --times "$here/truth.txt"
  refused '.svg or .png' evaluate trajectory "$here/truth.txt" "$here/short.txt" --plot "$here/plot.pdf"
  refused 'nowhere' evaluate trajectory "$here/truth.txt" "$here/nowhere"
  sed 's/^/9/' "$here/truth.txt" >"$here/late.txt"
  refused 'no pose is within' evaluate trajectory "$here/truth.txt" "$here/late.txt" --max-dt 0.01
  mkdir "$here/run" && cp "$here/truth.txt" "$here/run/trajectory.txt"
  run 0 evaluate trajectory "$here/truth.txt" "$here/run"
  echo '1 0 0 0 0 1 0 0 0 0 1 0' >"$here/kitti.txt"
  refused 'times.txt' evaluate trajectory "$here/truth.txt" "$here/kitti.txt"
  run 0 evaluate trajectory "$hall" "$hall/mav0/state_groundtruth_estimate0/data.csv" --align none --estimate-of body
  said 'compared as it is'
  run 0 evaluate trajectory "$hall" "$hall/mav0/state_groundtruth_estimate0/data.csv"
  said 'converted to poses of the camera with T_BS'
}

slam() {
  run 0 simulate corridor --out "$here/corridor" --frames 260 --quiet
  local method file
  for method in hector ekf; do
    run 0 methods
    said "$method"
    run 0 slam "$here/corridor" --method "$method" --out "$here/$method" --frames 0:200
    said "$method: 200 frames, 100.0 % of the requested ones have a pose"
    for file in about.json options.yaml stats.csv events.jsonl result.json trajectory.txt trajectory_online.txt \
      covariance_online.txt map.pgm map.yaml map.png map.rastro; do
      [[ -s $here/$method/$file ]] || fail "$method wrote no $file"
    done
    cat "$here/$method"/{trajectory.txt,map.pgm,map.yaml} >"$here/all"
    [[ ! -e $here/$method/landmarks.csv ]] || cat "$here/$method/landmarks.csv" >>"$here/all"
    cat "$here/$method/map.rastro" >>"$here/all"
    [[ $(value_of result_sha256 "$method") == $(sha256sum "$here/all" | cut -d' ' -f1) ]] || fail "wrong hash of $method"
    run 0 evaluate trajectory "$here/corridor" "$here/$method" --require 'ate_rmse<=0.5'
    run 0 evaluate relations "$here/$method" --relations "$here/corridor/relations.txt" --json --require 'trans_mean<=1'
    said '"trans_mean": 0.'
    run 0 evaluate map "$here/$method" "$here/corridor/floor_plan.yaml" --require 'free_agreement>=0.9'
    said 'precision'
    run 0 info "$here/$method"
    said 'laser scans'
    run 0 export "$here/$method" --to pgm --out "$here/$method/exported.yaml"
    cmp "$here/$method/map.pgm" "$here/$method/exported.pgm" || fail "the map of $method exports another grid"
    run 0 export "$here/$method" --to ply --out "$here/$method/scans.ply"
    run 0 export "$here/$method/map.rastro" --to g2o --out "$here/$method/graph.g2o"
    refused "no layer 'images'" export "$here/$method" --to mesh --out "$here/no"
    refused 'cannot localize in a map' localize "$here/corridor" --map "$here/$method" --out "$here/no"
  done
  [[ $(head -1 "$here/ekf/landmarks.csv") == id,* ]] || fail "ekf wrote no landmarks"
  run 0 export "$here/ekf" --to landmarks --out "$here/ekf/exported.csv"
  cmp "$here/ekf/landmarks.csv" "$here/ekf/exported.csv" || fail "the map of ekf exports other landmarks"
  run 0 slam "$here/corridor" --method hector --out "$here/shown" --frames 0:200 --view --port 0 --token s3cret
  ! grep -q s3cret "$here/shown/about.json" || fail "the token is in a file"
  [[ $(value_of result_sha256 shown) == $(value_of result_sha256 hector) ]] || fail "--view changed the result"
  refused '--port' slam "$here/corridor" --method hector --out "$here/no" --view --port 70000
  refused 'add --view' slam "$here/corridor" --method hector --out "$here/no" --port 8000
  run 0 slam "$here/corridor" --method hector --out "$here/again" --frames 0:200 --options "$here/hector/options.yaml" --json
  [[ $(value_of result_sha256 again) == $(value_of result_sha256 hector) ]] || fail "the options in use give another run"
  cmp "$here/stdout" "$here/again/result.json" || fail "--json does not print result.json"
  slam_refusals
}

slam_refusals() {
  run 1 slam "$here/corridor" --method hector --out "$here/limit" --frames 0:9 --require 'frames>=10' --quiet
  run 0 slam "$here/corridor" --method hector --out "$here/flags" --frames 0:9 --guess none --loop-closing false
  grep -q '^guess: none' "$here/flags/options.yaml" || fail "--guess is not heeded"
  run 0 slam "$here/corridor" --frames 0:20 --out "$here/auto"
  said 'method       hector: laser scans'
  run 0 slam "$here/corridor" --frames 0:5 --out "$here/auto_posed" --initial-pose 12.5,3,90
  refused 'add --method NAME' slam "$here/corridor" --out "$here/no" --sensor mono
  refused "did you mean 'hector'" slam "$here/corridor" --method hektor --out "$here/no"
  refused "no option 'guess'" slam "$here/corridor" --method ekf --out "$here/no" --guess none
  refused 'true' slam "$here/corridor" --method hector --out "$here/no" --loop-closing perhaps
  refused "did you mean 'coverage'" slam "$here/corridor" --method hector --out "$here/no" --require 'covrage>=3'
  refused "$hall" slam "$hall" --method hector --out "$here/no"
  refused 'nowhere' slam "$here/nowhere" --method hector --out "$here/no"
  refused 'no pose is within 0.05 s of any of its' evaluate relations "$here/hector" --relations "$here/hector/trajectory.txt"
  refused 'nowhere' evaluate relations "$here/nowhere" --relations "$here/corridor/relations.txt"
  refused '.yaml' evaluate map "$here/hector/map.pgm" "$here/corridor/floor_plan.yaml"
  refused 'none or se2' evaluate map "$here/hector" "$here/corridor/floor_plan.yaml" --align sim3
  [[ ! -e "$here/no" ]] || fail "a refused run left a folder"
}

unknown_command() {
  refused "did you mean 'track'" trck "$hall"
  refused "unknown option '--nonsense'" --nonsense
  refused "A subcommand is required"
}

unknown_flag() {
  refused "did you mean '--window'" track "$hall" --out "$here/run" --windw 5
  refused "did you mean '--out'" track "$hall" --ouut "$here/run"
  refused "--out" track "$hall"
  [[ ! -e $here/run ]] || fail "a folder was made although the command line is wrong"
}

bad_input() {
  mkdir "$here/empty"
  refused 'nowhere' track "$here/nowhere" --out "$here/run"
  refused 'empty' track "$here/empty" --out "$here/run"
  : >"$here/nothing.png"
  refused 'nothing.png' track "$here/nothing.png" --out "$here/run"
  refused 'options.yaml' track "$hall" --out "$here/run" --options "$here/options.yaml"
  refused '--frames' track "$hall" --out "$here/run" --frames 500:600
  [[ ! -e $here/run/tracks.csv ]] || fail "files were written although there is no input"
}

bad_values() {
  refused "window" track "$hall" --out "$here/run" --window 0
  refused "features" track "$hall" --out "$here/run" --features 0
  refused "features" track "$hall" --out "$here/run" --features many
  refused "priority" track "$hall" --out "$here/run" --mode priorty
  refused "did you mean" track "$hall" --out "$here/run" --set windw=5
  refused "--set" track "$hall" --out "$here/run" --set window
  refused "did you mean 'coverage'" track "$hall" --out "$here/run" --require 'covrage>=5'
  refused "did you mean 'csv'" track "$hall" --out "$here/run" --formats csw
  refused "--match-image" track "$hall" --out "$here/run" --match-image 9:3
  refused "--threads" track "$hall" --out "$here/run" --threads -1
  refused "did you mean 'track'" options trak
  local long
  long=$(printf 'n%.0s' {1..300})
  touch "$here/file"
  refused 'File name too long' vocabulary "$hall" --out "$long"
  refused 'File name too long' calibrate "$hall" --board chessboard:9x6:0.025 --out "$long"
  refused 'Not a directory' calibrate "$hall" --board chessboard:9x6:0.025 --out "$here/file/camera"
  refused 'views of the board' calibrate "$hall" --board chessboard:9x6:0.025 --out "$here/camera"
  [[ ! -e $here/camera ]] || fail "a calibration that failed left its folder"
}

folder_in_use() {
  mkdir "$here/run"
  echo mine >"$here/run/notes.txt"
  echo '{}' >"$here/run/lengths.json"
  refused '--force' track "$hall" --out "$here/run"
  run 0 track "$hall" --out "$here/run" --force --frames 0:3
  [[ -f $here/run/notes.txt ]] || fail "--force removed a file that is not of a run"
  [[ ! -e $here/run/former_run ]] || fail "--force left the former run aside"
  [[ ! -e $here/run/lengths.json ]] || fail "--force left lengths of the former map"
  cp "$here/run/tracks.csv" "$here/before.csv"
  pgm "$here/mask.pgm" 16 16
  refused 'the mask is 16x16' track "$hall" --out "$here/run" --force --mask "$here/mask.pgm"
  cmp "$here/before.csv" "$here/run/tracks.csv" || fail "a run without a frame cost the former one"
  echo file >"$here/file"
  refused 'not a folder' track "$hall" --out "$here/file"
  run 0 simulate loop --frames 2 --out "$here/world" --quiet
  [[ -s $here/world/closures.yaml ]] || fail "the world has no closures"
  run 0 simulate hall --frames 2 --out "$here/world" --force --quiet
  [[ ! -e $here/world/closures.yaml ]] || fail "--force left the closures of another world"
}

broken_image() {
  mkdir "$here/data"
  cp "$hall"/mav0/cam0/data/*.png "$here/data"
  local victim
  victim=$(ls "$here"/data/*.png | sed -n 4p)
  head -c 1000 "$victim" >"$here/cut" && mv "$here/cut" "$victim"
  run 0 track "$here/data" --out "$here/run"
  said "1 frames could not be read"
  said "$(basename "$victim")"
  [[ $(value_of skipped_frames run) == 1 && $(value_of frames run) == 11 ]] || fail "wrong counts in result.json"
  grep -qF "$(basename "$victim")" "$here/run/events.jsonl" || fail "events.jsonl does not name the frame"
  run 1 track "$here/data" --out "$here/run2" --require 'coverage>=99'
  said 'coverage>=99 missed'
}

changing_size() {
  mkdir "$here/data"
  local i
  for i in 0 1 2; do pgm "$here/data/$i.pgm" 320 240; done
  pgm "$here/data/3.pgm" 160 120
  run 2 track "$here/data" --out "$here/run" --rate 10
  grep -qF '160x120' "$here/stderr" || fail "the sizes are not named: $(cat "$here/stderr")"
  [[ $(frames_of run) == 3 ]] || fail "what was computed is not there"
}

one_frame() {
  run 0 track "$hall" --out "$here/run" --frames 0:1
  said 'one frame only'
  [[ $(frames_of run) == 1 ]] || fail "the frame is missing"
}

laser() {
  local log=$here/a.log
  seq 0 9 | awk '{ printf "FLASER 4 1.5 2.5 0 50 0 0 0 %g 0 0 %d.25 host 0\n", $1 / 10, $1 }' >"$log"
  run 0 info "$log"
  said 'format        carmen'
  said '4 beams from -90.00 to 45.00 deg, 0 to 50 m'
  run 0 check "$log"
  said '50.0 % returns, 25.0 % free, 25.0 % broken'
  echo 'FLASER 4 1.5 x' >>"$log"
  run 0 check "$log"
  said "a.log:11: broken line: a range is 'x', no number"
  run 0 convert "$log" --to scan --out "$here/b.log"
  said '10 scans written'
  run 0 info "$here/b.log"
  said '4 beams from -90.00 to 45.00 deg, 0 to 50 m'
  refused "'cloud' is not a format" convert "$log" --to cloud --out "$here/c.log"
  run 2 convert "$log" --to scan --out "$log"
  said 'would overwrite the data itself'
  refused 'has no images' track "$log" --out "$here/run"
  printf 'ODOM 0 0 0 0 0 0 1 host 0\n' >"$here/none.log"
  refused 'has no laser scans' info "$here/none.log"
  printf '#ROSBAG V2.0\n' >"$here/cut.bag"
  run 2 info "$here/cut.bag"
  [[ $(wc -l <"$here/stderr") -eq 1 ]] || fail "more than one line for a cut bag"
}

no_calibration() {
  run 0 track "$hall/mav0/cam0/data" --out "$here/run" --frames 0:3
  said '--calibration FILE'
  said '--fov DEG'
  grep -q ',nan,nan,' "$here/run/tracks.csv" || fail "rays without a calibration"
  run 0 track "$hall/mav0/cam0/data" --out "$here/run2" --frames 0:3 --fov 90
  ! tail -n +2 "$here/run2/tracks.csv" | grep -q ',nan,' || fail "no rays in spite of --fov"
}

outputs() {
  run 0 track "$hall" --out "$here/run" --images --match-image 1:9
  local file
  for file in about.json options.yaml stats.csv result.json tracks.yaml tracks.csv tracks.jsonl table.md match_1_9.png; do
    [[ -s $here/run/$file ]] || fail "$file is missing"
  done
  [[ $(ls "$here/run/track_images" | wc -l) == 12 ]] || fail "not an image per frame"
  [[ $(wc -l <"$here/run/tracks.jsonl") == 12 && $(frames_of run) == 12 ]] || fail "not every frame was written"
  [[ $(value_of result_sha256 run) == $(sha256sum "$here/run/tracks.csv" | cut -d' ' -f1) ]] || fail "wrong hash"
  run 0 track "$hall" --out "$here/run2" --options "$here/run/options.yaml" --formats csv
  [[ ! -e $here/run2/tracks.yaml ]] || fail "--formats is not heeded"
  run 0 track "$hall" --out "$here/former" --frames 0:2 --pictures
  said 'track: --pictures is now --images; the next release will not accept the old name'
  [[ $(ls "$here/former/track_images" | wc -l) == 2 ]] || fail "the former --pictures is not heeded"
  cmp "$here/run/tracks.csv" "$here/run2/tracks.csv" || fail "the options in use do not give the same run again"
  if "$rastro" --version | grep -q 'with  *video'; then
    run 0 track "$hall" --out "$here/run3" --video "$here/run.avi"
    [[ -s $here/run.avi ]] || fail "no video"
  fi
  refused '.avi' track "$hall" --out "$here/run4" --video "$here/run.gif"
  [[ ! -e $here/run4 ]] || fail "a folder was made although the video cannot be"
}

repeats() {
  local threads file
  for threads in 1 2 8; do run 0 track "$hall" --out "$here/$threads" --threads $threads; done
  run 0 track "$hall" --out "$here/again" --threads 2
  for file in tracks.yaml tracks.csv tracks.jsonl; do
    for threads in 2 8 again; do cmp "$here/1/$file" "$here/$threads/$file" || fail "$file differs: $threads"; done
  done
}

masks() {
  pgm "$here/small.pgm" 10 10
  run 2 track "$hall" --out "$here/run" --mask "$here/small.pgm"
  said 'the mask is 10x10'
  refused 'nowhere' track "$hall" --out "$here/run2" --mask "$here/nowhere"
  { printf 'P5\n752 480\n255\n'; head -c $((752 * 480)) /dev/zero; } >"$here/black.pgm"
  run 0 track "$hall" --out "$here/run3" --mask "$here/black.pgm"
  [[ $(value_of features run3) == 0 ]] || fail "features under a black mask"
  mkdir "$here/masks"
  local i
  for i in 00 01 02; do { printf 'P5\n752 480\n255\n'; head -c $((752 * 480)) /dev/zero | tr '\0' '\377'; } >"$here/masks/$i.pgm"; done
  run 0 track "$hall" --out "$here/run4" --mask "$here/masks" --frames 0:3
  run 2 track "$hall" --out "$here/run5" --mask "$here/masks"
  said 'none for frame 3'
  [[ $(frames_of run5) == 3 ]] || fail "the frames with a mask are missing"
}

json_and_quiet() {
  run 0 track "$hall" --out "$here/run" --frames 0:3 --json
  cmp "$here/stdout" "$here/run/result.json" || fail "--json does not print result.json"
  run 0 track "$hall/mav0/cam0/data" --out "$here/run2" --frames 0:3 --quiet
  [[ ! -s $here/stdout && ! -s $here/stderr ]] || fail "--quiet is not: $(cat "$here/stdout" "$here/stderr")"
}

require() {
  run 0 track "$hall" --out "$here/run" --require 'coverage>=100' --require 'frames<=12'
  run 1 track "$hall" --out "$here/run2" --require 'coverage>=100' --require 'frames>12'
  said 'frames>12 missed: it is 12'
  [[ -s $here/run2/result.json ]] || fail "a missed limit must not lose the run"
}

options() {
  run 0 options
  for word in mode window features validation; do said "$word"; done
  run 0 options rgbd
  cp "$here/stdout" "$here/rgbd"
  run 0 options slam/rgbd
  cmp "$here/stdout" "$here/rgbd" || fail "of two methods of one name the SLAM method comes first"
  run 0 options odometry/rgbd
  said depth_sigma_m
  refused "did you mean 'odometry/rgbd'" options odometry/rgdb
  run 0 options track --yaml
  cp "$here/stdout" "$here/options.yaml"
  run 0 track "$hall" --out "$here/run" --frames 0:2 --options "$here/options.yaml"
  run 0 options track --preset paper
  said 'candidates_factor = 1'
  refused 'use default or paper' options track --preset papr
  refused 'omit it' options features --preset paper
  run 0 track "$hall" --out "$here/preset" --frames 0:2 --preset paper --set candidates_factor=2
  grep -q '^candidates_factor: 2' "$here/preset/options.yaml" || fail "--preset wins over --set"
  grep -q '^predict: false' "$here/preset/options.yaml" || fail "--preset has no effect"
  refused 'use default or paper' track "$hall" --out "$here/no" --preset papr
  run 0 track "$hall" --out "$here/table" --frames 0:6 --table 3:5
  [[ $(grep -cE '^\| [0-9]+ ' "$here/table/table.md") -eq 2 ]] || fail "--table has no effect"
  refused 'A below B' track "$hall" --out "$here/no" --table 5:3
}

benchmark() {
  local list=$here/list.yaml out=$here/out
  printf '%s\n' 'entries:' \
    '  - {world: hall, simulate: --frames 10 --no-ground-truth, command: odometry, method: profiles, disturb: [none, "black=4:6"]}' >"$list"
  run 0 benchmark "$list" --dry-run
  said 'odometry @out/worlds/hall'
  run 0 benchmark "$list" --out "$out" --save "$here/baseline.json"
  said '0 of 2 runs have results'
  said 'hall odometry profiles black=4:6'
  said 'worst m'
  run 0 benchmark "$list" --out "$out" --baseline "$here/baseline.json"
  said '2 of 2 runs have results'
  said '2 of 2 entries compared: nothing is worse'
  printf '{"benchmark": 1, "entries": []}' >"$here/empty.json"
  refused 'has none of the entries' benchmark "$list" --out "$out" --baseline "$here/empty.json"
  sed -i 's/"tracked_percent": .*/"tracked_percent": 300.0,/' "$here/baseline.json"
  run 1 benchmark "$list" --out "$out" --baseline "$here/baseline.json" --quiet
  said 'worse: hall odometry profiles: untracked'
  sed -i 's/method: profiles/metod: profiles/' "$list"
  refused "did you mean 'method'" benchmark "$list" --out "$out"
  run 0 odometry "$hall" --out "$here/disturbed" --method profiles --disturb drop=3:5
  [[ $(value_of frames disturbed) -eq 10 ]] || fail "no frame was dropped"
  refused "did you mean 'swap-stereo'" odometry "$hall" --out "$here/no" --disturb swap-stero
}

compare() {
  local out=$here/out
  run 0 odometry "$hall" --out "$here/theirs" --method profiles --frames 0:12
  sed -i '/^#/d' "$here/theirs/trajectory.txt"
  local words=("$hall" --frames 0:12 --methods odometry/profiles,features --import "theirs=$here/theirs/trajectory.txt,sim3" --out "$out")
  run 0 compare "${words[@]}" --disturb noise
  said '0 of 2 runs have results'
  said 'noise=10'
  said 'Phone video. '
  grep -q '<svg' "$out/report.html" || fail "no curve in the report"
  ! grep -q 'http' "$out/report.html" || fail "the report needs a network"
  grep -q toprule "$out/report.tex" || fail "no LaTeX table"
  # The same trajectory as a run and as a file: the same errors.
  ate() { grep "^$(basename "$hall"),$1,0,1,ate_m," "$out/report.csv" | cut -d, -f6; }
  [[ -n $(ate theirs) && $(ate theirs) == "$(ate profiles)" ]] || fail "the import is judged otherwise: $(ate theirs), $(ate profiles)"
  run 0 compare "${words[@]}"
  said '2 of 2 runs have results'
  refused "did you mean 'features'" compare "$hall" --methods featurs --out "$out"
  run 0 simulate corridor --frames 5 --out "$out/corridor"
  run 0 compare "$out/corridor" --methods hector --out "$out/mapped"
  local page
  page=$(grep -o 'href="maps/[^"]*"' "$out/mapped/report.html" | cut -d'"' -f2)
  grep -q '<script' "$out/mapped/$page" || fail "the report links to no page of the map"
  refused 'allows none of the methods' compare "$out/corridor" --paper --out "$out/paper"
  refused 'allows none of the methods' compare "$out/corridor" --methods lsd --out "$out/lsd"
  refused "did you mean 'hall'" compare hal --methods all --out "$out"
  printf '%s\n' 'entries:' "  - {data: $hall, command: odometry, method: profiles, frames: \"0:5\"}" >"$here/list.yaml"
  run 0 compare "$here/list.yaml" --dry-run --out "$out/listed"
  said 'odometry'
  refused '--methods: is not for a list' compare "$here/list.yaml" --methods orb --out "$out/listed"
  refused '--seeds: is not for a list' compare "$here/list.yaml" --seeds 2 --out "$out/listed"
  refused '--every: is not for a list' compare "$here/list.yaml" --every 2 --out "$out/listed"
}

interrupt() {
  long_recording "$here/data"
  "$rastro" track "$here/data" --out "$here/run" >"$here/stdout" 2>"$here/stderr" &
  local process=$! code=0
  wait_for_frames "$here/run" $process
  kill -INT $process
  wait $process || code=$?
  [[ $code -eq 0 ]] || fail "Ctrl-C ended with $code"
  said 'interrupted'
  [[ $(value_of interrupted run) == true ]] || fail "result.json does not say so"
  local frames
  frames=$(value_of frames run)
  [[ $(frames_of run) == "$frames" && $(wc -l <"$here/run/tracks.jsonl") == "$frames" ]] || fail "frames were lost"
}

kill_() {
  long_recording "$here/data"
  "$rastro" track "$here/data" --out "$here/run" >"$here/stdout" 2>"$here/stderr" &
  local process=$!
  wait_for_frames "$here/run" $process
  # Not within a write: the system ends that at a page when the process is killed.
  kill -STOP $process
  until grep -q '^State:.*[TZ]' "/proc/$process/status"; do read -r -t 0.01 <> <(:) || true; done
  kill -KILL $process
  wait $process 2>/dev/null || true
  [[ -z $(tail -c 1 "$here/run/tracks.jsonl") ]] || fail "tracks.jsonl ends within a frame"
  # The last frame of the table of rows has as many rows as it says.
  tail -n +2 "$here/run/tracks.csv" | awk -F, '{ if ($1 != frame) { rows = 0; frame = $1 } ++rows; wanted = $11 } END { exit !(rows == wanted && NF == 14) }' ||
    fail "tracks.csv ends within a frame"
  [[ $(frames_of run) -ge 5 ]] || fail "frames were lost"
}

# What is recorded beside a live run repeats it, and no frame changes on the way. So few frames that all of them may
# wait for a machine that is busy.
live() {
  run 0 track "replay:$hall" --frames 0:30 --speed 2 --queue 1000 --out "$here/live" --record "$here/recorded"
  said '0 of'
  grep -qF '"runs_may_differ": true' "$here/live/result.json" || fail "result.json does not say that the run was live"
  run 0 track "$here/recorded" --out "$here/repeated"
  run 0 track "$hall" --frames 0:30 --out "$here/offline"
  cmp "$here/offline/tracks.csv" "$here/live/tracks.csv" || fail "a replay of which no frame is dropped differs"
  cmp "$here/offline/tracks.csv" "$here/repeated/tracks.csv" || fail "the recording of a live run differs"
  run 0 record "replay:$hall" --frames 0:3 --out "$here/copy"
  said '3 frames of'
  refused 'not empty' record "replay:$hall" --frames 0:3 --out "$here/copy" --quiet
  refused 'is not a live source' record "$hall" --out "$here/other"
  refused 'is for replays' track "$hall" --out "$here/other" --speed 2
  refused '/dev/video99' track v4l2:/dev/video99 --out "$here/other"
  printf 'YUV4MPEG2 W64 H48 F30:1 Cmono\nFRAME\n%3072sFRAME\n%3072s' ' ' ' ' >"$here/two.y4m"
  run 0 track pipe: --rate 30 --out "$here/pipe" <"$here/two.y4m"
  [[ $(value_of frames pipe) == 2 ]] || fail "the pipe had two frames"
  run 0 devices --json
}

fresh
if [[ $case_name == kill ]]; then kill_; else "$case_name"; fi
echo "passed"
