#!/usr/bin/env bash
# From a bare Debian 12 to a trained driver: installs the packages, builds, trains the unprotected left turn on a
# local cluster, evaluates the policy beside two baselines. A second run skips what is done.
#
#   deploy/quickstart.sh [--minutes M] [--run-dir DIR] [--episodes N] [-- further options of dadrl train]
set -euo pipefail
root=$(cd "$(dirname "${BASH_SOURCE[0]}")/.." && pwd)
cd "$root"

minutes=20
run_dir=runs/quickstart
episodes=100
train_options=()

usage() { sed -n '2,5s/^# \{0,1\}//p' "$root/deploy/quickstart.sh"; }

while [ $# -gt 0 ]; do
  case $1 in
    --minutes | --run-dir | --episodes)
      [ $# -ge 2 ] || { echo "error: $1 needs a value" >&2; exit 2; }
      case $1 in
        --minutes) minutes=$2 ;;
        --run-dir) run_dir=$2 ;;
        --episodes) episodes=$2 ;;
      esac
      shift 2
      ;;
    --help | -h) usage; exit 0 ;;
    --) shift; train_options=("$@"); break ;;
    *) echo "error: unknown option '$1'" >&2; usage >&2; exit 2 ;;
  esac
done
[[ $minutes =~ ^[0-9]+(\.[0-9]+)?$ ]] || { echo "error: --minutes $minutes is not a number" >&2; exit 2; }
[[ $episodes =~ ^[1-9][0-9]*$ ]] || { echo "error: --episodes $episodes is not a whole number" >&2; exit 2; }

step() { printf '\n== %s\n' "$*"; }

step "1 of 4: packages"
deploy/install_packages.sh

step "2 of 4: build (build/release)"
[ -f build/release/build.ninja ] || cmake --preset release
cmake --build --preset release --target dadrl_product
dadrl=build/release/bin/dadrl

step "3 of 4: training left_turn for $minutes minutes into $run_dir"
policy=$run_dir/checkpoints/best
results=$run_dir/results.json
finished() { grep -qs '"state": "finished"' "$results" && [ -e "$policy" ]; }
trained_s=$(sed -n 's/^ *"training_s": \([0-9.]*\).*/\1/p' "$results" 2>/dev/null || true)
if finished && awk "BEGIN { exit !(${trained_s:-0} >= 57 * $minutes) }"; then
  echo "done before; for another training: --run-dir DIR, or remove $run_dir"
elif [ -e "$run_dir/config.yaml" ]; then
  echo "going on with the run in $run_dir"
  "$dadrl" train left_turn --minutes "$minutes" --resume --run-dir "$run_dir" "${train_options[@]}"
else
  "$dadrl" train left_turn --minutes "$minutes" --run-dir "$run_dir" "${train_options[@]}"
fi
finished || {
  echo "stopped before the end; the same command goes on from there" >&2
  exit 1
}

step "4 of 4: evaluation on $episodes unseen episodes each: the policy, the paper's rule-based driver, chance"
groups=1
per_group=$episodes
if [ $((episodes % 50)) -eq 0 ]; then
  groups=$((episodes / 50))
  per_group=50
fi
for driver in "$policy" rdm random; do
  "$dadrl" evaluate --policy "$driver" --scenario left_turn --episodes "$per_group" --seeds "$groups"
done

cat <<END

== done
run:      $run_dir (config.yaml, checkpoints/, tensorboard/, logs/, episodes.csv)
results:  $run_dir/results.json
policy:   $policy
go on:    $dadrl train left_turn --resume --run-dir $run_dir --minutes MORE
END
