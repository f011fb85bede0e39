#!/bin/sh
# SPDX-License-Identifier: Apache-2.0
# An evaluation in SHARDS parts, JOBS at a time, on this machine or, with GNU parallel and
# PARALLEL="--sshloginfile nodes", on several that share the folder. A part that dies is started
# again and goes on where it was.
#
#   SHARDS=16 JOBS=8 examples/cluster/parallel.sh out/eval --object mug,box --trials 50 --seed 9000
set -eu
. "$(dirname "$0")/parts.sh"
out="$1"
shift
mkdir -p "$out"
log="$out/part{}.json"
run_parts "${PALPATE:-palpate}" eval --quiet --json "$@" --shard "{}/$SHARDS" --out "$out/part{}"
exec "${PALPATE:-palpate}" merge "$out"/part*/trials.jsonl --out "$out/whole"
