#!/usr/bin/env bash
# SPDX-License-Identifier: BSD-3-Clause
# Builds the core without ROS under sanitizers and runs its tests, which takes about an hour on two
# cores: for before a release, and after changes to threads or memory. Usage:
#   scripts/check_sanitizers.sh [address,undefined | thread] [CTEST-OPTION...]
# for example -R '^resample_'. Ends with a line like 'N passed, N failed, N skipped'.
set -euo pipefail
cd "$(dirname "$(realpath "$0")")/.."
. scripts/prepare.sh

sanitizers="${1:-address,undefined}"
case "$sanitizers" in
  address,undefined | thread) shift "$(($# > 0))" ;;
  *) fail "sanitizers '$sanitizers', expected address,undefined or thread" ;;
esac
install_missing "${build_packages[@]}" "${test_packages[@]}"

folder="build/sanitize_${sanitizers%,*}"
build "$folder" all -DLADAR_WITH_ROS=OFF -DLADAR_WARNINGS_AS_ERRORS=ON \
  -DLADAR_SANITIZE="$sanitizers" -DCMAKE_BUILD_TYPE=RelWithDebInfo \
  "-DCMAKE_CXX_FLAGS_RELWITHDEBINFO=-O1 -g1"
rm -f "$folder/results.xml"
UBSAN_OPTIONS=halt_on_error=1:print_stacktrace=1 ctest --test-dir "$folder" -j "$(nproc)" \
  --timeout 600 --output-on-failure --output-junit "$PWD/$folder/results.xml" "$@" \
  >"$folder/ctest.log" 2>&1 || true
scripts/summarize_tests.py "$folder/results.xml"
