#!/usr/bin/env bash
# On a bare Debian 12: installs the packages, builds, checks the layers and the formatting, runs every test.
#
#   tests/run.sh [--quick] [further options of ctest]     --quick leaves the tests labelled "long" out
#
# PRESET=gcc tests/run.sh uses another preset of CMakePresets.json.
set -euo pipefail
root=$(cd "$(dirname "${BASH_SOURCE[0]}")/.." && pwd)
cd "$root"
preset=${PRESET:-release}

ctest_options=()
for argument in "$@"; do
  case $argument in
    --quick) ctest_options+=(--label-exclude '^long$') ;;
    --help | -h) sed -n '2,6s/^# \{0,1\}//p' tests/run.sh; exit 0 ;;
    *) ctest_options+=("$argument") ;;
  esac
done

deploy/install_packages.sh
echo "== layers"
tests/check_layers.sh
echo "== formatting"
# Sources of the working tree; generated ones are elsewhere.
find common proto replay learner actor deploy tests \( -name '*.h' -o -name '*.cpp' \) -print0 |
  xargs -0 clang-format --dry-run --Werror
echo "== scripts"
shellcheck deploy/*.sh tests/*.sh tests/bench/*.sh .ci/run
echo "== build ($preset)"
[ -f "build/$preset/build.ninja" ] || cmake --preset "$preset"
cmake --build --preset "$preset"
echo "== tests"
ctest --preset "$preset" "${ctest_options[@]}"
