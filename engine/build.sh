#!/usr/bin/env bash
# Installs the Debian packages that Scree needs, if any is missing, then configures and builds.
# Usage: engine/build.sh [--dir DIR] [--tests on|off] [--sanitize address|thread] [--target NAME]...
set -euo pipefail
root=$(cd "$(dirname "$0")/.." && pwd)
dir=$root/build tests=on sanitize="" targets=()

usage() { sed -n '2,3s/^# //p' "$0"; }
while [ $# -gt 0 ]; do
  case "$1" in
    --dir) dir=${2:?--dir needs a folder}; shift 2 ;;
    --tests) tests=${2:?--tests needs on or off}; shift 2 ;;
    --sanitize) sanitize=${2:?--sanitize needs address or thread}; shift 2 ;;
    --target) targets+=(--target "${2:?--target needs a name}"); shift 2 ;;
    --help|-h) usage; exit 0 ;;
    *) echo "engine/build.sh: unknown argument '$1'" >&2; usage >&2; exit 2 ;;
  esac
done

# A build folder that has tests keeps them: the game and the tests share one.
[ "$tests" = on ] || ! grep -qs '^SCREE_TESTS:BOOL=ON' "$dir/CMakeCache.txt" || tests=on

packages=(g++ cmake ninja-build ccache pkg-config python3 python3-glad libgl-dev libegl-dev libglfw3-dev
  libosmesa6-dev libglm-dev libtinygltf-dev libopenimageio-dev openimageio-tools libtbb-dev libmeshoptimizer-dev libimgui-dev libstb-dev
  libcli11-dev libspdlog-dev libfmt-dev nlohmann-json3-dev libgl1-mesa-dri libegl-mesa0)
[ "$tests" = off ] || packages+=(libgtest-dev libbullet-dev xvfb xauth xdotool)

missing=()
for package in "${packages[@]}"; do
  state=$(dpkg-query -W -f '${Status}' "$package" 2>/dev/null || true)
  [ "$state" = "install ok installed" ] || missing+=("$package")
done
if [ ${#missing[@]} -gt 0 ]; then
  echo "Installing: ${missing[*]}"
  sudo=""
  if [ "$(id -u)" != 0 ]; then
    command -v sudo >/dev/null || {
      echo "engine/build.sh: run as root, or install these packages first: ${missing[*]}" >&2; exit 1; }
    sudo=sudo
  fi
  $sudo apt-get update -qq
  DEBIAN_FRONTEND=noninteractive $sudo apt-get install -y -qq --no-install-recommends "${missing[@]}" >/dev/null
fi

# Clones in different folders share what ccache keeps.
export CCACHE_BASEDIR=$root CCACHE_NOHASHDIR=1
cmake -S "$root" -B "$dir" -G Ninja -DCMAKE_BUILD_TYPE=Release \
  -DSCREE_TESTS="${tests^^}" -DSCREE_SANITIZE="$sanitize" >"${TMPDIR:-/tmp}/scree_configure.$$" 2>&1 || {
  cat "${TMPDIR:-/tmp}/scree_configure.$$" >&2; rm -f "${TMPDIR:-/tmp}/scree_configure.$$"; exit 1; }
rm -f "${TMPDIR:-/tmp}/scree_configure.$$"
cmake --build "$dir" "${targets[@]}"
