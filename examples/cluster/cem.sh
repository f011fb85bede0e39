#!/bin/sh
# SPDX-License-Identifier: Apache-2.0
# A search by the cross-entropy method whose rollouts run in SHARDS parts by GNU parallel, JOBS at a
# time, on this machine or, with PARALLEL="--sshloginfile nodes", on several that share the folder.
# A part that dies is started again; the search has the bytes of `palpate train` on one machine.
#
#   SHARDS=16 JOBS=16 examples/cluster/cem.sh out/cem --iterations 40 --seed 3
set -eu
out="$1"
shift
search() { "${PALPATE:-palpate}" train relocate --method cem --quiet "$@" --out "$out"; }
search "$@" --ask
while [ -e "$out/ask.jsonl" ]; do
  seq "${SHARDS:-8}" | parallel --retries 3 --jobs "${JOBS:-100%}" \
    "${PALPATE:-palpate}" train relocate --method cem --quiet "$@" --out "$out" \
    --score "{}/${SHARDS:-8}" '>/dev/null'
  search "$@" --tell
done
