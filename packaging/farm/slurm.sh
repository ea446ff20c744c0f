#!/bin/bash
# Index a folder on the machines of a SLURM cluster, each with its own part of the files:
#   sbatch --array=1-16 packaging/farm/slurm.sh /mnt/assets postgresql://farm@server/shapes
# The password belongs into ~/.pgpass. Run the same again after an interruption: what is stored is not read again.
#SBATCH --job-name=shapegoogle
#SBATCH --cpus-per-task=8
#SBATCH --mem=32G
#SBATCH --time=12:00:00
#SBATCH --requeue
set -u
folder=$1
library=$2

srun shapegoogle index "$folder" --library "$library" \
    --shard "$SLURM_ARRAY_TASK_ID/$SLURM_ARRAY_TASK_MAX" \
    --jobs "$SLURM_CPUS_PER_TASK" --log "shapegoogle-$SLURM_ARRAY_TASK_ID.log"
code=$?
# 1: everything is done, but some files could not be read; the log names them.
[ "$code" -eq 1 ] && exit 0
exit "$code"
