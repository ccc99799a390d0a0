#!/usr/bin/env bash
# SPDX-License-Identifier: Apache-2.0
# What rastro writes, read by the programs it is written for: other_programs_test.sh PROGRAM SCRATCH_FOLDER CASE
# CASE is make_other (first), models, g2o, grid, clouds, octomap, numbers, tracks_yaml or video; or mrcal or rtsp. A case whose program is missing ends with 77
# (skipped) and says which package has it.
set -euo pipefail
rastro=$1
scratch=$2
case_name=$3
data=$scratch/other
here=$scratch/other_$case_name

fail() {
  echo "FAILED: $*" >&2
  exit 1
}
# need PROGRAM PACKAGE: or the case is skipped.
need() {
  command -v "$1" >/dev/null && return
  echo "SKIPPED: $1 is not installed (Debian package $2)" >&2
  exit 77
}
need_python() {
  /usr/bin/python3 -c "import $1" 2>/dev/null && return
  echo "SKIPPED: Python's $1 is not installed (Debian package $2)" >&2
  exit 77
}
run() {
  "$rastro" "$@" >"$here/stdout" 2>"$here/stderr" || fail "'rastro $*': $(cat "$here/stderr")"
}

# One map of each kind of camera.
make_other() {
  rm -rf "$data" && mkdir -p "$data"
  here=$data
  run simulate bedroom --out "$data/room" --frames 40
  run simulate loop --out "$data/pair" --stereo --frames 40
  run slam "$data/room" --method orb --sensor mono --out "$data/mono"
  run slam "$data/room" --method orb --sensor rgbd --out "$data/depth"
  run slam "$data/pair" --method orb --sensor stereo --out "$data/stereo"
  run slam "$data/room" --method rgbd --out "$data/rgbd" --set keyframe_frames=4
  run simulate corridor --out "$data/office" --frames 300
  run slam "$data/office" --method hector --out "$data/laser"
}

colmap_of() {
  local map=$1 model=$here/$1 log=$here/$1.log images
  run export "$data/$map" --to colmap --out "$model"
  colmap model_analyzer --path "$model" >"$log" 2>&1 || fail "COLMAP does not read the model of $map: $(tail -3 "$log")"
  mkdir -p "$here/adjusted_$map"
  colmap bundle_adjuster --input_path "$model" --output_path "$here/adjusted_$map" \
    --BundleAdjustment.max_num_iterations 10 >"$log" 2>&1 || fail "COLMAP does not adjust $map: $(tail -3 "$log")"
  colmap image_undistorter --input_path "$model" --image_path "$model/images" --output_path "$here/undistorted_$map" \
    >"$log" 2>&1 || fail "COLMAP does not undistort $map: $(tail -3 "$log")"
  images=$(grep -v '^#' "$model/images.txt" | awk 'NR % 2 == 1' | wc -l)
  [[ $(find "$here/undistorted_$map/images" -type f | wc -l) -eq $images ]] ||
    fail "COLMAP undistorts not all of the $images images of $map: $(ls "$here/undistorted_$map/images")"
  if [[ $map != rgbd ]]; then
    run export "$data/$map" --to colmap-binary --out "$here/binary_$map"
    colmap model_analyzer --path "$here/binary_$map" >"$log" 2>&1 || fail "COLMAP does not read the binary model of $map"
  fi
}

models() {
  need colmap colmap
  local map
  for map in mono depth stereo rgbd; do colmap_of "$map"; done
  grep -q ' [0-9]*\.[0-9]*\.png$' "$here/depth/images.txt" || fail "images are not named as the recording has them"
}

g2o() {
  need graph-slam mrpt-apps
  local map
  for map in mono depth stereo rgbd; do
    run export "$data/$map" --to g2o --out "$here/$map.g2o"
    graph-slam --3d --info -i "$here/$map.g2o" >"$here/info" 2>&1 || fail "MRPT does not read the graph of $map"
    [[ $(sed -n 's/^Edge count *: //p' "$here/info") -gt 0 ]] || fail "MRPT finds no edge in the graph of $map"
    graph-slam --3d --levmarq --max-iters 20 -q -i "$here/$map.g2o" -o "$here/$map.out" >"$here/info" 2>&1 ||
      fail "MRPT does not optimize the graph of $map: $(tail -3 "$here/info")"
  done
}

# The occupancy grid of a laser and of a depth camera: MRPT must know the same cells free, occupied and unknown.
grid() {
  need ros-map-yaml2mrpt mrpt-apps
  local map
  run export "$data/rgbd" --to pgm --out "$here/depth.pgm"
  cp "$data/laser/map.pgm" "$data/laser/map.yaml" "$here"
  for map in map depth; do
    ros-map-yaml2mrpt -w -q -i "$here/$map.yaml" >"$here/log" 2>&1 || fail "MRPT does not read $map.yaml: $(cat "$here/log")"
    /usr/bin/python3 - "$here/$map" <<'PYTHON' || fail "MRPT reads another map from $map.yaml"
import gzip, re, struct, sys
header, size, _, pixels = re.match(rb"(P5\s(?:#[^\n]*\s)*(\d+ \d+)\s(255)\s)(.*)", open(sys.argv[1] + ".pgm", "rb").read(), re.S).groups()
columns, rows = map(int, size.split())
yaml = dict(line.split(": ", 1) for line in open(sys.argv[1] + ".yaml") if ": " in line)
origin, cell_m = [float(number) for number in yaml["origin"].strip("[]\n").split(",")], float(yaml["resolution"])
grid = gzip.open(sys.argv[1] + ".gridmap.gz").read().split(b"COccupancyGridMap2D", 1)[1][2:]
assert struct.unpack_from("<2I", grid) == (columns, rows), "size"
x_min, x_max, y_min, y_max, resolution = struct.unpack_from("<5f", grid, 8)
expected = (origin[0], origin[0] + columns * cell_m, origin[1], origin[1] + rows * cell_m, cell_m)
assert all(abs(a - b) < 1e-4 for a, b in zip((x_min, x_max, y_min, y_max, resolution), expected)), "extent"
odds = struct.unpack_from(f"<{columns * rows}b", grid, 28)
occupied, free = float(yaml["occupied_thresh"]), float(yaml["free_thresh"])
sign = [(p < free) - (p > occupied) for p in (1 - pixel / 255 for pixel in range(256))]
of_image = [sign[pixel] for row in reversed(range(rows)) for pixel in pixels[row * columns:(row + 1) * columns]]
assert of_image == [(cell > 0) - (cell < 0) for cell in odds], "cells"
assert min(of_image) == -1 and max(of_image) == 1, "walls and free space"
PYTHON
  done
}

clouds() {
  need pcl_pcd2ply pcl-tools
  local map
  for map in mono depth rgbd; do
    run export "$data/$map" --to pcd --out "$here/$map.pcd"
    run export "$data/$map" --to ply --out "$here/$map.ply"
    pcl_pcd2ply "$here/$map.pcd" "$here/back.ply" >"$here/log" 2>&1 || fail "PCL does not read $map.pcd"
    pcl_ply2pcd "$here/$map.ply" "$here/back.pcd" >"$here/log" 2>&1 || fail "PCL does not read $map.ply"
    [[ $(grep -a -m1 '^POINTS' "$here/back.pcd") == $(grep -a -m1 '^POINTS' "$here/$map.pcd") ]] || fail "other points in $map.ply"
  done
}

octomap() {
  need convert_octree octomap-tools
  run export "$data/rgbd" --to octomap --out "$here/room.ot"
  run export "$data/rgbd" --to octomap --out "$here/room.bt"
  bt2vrml "$here/room.bt" >"$here/log" 2>&1 || fail "OctoMap does not read room.bt: $(tail -3 "$here/log")"
  [[ $(grep -c translation "$here/room.bt.wrl") -gt 100 ]] || fail "OctoMap finds few occupied cells in room.bt"
  convert_octree "$here/room.ot" "$here/back.bt" >"$here/log" 2>&1 || fail "OctoMap does not read room.ot"
  cmp -s <(sed '1,/^data/d' "$here/back.bt") <(sed '1,/^data/d' "$here/room.bt") || fail "room.ot and room.bt differ"
}

numbers() {
  need_python numpy python3-numpy
  run track "$data/room" --out "$here/run" --frames 0:6
  run export "$data/depth" --to landmarks --out "$here/landmarks.csv"
  (cd "$here" && /usr/bin/python3 - "$data") <<'PYTHON' || fail "numpy does not read tracks, trajectory or landmarks"
import sys
import numpy
tracks = numpy.genfromtxt("run/tracks.csv", delimiter=",", names=True)
assert len(set(tracks["frame"])) == 6, tracks.dtype
trajectory = numpy.loadtxt(sys.argv[1] + "/depth/trajectory.txt")
assert trajectory.shape == (40, 8), trajectory.shape
assert numpy.allclose(numpy.linalg.norm(trajectory[:, 4:], axis=1), 1, atol=1e-6)
landmarks = numpy.genfromtxt("landmarks.csv", delimiter=",", names=True)
assert len(landmarks) > 100, landmarks.dtype
PYTHON
}

tracks_yaml() {
  need_python cv2 python3-opencv
  need_python yaml python3-yaml
  run track "$data/room" --out "$here/run" --frames 0:6
  (cd "$here" && sed -n '/^import cv2/,/^```/{/^```/d;p}' "$4" >snippet.py)
  cat >>"$here/snippet.py" <<'PYTHON'
import yaml
with open("run/tracks.yaml") as file:
    tracks = yaml.load(file, yaml.CSafeLoader)
assert frames.size() == len(tracks["frames"]) == 6, frames.size()
assert id == tracks["frames"][5]["features"][-1][0]
PYTHON
  (cd "$here" && /usr/bin/python3 snippet.py) || fail "the snippet of the how-to, or libyaml, does not read tracks.yaml"
}

# A video as a phone makes it: frames come when there is light.
video() {
  need ffmpeg ffmpeg
  local file
  for file in phone.mp4 phone.mkv; do
    ffmpeg -v error -y -f lavfi -i testsrc=size=160x120:rate=30:duration=1 \
      -vf "setpts='if(lt(N,10),N,N+30)/30/TB'" -fps_mode vfr -c:v mpeg4 "$here/$file"
    run check "$here/$file"
    grep -q '1.033 s after frame 9' "$here/stdout" || fail "the hole of $file is not told: $(cat "$here/stdout")"
    run track "$here/$file" --out "$here/run_$file" --every 3
    [[ $(grep -o '"stamp_ns":"\{0,1\}[0-9]*' "$here/run_$file/tracks.jsonl" | wc -l) -eq 10 ]] || fail "--every 3 of 30 frames"
  done
}

# A network camera on the loopback interface.
rtsp() {
  need ffmpeg ffmpeg
  need /usr/bin/python3 python3
  /usr/bin/python3 "$(dirname "${BASH_SOURCE[0]}")/serve_rtsp.py" "$here/port" 15 2>"$here/server" &
  rtsp_server=$!
  trap 'kill "$rtsp_server" 2>/dev/null || true' EXIT
  for _ in $(seq 100); do
    [[ -f $here/port ]] && break
    sleep 0.1
  done
  [[ -f $here/port ]] || fail "no camera: $(cat "$here/server")"
  run record "rtsp://127.0.0.1:$(cat "$here/port")/camera" --frames 0:60 --out "$here/walk" --fov 60 --json
  /usr/bin/python3 - "$here/stdout" "$here/walk/mav0/cam0" <<'PYTHON' || fail "what the camera sent: $(cat "$here/stdout")"
import json, pathlib, sys
recorded = json.load(open(sys.argv[1]))
assert recorded["frames"] == 60 and recorded["skipped_frames"] == 0, recorded
# Those of the first second or so come at once: FFmpeg keeps them while it looks what the stream is.
assert 1.5 < recorded["seconds"] < 8, recorded["seconds"]
images = list(pathlib.Path(sys.argv[2], "data").iterdir())
assert len({image.read_bytes() for image in images}) > 10
header = images[0].read_bytes()[16:24]
assert (int.from_bytes(header[:4], "big"), int.from_bytes(header[4:], "big")) == (320, 240)
PYTHON
}

# The same corners calibrated by mrcal: projections and their uncertainty. Recorded boards, and generated ones.
mrcal() {
  need mrcal-calibrate-cameras mrcal
  need_python mrcal python3-mrcal
  need_python scipy python3-scipy
  need_python cv2 python3-opencv
  local boards=${RASTRO_DATA:-}/chessboards scripts model side seed
  scripts=$(dirname "${BASH_SOURCE[0]}")
  local -a sets=()
  if [[ -d $boards ]]; then
    for side in left right; do sets+=("$boards/$side*.jpg"); done
  fi
  for seed in 1 2; do
    mkdir -p "$here/boards$seed"
    /usr/bin/python3 "$scripts/draw_boards.py" "$here/boards$seed" $seed 24
    sets+=("$here/boards$seed/*.png")
  done
  for images in "${sets[@]}"; do
    for model in pinhole4 pinhole5; do
      run calibrate "$images" --board chessboard:9x6:0.025 --model $model --out "$here/$model" --force
      echo "$images"
      /usr/bin/python3 "$scripts/compare_with_mrcal.py" "$here/$model" || fail "mrcal has another calibration of $images"
    done
  done
}

case $case_name in
  make_other) make_other ;;
  models | g2o | grid | clouds | octomap | numbers | tracks_yaml | video | mrcal | rtsp)
    rm -rf "$here" && mkdir -p "$here"
    $case_name "$@"
    ;;
  *) fail "no case '$case_name'" ;;
esac
