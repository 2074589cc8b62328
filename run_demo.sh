#!/usr/bin/env bash
# SPDX-License-Identifier: BSD-3-Clause
# Plays a ladar bag through the terrain nodelet and shows the classes in rviz.
#   ./run_demo.sh             makes a simulated bag first
#   ./run_demo.sh my.bag      plays yours
set -euo pipefail

usage="usage: run_demo.sh [BAG [TOPIC]]    (TOPIC of the clouds, /points if not given)"
case "${1:-}" in
  -h | --help)
    echo "$usage"
    exit 0
    ;;
  -*)
    echo "run_demo.sh: unknown option $1; $usage" >&2
    exit 2
    ;;
esac
bag="${1:+$(realpath -m -- "$1")}"
topic="${2:-/points}"
cd "$(dirname "$(realpath "$0")")"
. scripts/prepare.sh

[ -z "$bag" ] || [ -r "$bag" ] || fail "$bag: no such bag"
install_missing "${build_packages[@]}" "${run_packages[@]}" "${view_packages[@]}"
echo "building"
build build all "${build_options[@]}" -DCATKIN_ENABLE_TESTING=OFF
set +u
. build/devel/setup.sh
set -u

mkdir -p out
if [ -z "$bag" ]; then
  bag="$PWD/out/demo.bag"
  if [ ! -f "$bag" ] || [ devel/lib/ladar_perception/simulate_ladar -nt "$bag" ]; then
    rosrun ladar_perception simulate_ladar --scene forest --duration 25 --speed 2.5 --seed 7 \
      --out "$bag" || fail "simulate_ladar could not make $bag"
  fi
fi
rosbag info -y "$bag" >/dev/null 2>out/bag.log || fail "$bag: not a bag, or one that needs 'rosbag reindex'"

# A ROS master, and where there is no screen an X server, of our own: nothing that runs already on
# this machine is touched.
children=()
stop_children() {
  local child
  for child in "${children[@]}"; do kill "$child" 2>/dev/null || true; done
  wait 2>/dev/null || true
}
trap stop_children EXIT
port=$((20000 + RANDOM % 20000))
export ROS_MASTER_URI="http://localhost:$port"
screen=true
if [ -z "${DISPLAY:-}" ]; then
  screen=false
  display_file="$(mktemp)"
  Xvfb -displayfd 3 -screen 0 1500x900x24 3>"$display_file" >out/xvfb.log 2>&1 &
  children+=($!)
  for _ in $(seq 100); do
    [ -s "$display_file" ] && break
    sleep 0.1
  done
  [ -s "$display_file" ] || fail "Xvfb did not start; see out/xvfb.log"
  export DISPLAY=":$(cat "$display_file")" LIBGL_ALWAYS_SOFTWARE=1 QT_X11_NO_MITSHM=1
  rm -f "$display_file"
fi

echo "playing $bag"
roslaunch -p "$port" ladar_perception replay.launch bag:="$bag" points:="$topic" delay:=4 \
  respawn_rviz:="$([ "$screen" = true ] && echo false || echo true)" \
  >out/roslaunch.log 2>&1 &
children+=($!)
for _ in $(seq 100); do
  rosparam get /run_id >/dev/null 2>&1 && break
  sleep 0.1
done
rosrun ladar_perception terrain_summary.py || fail "the replay gave no labels; see out/roslaunch.log"
import -window root out/demo.png 2>out/picture.log || fail "no picture; see out/picture.log"
[ "$(identify -format %k out/demo.png)" -gt 100 ] || fail "rviz drew nothing; see out/roslaunch.log"
echo "picture: out/demo.png"
