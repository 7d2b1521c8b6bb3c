#!/usr/bin/env bash
# On a bare Debian 12: installs the packages, checks layers, formatting and scripts, builds, runs every test.
#
#   tests/run.sh [--quick] [--with STAGE]... [--all] [further options of ctest]
#
#   --quick       leaves the tests labelled "long" out
#   --with STAGE  one more: gcc (g++ compiles everything too), asan, tsan (tests under sanitizers), fuzz, tidy
#   --all         all of them
#
# PRESET=gcc tests/run.sh uses another preset of CMakePresets.json. With CI=true a skipped test is a failure, unless the
# machine lacks what it misses (tests/check_skips.py). The last line says how many tests and checks passed and failed.
set -euo pipefail
root=$(cd "$(dirname "${BASH_SOURCE[0]}")/.." && pwd)
cd "$root"
. tests/stages.sh
. tests/sanitizers.sh
preset=${PRESET:-release}

more_stages=(gcc asan tsan fuzz tidy)
wanted=" "
ctest_options=()
while [ $# -gt 0 ]; do
  case $1 in
    --quick) ctest_options+=(--label-exclude '^long$') ;;
    --all) wanted=" ${more_stages[*]} " ;;
    --with)
      [[ " ${more_stages[*]} " == *" ${2:-} "* ]] || {
        echo "error: --with ${2:-}: no such stage; there are ${more_stages[*]}" >&2
        exit 2
      }
      wanted+="$2 "
      shift
      ;;
    --help | -h) sed -n '2,12s/^# \{0,1\}//p' tests/run.sh; exit 0 ;;
    *) ctest_options+=("$1") ;;
  esac
  shift
done

packages() { deploy/install_packages.sh tests/packages.txt; }

check_sources() {
  # Sources of the working tree; generated ones are elsewhere.
  find common proto replay learner actor deploy tests \( -name '*.h' -o -name '*.cpp' \) -print0 |
    xargs -0 clang-format --dry-run --Werror
  shellcheck --external-sources deploy/*.sh tests/*.sh tests/bench/*.sh .ci/run
}

# build PRESET [TARGET...]
build() {
  [ -f "build/$1/build.ninja" ] || cmake --preset "$1"
  cmake --build --preset "$1" ${2:+--target "${@:2}"}
}

# run_tests PRESET [OPTION OF CTEST...]: those of what is built.
run_tests() {
  local results=build/$1/tests.xml status=0 kind=() as=()
  [[ $1 == *san ]] && kind=(--sanitized) as=(with_fixed_addresses)
  "${as[@]}" ctest --preset "$1" --exclude-regex '_NOT_BUILT$' --output-junit "$root/$results" "${@:2}" || status=$?
  count_tests "$results"
  if [ "${CI:-}" = true ]; then
    tests/check_skips.py "${kind[@]}" "$results"
  fi
  return "$status"
}

# Every object, and no program: linking them a second time would show nothing.
compile_with_gcc() {
  [ -f build/gcc-quick/build.ninja ] || cmake --preset gcc-quick
  ninja -C build/gcc-quick -t targets all | sed -n 's/\.o: C[A-Z]*_COMPILER.*/.o/p' | xargs ninja -C build/gcc-quick
}

# What parses or stores what comes from outside, and the learner.
address_sanitizer() {
  have_room_for_shadow || return "$not_run"
  allow_for_refused_tracing
  cmake --preset asan -DDADRL_FUZZ=ON  # one build for these tests and the fuzzers
  build asan config_test io_test policy_file_test telemetry_bus_test telemetry_test experience_test evaluation_report_test \
    replay_table_test chunk_verifier_test periodic_tasks_test training_test learner_cluster_test algorithms_test model_test \
    deploy_monitor_test
  run_tests asan -j "$(nproc)"
}

# Whatever has threads: the replay's service, the fetcher, the writer, the supervisor and what they are made of.
thread_sanitizer() {
  have_room_for_shadow || return "$not_run"
  build tsan util_test nn_test port_test dds_test periodic_tasks_test batch_server_test command_server_test ingest_test lease_test \
    replay_service_test learner_cluster_test training_test actor_experience_test deploy_local_test
  run_tests tsan -j "$(nproc)"
}

# more STAGE NAME COMMAND [ARGUMENT...]: if it is wanted; what is not is said in the end.
left_out=()
more() {
  if [[ $wanted == *" $1 "* ]]; then stage "${@:2}"; else left_out+=("$1"); fi
}

stage "packages" packages
stage "sources: layers, formatting, scripts" check_sources
stage "build: $preset" build "$preset"
more gcc "g++ compiles everything" compile_with_gcc
more asan "address and undefined-behaviour sanitizers" address_sanitizer
more tsan "thread sanitizer" thread_sanitizer
more fuzz "fuzzers" tests/run_fuzzers.sh
more tidy "clang-tidy of what changed" tests/tidy_changes.sh
stage "tests: $preset" run_tests "$preset" "${ctest_options[@]}"
[ ${#left_out[@]} -eq 0 ] || printf '\n== left out; tests/run.sh --all runs them too: %s\n' "${left_out[*]}"
summarize
