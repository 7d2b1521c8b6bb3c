#!/usr/bin/env bash
# Runs clang-tidy on the sources of the product that the last commits changed, a changed header by the source of its
# name. Where many changed it takes some of them, others for each commit. Needs a build of the release preset.
#
#   tests/tidy_changes.sh [SINCE]     a commit: 50 before this one unless given
#
# A shallow clone fetches those commits; where that fails every source counts as changed.
set -euo pipefail
cd "$(dirname "${BASH_SOURCE[0]}")/.."
readonly depth=50
readonly most=40  # about 10 s of a core each

if [ $# -eq 0 ] && [ "$(git rev-parse --is-shallow-repository)" = true ]; then
  timeout 60 git fetch --quiet --deepen="$depth" </dev/null 2>/dev/null || echo "the commits before this one cannot be fetched"
fi
commits=$(git rev-list --first-parent --count HEAD)
if [ $# -gt 0 ]; then
  since=$1
elif [ "$commits" -gt 1 ]; then
  since=$(git rev-parse --short "HEAD~$((commits > depth ? depth : commits - 1))")
else
  since=$(git hash-object -t tree /dev/null)  # the empty tree
fi

mapfile -t changed < <(git diff --name-only --diff-filter=d "$since" -- common proto replay learner actor deploy |
  grep -E '\.(h|cpp)$' | sed 's/\.h$/.cpp/' | sort -u | shuf --random-source=<(yes "$(git rev-parse HEAD)"))
sources=()
for source in "${changed[@]}"; do
  [ -f "$source" ] && grep -qF "/$source\"" build/release/compile_commands.json && sources+=("$source")
done
echo "${#sources[@]} sources changed since $since, with $commits commits at hand;" \
  "looking at $((${#sources[@]} < most ? ${#sources[@]} : most))"
[ "${#sources[@]}" -eq 0 ] && exit 0
printf '%s\0' "${sources[@]:0:most}" | xargs -0 -n 1 -P "$(nproc)" clang-tidy --quiet -p build/release
