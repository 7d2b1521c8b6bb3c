#!/usr/bin/env bash
# Reproduces a row of docs/results.md from nothing, on a bare Debian 12: installs the packages, builds, trains with the
# scenario's recipe (deploy/config/scenarios/SCENARIO.yaml), evaluates the policy that the training chose among its last
# ones on 250 unseen episodes, records the result in docs/data/runs. A second run skips what is done; a stopped one goes on.
#
#   deploy/reproduce.sh SCENARIO|all [--seed S] [--run-dir DIR] [--ship] [-- further options of dadrl train]
#
# --ship also puts the policy into deploy/policies, as pretrained:SCENARIO.
set -euo pipefail
root=$(cd "$(dirname "${BASH_SOURCE[0]}")/.." && pwd)
cd "$root"

usage() { sed -n '2,8s/^# \{0,1\}//p' "$root/deploy/reproduce.sh"; }
wrong() { echo "error: $1" >&2; usage >&2; exit 2; }

scenario=
seed=1
run_dir=
record_options=()
train_options=()
while [ $# -gt 0 ]; do
  case $1 in
    --seed | --run-dir)
      [ $# -ge 2 ] || wrong "$1 needs a value"
      case $1 in
        --seed) seed=$2 ;;
        --run-dir) run_dir=$2 ;;
      esac
      shift 2
      ;;
    --ship) record_options+=(--ship); shift ;;
    --help | -h) usage; exit 0 ;;
    --) shift; train_options=("$@"); break ;;
    -*) wrong "unknown option '$1'" ;;
    *) [ -z "$scenario" ] || wrong "one scenario at a time"; scenario=$1; shift ;;
  esac
done
recipes=$(cd deploy/config/scenarios && printf '%s ' *.yaml | sed 's/\.yaml//g')
[ -n "$scenario" ] || wrong "which scenario? There are: $recipes"
recipe=deploy/config/scenarios/$scenario.yaml
[ -f "$recipe" ] || wrong "no recipe for '$scenario' (there are: $recipes)"
[[ $seed =~ ^[0-9]+$ ]] || wrong "--seed $seed is not a whole number"
name=$scenario-seed$seed
run_dir=${run_dir:-runs/$name}
[ ${#record_options[@]} -eq 0 ] || record_options+=("$scenario")

step() { printf '\n== %s\n' "$*"; }

step "1 of 4: packages"
deploy/install_packages.sh

step "2 of 4: build (build/release)"
[ -f build/release/build.ninja ] || cmake --preset release
cmake --build --preset release
dadrl=build/release/bin/dadrl

step "3 of 4: training $scenario, seed $seed, into $run_dir"
finished() { grep -qs '"state": "finished"' "$run_dir/results.json"; }
if finished; then
  echo "done before; for another training: --run-dir DIR, or remove $run_dir"
elif [ -e "$run_dir/config.yaml" ]; then
  "$dadrl" train "$scenario" --resume --run-dir "$run_dir" "${train_options[@]}"
else
  "$dadrl" train "$scenario" --config "$recipe" --seed "$seed" --run-dir "$run_dir" "${train_options[@]}"
fi
finished || {
  echo "stopped before the end; the same command goes on from there" >&2
  exit 1
}

step "4 of 4: evaluation on 250 unseen episodes of each scenario"
deploy/results/record_run.py "$run_dir" --name "$name" "${record_options[@]}"
deploy/results/make_docs.py
echo "the tables: docs/results.md"
