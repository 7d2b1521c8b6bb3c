#!/usr/bin/env bash
# Prints the benchmarks' JSON lines, one a figure, beside the physical limit or the peer measured in the same run.
#
#   tests/bench/run.sh [NAME...]     without names: all; --list shows them
set -euo pipefail
root=$(cd "$(dirname "${BASH_SOURCE[0]}")/../.." && pwd)
cd "$root"
bin=build/${PRESET:-release}/bin/bench
shopt -s nullglob

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
[ $# -eq 0 ] && set -- "${names[@]}"
for name in "$@"; do
  [ -x "$bin/$name" ] || {
    echo "error: no benchmark '$name'; there are: ${names[*]}" >&2
    exit 2
  }
done
for name in "$@"; do
  "$bin/$name"
done
