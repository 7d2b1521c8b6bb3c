# shellcheck shell=bash
# Stages of tests/run.sh: each runs although one before it failed, is timed, and has a line in the summary. A stage that
# the machine cannot run ends with $not_run: neither passed nor failed.
readonly not_run=77
stage_lines=()
stages_passed=0
stages_failed=0
counts=$(mktemp)  # "PASSED FAILED" of each run of tests
trap 'rm -f "$counts"' EXIT

# stage NAME COMMAND [ARGUMENT...]
stage() {
  local name=$1 began=$SECONDS status word=passed
  shift
  printf '\n== %s\n' "$name"
  set +e
  (set -e && "$@")
  status=$?
  set -e
  if [ "$status" -eq 0 ]; then
    stages_passed=$((stages_passed + 1))
  elif [ "$status" -eq "$not_run" ]; then
    word="not run"
  else
    stages_failed=$((stages_failed + 1))
    word=FAILED
  fi
  stage_lines+=("$(printf '%-45s %-7s %5d s' "$name" "$word" $((SECONDS - began)))")
  printf '== %s: %s after %d s\n' "$name" "$word" $((SECONDS - began))
}

# count_tests RESULTS.xml: adds what ctest wrote to the sum.
count_tests() {
  local passed failed
  passed=$(grep -c 'status="run"' "$1" || true)
  failed=$(grep -c 'status="fail"' "$1" || true)
  echo "$passed $failed" >>"$counts"
}

# Prints a line for each stage and the sum of tests and stages; exits with 1 when any failed.
summarize() {
  printf '\n== summary\n'
  printf '%s\n' "${stage_lines[@]}"
  awk -v passed="$stages_passed" -v failed="$stages_failed" \
    '{ passed += $1; failed += $2 } END { printf "%d passed, %d failed\n", passed, failed }' "$counts"
  [ "$stages_failed" -eq 0 ] || exit 1
}
