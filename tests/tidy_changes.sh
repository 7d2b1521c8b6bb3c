#!/usr/bin/env bash
# Runs clang-tidy on the sources of the product that the last commits changed, a changed header by the source of its
# name. Needs a build of the release preset.
#
#   tests/tidy_changes.sh [SINCE]     a commit: 5 before this one unless given
set -euo pipefail
cd "$(dirname "${BASH_SOURCE[0]}")/.."
readonly most=40  # about 20 s of a core each
commits=$(git rev-list --count HEAD)
since=${1:-HEAD~$((commits > 5 ? 5 : commits - 1))}

mapfile -t changed < <(git diff --name-only --diff-filter=d "$since" -- common proto replay learner actor deploy |
  grep -E '\.(h|cpp)$' | sed 's/\.h$/.cpp/' | sort -u)
sources=()
for source in "${changed[@]}"; do
  [ -f "$source" ] && grep -qF "/$source\"" build/release/compile_commands.json && sources+=("$source")
done
echo "${#sources[@]} sources changed since $since; looking at $((${#sources[@]} < most ? ${#sources[@]} : most))"
[ "${#sources[@]}" -eq 0 ] && exit 0
printf '%s\0' "${sources[@]:0:most}" | xargs -0 -n 1 -P "$(nproc)" clang-tidy --quiet -p build/release
