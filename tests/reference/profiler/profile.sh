#!/bin/sh
# `profile.sh STAGES OUT`: runs `launch` of this folder over STAGES, alone and under Nsight Compute, and leaves what they say in OUT.
set -e
cd "$(dirname "$0")"
nvidia-smi --query-gpu=name,driver_version --format=csv,noheader
ncu --version | tail -1
timeout 60 ./launch "$1" > "$2/launch.txt"
metrics=
for op in ld st; do for space in global local; do for what in requests sectors; do
    metrics=$metrics,l1tex__t_${what}_pipe_lsu_mem_${space}_op_$op.sum
done; done; done
theory=memory_l2_theoretical_sectors_global
ncu --clock-control none --metrics "${metrics#,}" --csv --page raw ./launch "$1" > "$2/hw.csv"
ncu --clock-control none --metrics $theory,${theory}_ideal --csv --page raw ./launch "$1" > "$2/source.csv"
