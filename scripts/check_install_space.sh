#!/usr/bin/env bash
# SPDX-License-Identifier: BSD-3-Clause
# Installs a build into <build>/.install, the CMAKE_INSTALL_PREFIX it was configured with, and uses
# what was installed, far from the sources. (The dot keeps roslaunch, which looks into every other
# folder of a package, from finding launch files twice.)
#   check_install_space.sh BUILD_FOLDER
set -euo pipefail
build="$(realpath "$1")"
prefix="$build/.install"
rm -rf "$prefix"
DESTDIR='' cmake --install "$build" >"$build/install.log"

unset ROS_PACKAGE_PATH CMAKE_PREFIX_PATH LD_LIBRARY_PATH PYTHONPATH ROS_MASTER_URI
set +u
. "$prefix/setup.sh"
set -u
cd /
share="$prefix/share/ladar_perception"
[ "$(rospack find ladar_perception)" = "$share" ]
rospack plugins --attrib=plugin nodelet | grep >/dev/null "ladar_perception $share/nodelet_plugins.xml"
[ -f "$prefix/lib/libladar_perception_nodelets.so" ]
if ldd "$prefix/lib/libladar_perception_nodelets.so" | grep 'not found'; then exit 1; fi

work="$(mktemp -d)"
trap 'rm -rf "$work"' EXIT
rosrun ladar_perception simulate_ladar --duration 0.5 --out "$work/scans.bag"
# The default configuration and model come from the install space.
rosrun ladar_perception classify_bag "$work/scans.bag" --metrics "$work/metrics.json"
rosrun ladar_perception classify_bag "$work/scans.bag" --config "$share/config/terrain.yaml"
grep -q '"scans": 10' "$work/metrics.json"
# The script of the pictures is found from there, too.
rosrun ladar_perception evaluate_classifier "$work/scans.bag" --report "$work/report" \
  --model "$share/config/models/starter.yaml"
[ -f "$work/report/confusion.png" ]
roslaunch --files ladar_perception replay.launch bag:=x | grep >/dev/null "$share/launch/terrain.launch"
roslaunch --files ladar_perception replay.launch bag:=x poses:=true |
  grep >/dev/null "$share/launch/pose_resampler.launch"
rosrun ladar_perception terrain_summary.py --help >"$work/help.txt"
[ -f "$share/rviz/terrain.rviz" ] && [ -f "$share/rviz/pose_resampler.rviz" ]
[ -f "$share/config/pose_resampler.yaml" ]
[ -x "$prefix/lib/ladar_perception/pose_resampler_node" ]
roslaunch --files ladar_perception replay.launch bag:=x slam:=true |
  grep >/dev/null "$share/launch/delayed_state.launch"
[ -f "$share/config/delayed_state.yaml" ] && [ -f "$share/rviz/delayed_state.rviz" ]
[ -x "$prefix/lib/ladar_perception/delayed_state_node" ]
