# SPDX-License-Identifier: BSD-3-Clause
# Sourced by run_demo.sh and run_tests.sh: installs what is missing and builds. Debian 12.

# ROS programs are written for Debian's own Python; one from elsewhere on PATH breaks catkin.
export PATH="/usr/bin:/bin:$PATH"

build_packages=(
  g++ cmake ninja-build pkg-config ccache catkin ros-message-generation ros-message-runtime
  ros-std-msgs ros-geometry-msgs ros-sensor-msgs libroscpp-dev libroslib-dev libnodeletlib-dev
  pluginlib-dev libtf2-dev libtf2-ros-dev libtf2-msgs-dev libsensor-msgs-dev libstd-srvs-dev
  libgeometry-msgs-dev libnav-msgs-dev libdiagnostic-updater-dev libvisualization-msgs-dev librosbag-dev libeigen3-dev
  libyaml-cpp-dev nlohmann-json3-dev libcli11-dev libpcl-dev libarmadillo-dev libceres-dev
  libnanoflann-dev)
run_packages=(
  libnodeletlib-tools python3-roslaunch python3-rosbag librosbag-dev python3-rospy rosout rosbash
  rospack-tools python3-rosservice python3-geometry-msgs python3-sensor-msgs
  python3-nav-msgs python3-visualization-msgs
  python3-matplotlib python3-numpy)
view_packages=(rviz xvfb libgl1-mesa-dri imagemagick)
test_packages=(libgtest-dev librostest-dev python3-rostest catkin-lint)
bench_packages=(libbenchmark-dev libcgal-dev liboctomap-dev libopen3d-dev)

# The same for the demo and the tests, so that neither builds again what the other has built.
build_options=(-DCMAKE_BUILD_TYPE=Release -DLADAR_WARNINGS_AS_ERRORS=ON)

# fail MESSAGE: the one clear line, and a non-zero status.
fail() {
  echo "FAILED: $*" >&2
  exit 1
}

# install_missing PACKAGE...: apt is asked only when something is missing.
install_missing() {
  local package missing=()
  for package in "$@"; do
    dpkg-query -W -f '${Status}' "$package" 2>/dev/null | grep -q 'install ok installed' ||
      missing+=("$package")
  done
  [ "${#missing[@]}" -gt 0 ] || return 0
  local as_root=()
  [ "$(id -u)" -eq 0 ] || as_root=(sudo)
  echo "installing ${#missing[@]} packages: ${missing[*]}"
  mkdir -p build
  {
    "${as_root[@]}" apt-get update &&
      "${as_root[@]}" env DEBIAN_FRONTEND=noninteractive \
        apt-get install -y --no-install-recommends "${missing[@]}"
  } >build/apt.log 2>&1 || {
    tail -n 5 build/apt.log >&2
    fail "apt-get could not install ${missing[*]}; see build/apt.log"
  }
}

# run_logged LOG COMMAND...: silent unless it fails.
run_logged() {
  local log="$1"
  shift
  "$@" >"$log" 2>&1 || {
    grep -E -m 20 'error|Error|FAILED' "$log" >&2 || tail -n 20 "$log" >&2
    fail "'$*'; see $log"
  }
}

# build FOLDER TARGET [CMAKE-OPTION...]
build() {
  local folder="$1" target="$2"
  shift 2
  mkdir -p "$folder"
  run_logged "$folder/configure.log" cmake -S . -B "$folder" -G Ninja \
    -DPYTHON_EXECUTABLE=/usr/bin/python3 -DPython3_EXECUTABLE=/usr/bin/python3 \
    -DCMAKE_INSTALL_PREFIX="$PWD/$folder/.install" "$@"
  run_logged "$folder/build.log" ninja -C "$folder" "$target"
}
