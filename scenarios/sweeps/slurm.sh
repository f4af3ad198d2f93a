#!/bin/sh
# A sweep on a Slurm cluster: eight shards, each a task of an array. Join them when all tasks are done.
#   sbatch --array=1-8 scenarios/sweeps/slurm.sh scenarios/sweeps/million.toml /shared/out
# After a time limit or a lost node, Slurm puts the task back into the queue and it continues. The same sbatch command does
# this by hand; shards that are already complete end at once.
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
