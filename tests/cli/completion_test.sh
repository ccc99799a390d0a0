#!/usr/bin/env bash
# SPDX-License-Identifier: Apache-2.0
# What bash offers after parts of a command line: completion_test.sh PROGRAM PAGES_SCRIPT SCRATCH_FOLDER
set -euo pipefail
rm -rf "$3" && mkdir -p "$3"
python3 "$2" "$1" "$3"
# shellcheck disable=SC1091
source "$3/rastro.bash"

# offered WORDS...: what is offered for the last word, in one line.
offered() {
  COMP_WORDS=(rastro "$@")
  COMP_CWORD=$#
  COMPREPLY=()
  _rastro
  echo "${COMPREPLY[*]}"
}

# expect WANTED WORDS...: a list of words that must all be offered, or "files": nothing, so that bash offers files.
expect() {
  local wanted=$1 given word
  shift
  given=$(offered "$@")
  if [[ $wanted == files ]]; then
    [[ -z $given ]] || { echo "FAILED: after 'rastro $*' files are due, offered is: $given" >&2; exit 1; }
    return
  fi
  for word in $wanted; do
    [[ " $given " == *" $word "* ]] || { echo "FAILED: after 'rastro $*' $word is due, offered is: $given" >&2; exit 1; }
  done
}
refuse() {
  local unwanted=$1
  shift
  [[ " $(offered "$@")" != *"$unwanted"* ]] || { echo "FAILED: after 'rastro $*' no $unwanted is due" >&2; exit 1; }
}

expect 'track slam export simulate evaluate' ''
expect 'slam' sl
expect 'tracks trajectory map cloud' evaluate ''
expect 'hall street corridor bedroom study loop' simulate ''
expect 'hector ekf rgbd orb' slam --method ''
expect 'orb' slam data --method o
refuse features slam --method ''
expect 'features' odometry data --method ''
expect 'mono stereo rgbd' slam --sensor ''
expect 'true false' slam --loop-closing ''
expect 'pipelined step' slam --mode ''
expect 'klt vote dual priority' track --mode ''
expect 'ply mesh g2o colmap-binary tum' export run --to ''
expect 'euroc kitti kitti-raw tum carmen' simulate hall --format ''
expect 'track orb hector' options ''
expect files slam ''
expect files slam --method orb ''
expect files slam --calibration ''
expect files track data --out ''
expect files info ''
expect '--method --sensor --out' slam data -
expect '--out' slam data --o
refuse -- slam data --method ''
expect '--images --match-image' track data -
refuse --pictures track data -
