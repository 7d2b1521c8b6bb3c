#!/usr/bin/env bash
# Configures a project of one target a folder with links that are allowed and with links that are not.
#   wrong_links_test.sh CMAKE
set -euo pipefail
cmake=$1
root=$(cd "$(dirname "${BASH_SOURCE[0]}")/../.." && pwd)
project=$(mktemp -d)
trap 'rm -r "$project"' EXIT
readonly folders=(common proto replay learner actor deploy/lockstep deploy)

# configure [FOLDER LINKED]...: the project, with these links.
configure() {
  printf '%s\n' 'cmake_minimum_required(VERSION 3.25)' 'project(layers LANGUAGES NONE)' \
    "include($root/cmake/DadrlLayers.cmake)" >"$project/CMakeLists.txt"
  for folder in "${folders[@]}"; do
    mkdir -p "$project/$folder"
    echo "add_library(${folder##*/}_part INTERFACE)" >"$project/$folder/CMakeLists.txt"
    echo "add_subdirectory($folder)" >>"$project/CMakeLists.txt"
  done
  echo 'add_library(SUMO::libsumocpp INTERFACE IMPORTED GLOBAL)' >>"$project/actor/CMakeLists.txt"
  # shellcheck disable=SC2016
  echo 'dadrl_check_layers(${PROJECT_SOURCE_DIR})' >>"$project/CMakeLists.txt"
  while [ $# -gt 0 ]; do
    echo "target_link_libraries(${1##*/}_part INTERFACE $2)" >>"$project/$1/CMakeLists.txt"
    shift 2
  done
  output=$("$cmake" -S "$project" -B "$project/build" 2>&1)
}

accept() { configure "$@" || { printf '%s is refused:\n%s\n' "$*" "$output" && exit 1; }; }
refuse() {
  if configure "$@"; then
    echo "$* is accepted" && exit 1
  fi
  [[ $output == *"layer violation: ${1##*/}_part of"*"links $2 of"* ]] || { printf '%s\n' "$output" && exit 1; }
}

accept learner common_part learner proto_part actor SUMO::libsumocpp
accept deploy/lockstep learner_part deploy/lockstep actor_part deploy/lockstep replay_part
refuse common proto_part
refuse proto replay_part
refuse learner replay_part
refuse deploy actor_part
refuse deploy lockstep_part
refuse deploy/lockstep SUMO::libsumocpp
refuse replay SUMO::libsumocpp
