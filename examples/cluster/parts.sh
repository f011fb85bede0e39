# SPDX-License-Identifier: Apache-2.0
# To be read by the other recipes. run_parts COMMAND...: runs the command for each of SHARDS parts,
# JOBS at a time; {} in it is the part's number, and $log, also with {}, the file of what it prints.
# By GNU parallel or, where that is missing or PARTS_BY=xargs, by xargs on this machine alone. A
# part that dies is started again, twice at most.
: "${SHARDS:=8}"
run_parts() {
  if [ "${PARTS_BY:-parallel}" = parallel ] && command -v parallel >/dev/null; then
    seq "$SHARDS" | parallel --retries 3 --jobs "${JOBS:-100%}" "$@" '>' "$log"
  elif [ -n "${PARALLEL:-}" ]; then
    echo "PARALLEL is set, but GNU parallel is not installed, or PARTS_BY excludes it" >&2
    return 3
  else
    seq "$SHARDS" | xargs -P "${JOBS:-$(nproc)}" -I '{}' \
      sh -c 'log="$1"; shift; "$@" >"$log" || "$@" >"$log" || "$@" >"$log"' sh "$log" "$@"
  fi
}
