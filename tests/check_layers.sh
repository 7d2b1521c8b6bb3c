#!/usr/bin/env bash
# Folders may use only what stands above them (README, "Map"): holds includes and link targets to it.
# The one exception is deploy/lockstep, the training in a single process, which needs all three roles; nothing else in
# deploy may link it.
set -euo pipefail
root=$(cd "$(dirname "${BASH_SOURCE[0]}")/.." && pwd)
cd "${1:-$root}"
failures=0

# refuse FOLDER PATTERN REASON: no source or CMakeLists.txt of FOLDER may match PATTERN.
refuse() {
  local found
  if found=$(grep -rnE --exclude-dir=lockstep --include='*.h' --include='*.cpp' --include='CMakeLists.txt' "$2" "$1"); then
    printf 'layer violation: %s\n%s\n' "$3" "$found" >&2
    failures=$((failures + 1))
  fi
}

includes_of() { printf '#include "(%s)/' "$1"; }

refuse common "$(includes_of 'proto|replay|learner|actor|deploy|tests')" "common uses nothing above it"
refuse proto "$(includes_of 'replay|learner|actor|deploy|tests')" "proto uses common only"
refuse replay "$(includes_of 'learner|actor|deploy|tests')" "replay uses common and proto"
refuse learner "$(includes_of 'replay|actor|deploy|tests')" "learner uses common and proto"
refuse actor "$(includes_of 'replay|learner|deploy|tests')" "actor uses common and proto"
refuse deploy "$(includes_of 'replay|learner|actor|tests')" "deploy uses common and proto, and starts the others"
for folder in common proto replay learner deploy; do
  refuse "$folder" '(<|")libsumo/|SUMO::|sumocpp' "only actor links SUMO"
done

# Link targets: the library dadrl_NAME belongs to the folder that defines it.
declare -A owner=()
for folder in common proto replay learner actor deploy; do
  while read -r name; do
    owner[dadrl_$name]=$folder
  done < <(grep -rhoE --include=CMakeLists.txt 'dadrl_library\([a-z0-9_]+' "$folder" | sed 's/.*(//')
done
[ -n "${owner[dadrl_lockstep]:-}" ] && owner[dadrl_lockstep]=deploy/lockstep
declare -A allowed=([common]="common" [proto]="common proto" [replay]="common proto replay"
  [learner]="common proto learner" [actor]="common proto actor" [deploy]="common proto deploy")
for folder in "${!allowed[@]}"; do
  while IFS=: read -r file target; do
    from=${owner[$target]:-}
    [ -z "$from" ] && continue
    [[ $file == deploy/lockstep/* ]] && continue
    [[ " ${allowed[$folder]} " == *" $from "* ]] && continue
    echo "layer violation: $file links $target of $from" >&2
    failures=$((failures + 1))
  done < <(grep -roE --include=CMakeLists.txt 'dadrl_[a-z0-9_]+' "$folder")
done

[ "$failures" -eq 0 ] || exit 1
echo "every folder uses only those above it"
