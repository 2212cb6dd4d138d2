#!/usr/bin/env bash
# Several ranks of MPI against one process: tests/mpi.sh PROGRAM, which was built with `--features mpi`.
set -euo pipefail
program=$(realpath "$1")
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
cd "$folder"
# Open MPI refuses to run as root, and more ranks than cores, unless it is told to.
export OMPI_ALLOW_RUN_AS_ROOT=1 OMPI_ALLOW_RUN_AS_ROOT_CONFIRM=1 RAYON_NUM_THREADS=1
launch=(mpirun --oversubscribe --bind-to none -n)
render=("$program" render cornell --device cpu --integrator progressive --size 48x32 --spp 2 --photons 20000 --caustic-photons 10000 --k 40 --radius 0.2 --quiet)
same() { cmp "$1" "$2" || { echo "$1 and $2 differ"; exit 1; }; }

"${render[@]}" --passes 40 --aov albedo -o one.exr
"${launch[@]}" 3 "${render[@]}" --passes 40 --aov albedo -o three.exr
same one.exr three.exr

# One pass is split into tiles.
"${render[@]}" --passes 1 -o one-pass.exr
"${launch[@]}" 3 "${render[@]}" --passes 1 -o one-pass-of-three.exr
same one-pass.exr one-pass-of-three.exr

# What is wrong is said once and nothing is written.
if "${launch[@]}" 2 "${render[@]}" --passes 0 -o wrong.exr 2>errors; then echo "0 passes were rendered"; exit 1; fi
if "${launch[@]}" 2 sh -c 'exec "$0" "$@" --seed "$OMPI_COMM_WORLD_RANK"' "${render[@]}" --passes 2 -o wrong.exr 2>errors; then
    echo "two seeds were rendered"; exit 1
fi
test "$(grep -c '^error: rank 1 has another scene' errors)" = 1
test ! -e wrong.exr

# A rank is killed midway; the checkpoint holds what was finished, and another number of ranks goes on to the same bytes.
"${launch[@]}" 3 "${render[@]}" --passes 40 --aov albedo --checkpoint state -o killed.exr 2>errors &
job=$!
until [ -s state ]; do sleep 0.01; done
# The last of mpirun's children: not the root.
kill -KILL "$(pgrep -n -P $job)"
if wait $job; then echo "a killed rank was not noticed"; exit 1; fi
grep -q "signal 9 (Killed)" errors
test "$(grep -c '^error: rank 0 was told to stop.* checkpoint state holds .* with --resume goes on' errors)" = 1
test ! -e killed.exr || { cmp -s one.exr killed.exr && echo "the render was over before a rank was killed" && exit 1; }
"${launch[@]}" 2 "${render[@]}" --passes 40 --aov albedo --checkpoint state --resume -o killed.exr
same one.exr killed.exr
echo "three ranks, tiles, refusals and a killed rank: as one process"
