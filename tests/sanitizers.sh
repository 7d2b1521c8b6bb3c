# shellcheck shell=bash
# What the sanitizers of clang 14 need from the machine; to be sourced.

# Whether their shadow memory finds its place: addresses have at most 28 random bits, or can be fixed.
have_room_for_shadow() {
  local bits
  bits=$(cat /proc/sys/vm/mmap_rnd_bits 2>/dev/null || echo 28)
  [ "$bits" -le 28 ] || setarch --addr-no-randomize true 2>/dev/null && return
  echo "not run: addresses have $bits random bits here, sanitizers bear 28, and setarch --addr-no-randomize is refused"
  return 1
}

# with_fixed_addresses COMMAND [ARGUMENT...]: and so with all that it starts, unless that is refused.
with_fixed_addresses() {
  if setarch --addr-no-randomize true 2>/dev/null; then setarch --addr-no-randomize "$@"; else "$@"; fi
}

# Leaks are looked for by tracing oneself, which a container may refuse: then everything else is looked for.
allow_for_refused_tracing() {
  local folder status=0
  folder=$(mktemp -d)
  echo 'int main() {}' | clang++ -fsanitize=address -x c++ - -o "$folder/empty"
  with_fixed_addresses "$folder/empty" 2>"$folder/said" || status=$?
  rm -r "$folder"
  [ "$status" -eq 0 ] && return
  echo "leaks are not looked for: a process may not trace itself here"
  export ASAN_OPTIONS=detect_leaks=0
}
