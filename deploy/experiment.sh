#!/usr/bin/env bash
# One run of a controlled comparison: trains, evaluates on 200 unseen episodes, records the run for docs/experiments.md.
# A second call with the same names skips or goes on.
#
#   deploy/experiment.sh GROUP NAME SCENARIO [options of dadrl train]
#   deploy/experiment.sh n_step one left_turn --seed 1 --set algorithm.n_step=1 --set learner.max_updates=15000
set -euo pipefail
root=$(cd "$(dirname "${BASH_SOURCE[0]}")/.." && pwd)
cd "$root"

usage() { sed -n '2,6s/^# \{0,1\}//p' "$root/deploy/experiment.sh"; }
case ${1:-} in --help | -h) usage; exit 0 ;; esac
[ $# -ge 3 ] || { echo "error: GROUP, NAME and SCENARIO are needed" >&2; usage >&2; exit 2; }
group=$1
name=$2
scenario=$3
shift 3
for word in "$group" "$name"; do
  [[ $word =~ ^[a-z0-9_]+$ ]] || { echo "error: '$word' is not made of a-z, 0-9 and _" >&2; exit 2; }
done

dadrl=build/release/bin/dadrl
[ -x "$dadrl" ] || { echo "error: $dadrl is missing: cmake --preset release && cmake --build --preset release" >&2; exit 1; }
run_dir=runs/experiments/$group/$name
finished() { grep -qs '"state": "finished"' "$run_dir/results.json"; }
if finished; then
  echo "done before; for another run: remove $run_dir"
elif [ -e "$run_dir/config.yaml" ]; then
  "$dadrl" train "$scenario" --resume --run-dir "$run_dir"
else
  # The newest policy: runs of one length are compared as they end.
  "$dadrl" train "$scenario" --run-dir "$run_dir" --set evaluation.episodes=200 --set evaluation.candidates=1 "$@"
fi
finished || { echo "stopped before the end; the same command goes on from there" >&2; exit 1; }
deploy/results/record_run.py "$run_dir" --name "$name" --experiment "$group"
deploy/results/make_docs.py experiments
