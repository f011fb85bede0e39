#!/bin/sh
# SPDX-License-Identifier: Apache-2.0
# An evaluation as an array of Slurm jobs: one part a job, on any nodes that share the folder. A job
# that is requeued goes on where it was.
#
#   sbatch --array=1-64 examples/cluster/slurm_array.sh out/eval --object mug --trials 640 --seed 9000
#   palpate merge out/eval/part*/trials.jsonl --out out/eval/whole     # once all have ended
#
#SBATCH --job-name=palpate
#SBATCH --cpus-per-task=1
#SBATCH --mem=2G
#SBATCH --requeue
set -eu
out="$1"
shift
exec "${PALPATE:-palpate}" eval --quiet "$@" --threads "${SLURM_CPUS_PER_TASK:-1}" \
  --shard "$SLURM_ARRAY_TASK_ID/$SLURM_ARRAY_TASK_COUNT" --out "$out/part$SLURM_ARRAY_TASK_ID"
