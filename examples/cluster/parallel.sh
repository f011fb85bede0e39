#!/bin/sh
# SPDX-License-Identifier: Apache-2.0
# An evaluation in SHARDS parts by GNU parallel, JOBS at a time, on this machine or, with
# PARALLEL="--sshloginfile nodes", on several that share the folder. A part that dies is started
# again and goes on where it was.
#
#   SHARDS=16 JOBS=8 examples/cluster/parallel.sh out/eval --object mug,box --trials 50 --seed 9000
set -eu
out="$1"
shift
mkdir -p "$out"
seq "${SHARDS:-8}" | parallel --retries 3 --jobs "${JOBS:-100%}" \
  "${PALPATE:-palpate}" eval --quiet --json "$@" --shard "{}/${SHARDS:-8}" --out "$out/part{}" \
  '>' "$out/part{}.json"
exec "${PALPATE:-palpate}" merge "$out"/part*/trials.jsonl --out "$out/whole"
