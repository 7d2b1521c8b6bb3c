#!/usr/bin/env bash
# Runs every fuzzer (tests/fuzz/README.md) under the address sanitizer, for a fixed number of executions from its seeds.
#
#   tests/run_fuzzers.sh [EXECUTIONS]     of each, 20000 unless given
set -euo pipefail
cd "$(dirname "${BASH_SOURCE[0]}")/.."
. tests/sanitizers.sh
export executions=${1:-20000}

have_room_for_shadow || exit 77  # tests/stages.sh
allow_for_refused_tracing
cmake --preset asan -DDADRL_FUZZ=ON
cmake --build --preset asan --target dadrl_fuzzers
work=$(mktemp -d)
export work
trap 'rm -rf "$work"' EXIT

run_fuzzer() {
  local name
  name=$(basename "$1")
  mkdir "$work/$name"
  if with_fixed_addresses "$1" -runs="$executions" -seed=1 -timeout=60 -artifact_prefix="build/asan/$name-" "$work/$name" \
    >"$work/$name.log" 2>&1; then
    echo "$name: $(tail -1 "$work/$name.log")"
  else
    echo "$name: FAILED" && tail -60 "$work/$name.log"
    return 1
  fi
}
export -f run_fuzzer with_fixed_addresses
printf '%s\0' build/asan/bin/fuzz_* | xargs -0 -P "$(nproc)" -I{} bash -c "run_fuzzer {}"
