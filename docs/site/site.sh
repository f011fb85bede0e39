# SPDX-License-Identifier: Apache-2.0
# Builds the documentation's site and its pictures. Part of ./dev, which sources it.
readonly docs_wheels=requirements/docs.txt

install_docs_tools() {
  install_debian_packages doxygen fonts-dejavu-extra
  is_intact docs && return
  say "installing what the documentation site is built with, by $docs_wheels"
  rm -rf "$deps/docs"
  python3 -m venv "$deps/docs" >&2
  pip_install "$deps/docs/bin/pip" "$docs_wheels" || no_wheels "$docs_wheels"
  note_installed docs "$docs_wheels" docs/lib
}

docs() {
  build
  install_docs_tools
  say "building the site"
  "$deps/docs/bin/python" docs/site/build.py "$deps/docs/bin/sphinx-build" \
    ./build/release/apps/palpate/palpate build/site "$(command -v doxygen)" ||
    { say "a page has an error, or a link that leads nowhere"; exit 1; }
  run_tests release -R '^docs\.'
  say "the site is build/site/html/index.html"
}

pictures() {
  if [ "${1:-}" != --list ]; then
    build release palpate
    command -v chromium >/dev/null || install_debian_packages chromium
  fi
  find_data
  if [ "${1:-}" = --list ]; then exec python3 docs/site/pictures.py --list; fi
  exec python3 docs/site/pictures.py ./build/release/apps/palpate/palpate "$@"
}
