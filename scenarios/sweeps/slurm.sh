#!/bin/sh
# A sweep over a Slurm cluster: eight shards, each a task of an array, and their join when all of them are done.
#   sbatch --array=1-8 scenarios/sweeps/slurm.sh scenarios/sweeps/million.toml /shared/out
# A task that was ended, by a time limit or a lost node, is put back into the queue and continues where it was; by hand, the
# same line of sbatch does that too: shards that are done say so at once.
#SBATCH --job-name=trocar-sweep
#SBATCH --cpus-per-task=2
#SBATCH --mem-per-cpu=500M
#SBATCH --time=01:00:00
#SBATCH --requeue
#SBATCH --open-mode=append
set -eu
sweep=$1
out=${2:-out}
trocar sweep "$sweep" --out "$out" --quiet --threads "${SLURM_CPUS_PER_TASK:-1}" \
  --shard "${SLURM_ARRAY_TASK_ID:?start this with sbatch --array=1-N}/${SLURM_ARRAY_TASK_COUNT:?}"
# Then, once all tasks are done: trocar sweep merge OUT/NAME --out OUT
