#!/usr/bin/env bash
# An array of Slurm: one task per material. See docs/farms.md.
#
#     sbatch slurm.sh ../scenes/drop.toml frames
#
# A minute before the time is over, Slurm sends SIGTERM to this script, which passes it on. The run ends after its frame,
# and the task is queued again and continues.
#SBATCH --job-name=supple
#SBATCH --array=0-2
#SBATCH --cpus-per-task=2
#SBATCH --mem=1G
#SBATCH --time=01:00:00
#SBATCH --signal=B:TERM@60
#SBATCH --requeue
#SBATCH --open-mode=append
set -uo pipefail
scene=${1:?give a scene}
output=${2:?give a directory}
materials=(jelly flesh rubber)
material=${materials[$SLURM_ARRAY_TASK_ID]}

supple run "$scene" --output "$output/$material" --set "body.bust.material=$material" \
    --threads "${SLURM_CPUS_PER_TASK:-0}" --resume=auto --progress json &
run=$!
trap 'kill -TERM "$run"' TERM
wait "$run"
code=$?
# A signal ends `wait` before the run ends.
while kill -0 "$run" 2>/dev/null; do
    wait "$run"
    code=$?
done
# 143: the run was stopped by SIGTERM, and has a checkpoint.
if ((code == 143)); then
    scontrol requeue "${SLURM_ARRAY_JOB_ID}_${SLURM_ARRAY_TASK_ID}"
fi
exit "$code"
