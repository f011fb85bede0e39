#!/bin/sh
# SPDX-License-Identifier: Apache-2.0
# A search by the cross-entropy method whose rollouts run in SHARDS parts, JOBS at a time, on this
# machine or, with GNU parallel and PARALLEL="--sshloginfile nodes", on several that share the
# folder. A part that dies is started again; the search has the bytes of `palpate train` on one
# machine.
#
#   SHARDS=16 JOBS=16 examples/cluster/cem.sh out/cem --iterations 40 --seed 3
set -eu
. "$(dirname "$0")/parts.sh"
out="$1"
shift
search() { "${PALPATE:-palpate}" train relocate --method cem --quiet "$@" --out "$out"; }
search "$@" --ask
log=/dev/null
while [ -e "$out/ask.jsonl" ]; do
  run_parts "${PALPATE:-palpate}" train relocate --method cem --quiet "$@" --out "$out" \
    --score "{}/$SHARDS"
  search "$@" --tell
done
