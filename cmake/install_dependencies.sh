#!/usr/bin/env bash
# Installs what facetloc needs on Debian 12: compiler, CMake, PCL and what comes with it, test tools. Works as root and
# with sudo, asks nothing, and does nothing when everything is there.
set -euo pipefail

packages=(g++ cmake ninja-build ccache
          libpcl-dev libboost-program-options-dev libsqlite3-dev libpng-dev libjpeg-dev libtiff-dev libdeflate-dev liblz4-dev libzstd-dev libbz2-dev
          libfmt-dev libjsoncpp-dev libyaml-cpp-dev libceres-dev libembree-dev libopenmpi-dev openmpi-bin libjs-three libjs-chart.js
          python3-dev pybind11-dev python3-numpy python3-pytest python3-matplotlib python3-pil
          libgtest-dev libgmock-dev libbenchmark-dev
          help2man xvfb xauth)
packages+=("$@")  # more packages by name, such as clang-format

missing=()
for package in "${packages[@]}"; do
  [ "$(dpkg-query -W -f '${db:Status-Status}' "$package" 2>/dev/null)" = installed ] || missing+=("$package")
done
if [ ${#missing[@]} -eq 0 ]; then
  echo "install_dependencies: all packages are installed"
  exit 0
fi

as_root=()
if [ "$(id -u)" -ne 0 ]; then
  command -v sudo >/dev/null || { echo "install_dependencies: run as root, or install sudo" >&2; exit 1; }
  as_root=(sudo)
fi
echo "install_dependencies: installing ${missing[*]} (PCL brings about 500 MB)"
export DEBIAN_FRONTEND=noninteractive
"${as_root[@]}" apt-get update -qq
"${as_root[@]}" env DEBIAN_FRONTEND=noninteractive apt-get install -y -qq --no-install-recommends "${missing[@]}" >/dev/null
echo "install_dependencies: done"
