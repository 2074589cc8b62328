# SPDX-License-Identifier: BSD-3-Clause
# Sourced by bench/measure_*, from the package's folder: options, building, measuring.
. scripts/prepare.sh

# read_options NAME [OPTION]: sets `redraw` to yes or no, or ends the program.
read_options() {
  local usage="usage: $1 [--redraw]"
  redraw=no
  case "${2:-}" in
    -h | --help)
      echo "$usage"
      exit 0
      ;;
    --redraw) redraw=yes ;;
    "") ;;
    *)
      echo "$1: unknown option $2; $usage" >&2
      exit 2
      ;;
  esac
}

# measure RESULTS PROGRAM...: builds, and runs bench_PROGRAM to RESULTS/PROGRAM.json; with --redraw
# it only sees to it that there is something to draw.
measure() {
  local results="$1" program
  shift
  install_missing "${build_packages[@]}" "${bench_packages[@]}"
  if [ "$redraw" = yes ]; then
    for program in "$@"; do
      [ -r "$results/$program.json" ] || fail "nothing measured yet: run it without --redraw"
    done
    return
  fi
  echo "building"
  build build/bench all -DLADAR_WITH_ROS=OFF -DLADAR_BENCHMARKS=ON -DBUILD_TESTING=OFF \
    "${build_options[@]}"
  mkdir -p "$results"
  for program in "$@"; do
    echo "measuring: bench_$program"
    "build/bench/bench_$program" --benchmark_out_format=json \
      --benchmark_out="$results/$program.json" >"$results/$program.log" 2>&1 ||
      fail "bench_$program; see $results/$program.log"
  done
}
