#!/usr/bin/env bash
# Prints the benchmarks' JSON lines, one a figure, beside the physical limit or the peer measured in the same run; what
# runs, and how long it took, on standard error.
#
#   tests/bench/run.sh [NAME...]              without names: all; --list shows them
#   tests/bench/run.sh NAME -- ARGUMENT...    what `NAME -- --help` lists, for instance: replay_service -- inserts
set -euo pipefail
root=$(cd "$(dirname "${BASH_SOURCE[0]}")/../.." && pwd)
cd "$root"
bin=build/${PRESET:-release}/bin/bench
shopt -s nullglob

if [ "${1:-}" = --help ]; then
  sed -n '2,/^set/s/^# \{0,1\}//p' "${BASH_SOURCE[0]}"
  exit 0
fi
names=()
for file in "$bin"/*; do
  [ -x "$file" ] && names+=("${file##*/}")
done
[ ${#names[@]} -gt 0 ] || {
  echo "error: no benchmarks in $bin: cmake --preset release && cmake --build --preset release" >&2
  exit 1
}
if [ "${1:-}" = --list ]; then
  printf '%s\n' "${names[@]}"
  exit 0
fi
wanted=()
while [ $# -gt 0 ] && [ "$1" != -- ]; do
  [ -x "$bin/$1" ] || {
    echo "error: no benchmark '$1'; there are: ${names[*]}" >&2
    exit 2
  }
  wanted+=("$1")
  shift
done
[ ${#wanted[@]} -gt 0 ] || wanted=("${names[@]}")
[ $# -eq 0 ] || shift
[ $# -eq 0 ] || [ ${#wanted[@]} -eq 1 ] || {
  echo "error: arguments behind -- are for one benchmark, not for ${#wanted[@]}" >&2
  exit 2
}
number=0
for name in "${wanted[@]}"; do
  number=$((number + 1))
  echo "$name ($number of ${#wanted[@]})" >&2
  begin=$SECONDS
  "$bin/$name" "$@"
  echo "$name: $((SECONDS - begin)) s" >&2
done
