#!/usr/bin/env bash
# SPDX-License-Identifier: BSD-3-Clause
# Makes config/models/starter.yaml again, byte by byte, from simulated drives alone, and tests it on
# drives it has not seen. Needs a built package: run run_demo.sh or run_tests.sh first.
# usage: make_starter_model.sh [FOLDER]   bags are kept in FOLDER and used again; without it, not kept
set -euo pipefail
work="${1:+$(realpath -m "$1")}"
cd "$(dirname "$(realpath "$0")")/.."
programs=devel/lib/ladar_perception
set +u
. build/devel/setup.sh
set -u
if [ -z "$work" ]; then
  work="$(mktemp -d)"
  trap 'rm -rf "$work"' EXIT
fi
mkdir -p "$work"

# drive NAME SCENE SENSOR HEIGHT DURATION SPEED SEED [OPTION...]
drive() {
  local name="$1"
  shift
  [ -s "$work/$name.bag" ] && return
  "$programs/simulate_ladar" --scene "$1" --sensor "$2" --sensor-height "$3" --duration "$4" \
    --speed "$5" --seed "$6" "${@:7}" --out "$work/part.bag"
  mv "$work/part.bag" "$work/$name.bag"
}

# Scenes of every kind, by sensors that look across, around and ahead, sparse and dense, low and
# high: what no drive has in it, no model learned from them can know.
drive learn-01 street pushbroom 1.85 45 8 1 --look both
drive learn-02 street pushbroom 1.6 45 8 2 --look both
drive learn-03 street pushbroom 2.2 45 8 3 --look both
drive learn-04 campus pushbroom 1.85 36 8 4 --look both
drive learn-05 scrubland pushbroom 1.5 40 6 5 --look both
drive learn-06 forest pushbroom 1.85 30 6 6 --look both
drive learn-07 street vlp16 1.2 12 5 7
drive learn-08 scrubland vlp16 0.7 12 2.5 8
drive learn-09 forest vlp16 1.0 10 3 9
drive learn-10 tall_grass vlp16 1.4 10 3 10
drive learn-11 street hdl64 1.73 5 8 11
drive learn-12 scrubland os64 0.9 5 3 12
drive learn-13 campus os64 1.5 5 5 13
drive learn-14 flat_ground os64 1.5 5 5 14
drive learn-15 forest xuv 1.7 20 2 15
drive learn-16 scrubland xuv 1.7 20 2 16
drive learn-17 street xuv 1.7 20 4 17

drive test-1 street pushbroom 1.85 30 8 101 --look both
drive test-2 scrubland vlp16 1.0 10 3 102
drive test-3 forest os64 1.4 4 3 103
drive test-4 tall_grass xuv 1.7 15 3 104
drive test-5 campus hdl64 1.73 4 5 105

"$programs/train_classifier" --out config/models/starter.yaml --config config/terrain.yaml,config/tall_map.yaml \
  --classes config/classes/simulated_three.yaml "$work"/learn-*.bag
"$programs/evaluate_classifier" --model config/models/starter.yaml --report "$work/report" \
  --config config/tall_map.yaml --classes config/classes/simulated_three.yaml --no-pictures \
  "$work"/test-*.bag
