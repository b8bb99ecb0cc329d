#!/usr/bin/env bash
# SPDX-License-Identifier: GPL-3.0-or-later
#SBATCH --job-name=synch
#SBATCH --array=1-40
#SBATCH --cpus-per-task=8
#SBATCH --mem-per-cpu=2G
#SBATCH --time=04:00:00
#
# The rows of a batch by an array of Slurm jobs, a contiguous part each; docs/batch.md tells how to prepare a cluster.
#
#     export SYNCH_PYTHON=/shared/synch/.venv/bin/python
#     array=$(sbatch --parsable farm/slurm.sh rows.jsonl /shared/out/rows)
#     sbatch --array=1 --dependency=afterany:"${array%%;*}" farm/slurm.sh rows.jsonl /shared/out/rows
#
# The second line does what the array has left, and writes the table and the contact sheet. Paths in the rows start from
# the folder in which sbatch is called.
set -euo pipefail
rows=$1 folder=$2
share=()
if [ "$SLURM_ARRAY_TASK_COUNT" -gt 1 ]; then
    share=(--share "$SLURM_ARRAY_TASK_ID/$SLURM_ARRAY_TASK_COUNT")
fi
# One thread of BLAS for each process, of which there are as many as cores.
export OPENBLAS_NUM_THREADS=1
exec srun "$SYNCH_PYTHON" -m synch_fields batch "$rows" --folder "$folder" --jobs "$SLURM_CPUS_PER_TASK" --quiet "${share[@]}"
