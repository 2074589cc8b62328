#!/usr/bin/env bash
# SPDX-License-Identifier: BSD-3-Clause
# Builds everything with warnings as errors and runs every test: core, programs, ROS, launch files,
# catkin_lint, and an install space. Tests on real data look for it in $LADAR_DATA (default
# ../shared/data). Sanitizers: scripts/check_sanitizers.sh.
set -euo pipefail
cd "$(dirname "$(realpath "$0")")"
. scripts/prepare.sh

step() { printf '== %s (%d s)\n' "$*" "$SECONDS"; }

install_missing "${build_packages[@]}" "${run_packages[@]}" "${test_packages[@]}" \
  "${bench_packages[@]}"

step "building"
build build all "${build_options[@]}" -DCATKIN_ENABLE_TESTING=ON -DLADAR_BENCHMARKS=ON
run_logged build/build_tests.log ninja -C build tests

step "core, program and ROS tests, launch files"
set +u
. build/devel/setup.sh
set -u
rm -rf build/test_results build/check_results
mkdir -p build/test_results build/check_results
# Failures are counted from the reports, all of them.
ninja -C build run_tests >build/run_tests.log 2>&1 ||
  echo "run_tests itself failed; see build/run_tests.log" >&2

# check NAME COMMAND...: one more test, passed when the command succeeds.
checks=()
check() {
  local name="$1"
  shift
  if "$@" >"build/check_results/$name.log" 2>&1; then
    checks+=("$name=passed")
  else
    checks+=("$name=failed")
    tail -n 15 "build/check_results/$name.log" >&2
  fi
}

step "catkin_lint, install space"
# The two commands of the README are for a clone, not for an install space.
check catkin_lint catkin_lint --strict -W1 --ignore uninstalled_script .
check install_space scripts/check_install_space.sh build

step "benchmarks run"
once=(--benchmark_repetitions=1 --benchmark_display_aggregates_only=false)
check bench_saliency devel/lib/ladar_perception/bench_saliency "${once[@]}" \
  --benchmark_filter='flat_ground/k:9|sums_to_labels/.*/flat_ground|(insert|neighbourhood)/.*/flat_ground'
check bench_pipeline devel/lib/ladar_perception/bench_pipeline "${once[@]}" --benchmark_filter='patch/points_per_s:100k'

step "done"
scripts/summarize_tests.py build/test_results "${checks[@]}"
