#!/usr/bin/env bash
# SPDX-License-Identifier: BSD-3-Clause
# Makes config/models/starter.yaml again, byte by byte, from simulated scenes alone, and tests it on
# scenes it has not seen. Needs a built package: run run_demo.sh or run_tests.sh first.
set -euo pipefail
cd "$(dirname "$(realpath "$0")")/.."
programs=devel/lib/ladar_perception
set +u
. build/devel/setup.sh
set -u
work="$(mktemp -d)"
trap 'rm -rf "$work"' EXIT

scenes=(flat_ground forest tall_grass campus)
for scene in "${scenes[@]}"; do
  "$programs/simulate_ladar" --scene "$scene" --duration 20 --seed 1 --out "$work/$scene-1.bag"
  "$programs/simulate_ladar" --scene "$scene" --duration 20 --seed 2 --out "$work/$scene-2.bag"
done
"$programs/train_classifier" --out config/models/starter.yaml "$work"/*-1.bag
for bag in "$work"/*-2.bag; do "$programs/classify_bag" "$bag" | tail -n 1; done
