#!/bin/sh
# Kernel objects are compiled for processors that may be absent. A function that such an object shares with others
# (a weak symbol) may be the one that the linker keeps for all, so each must name its instruction set.
# Usage: check_symbols.sh OBJECT...; objects other than *_avx2* and *_avx512* are not looked at.
set -eu
seen=
for object in "$@"; do
  case $object in
    *_avx512*) isa=avx512 ;;
    *_avx2*) isa=avx2 ;;
    *) continue ;;
  esac
  weak=$(nm --defined-only "$object" | awk '$2 ~ /^[VvWwu]$/ { print $3 }')
  shared=$(printf '%s' "$weak" | grep -v "$isa" || true)
  if [ -n "$shared" ]; then
    echo "$object shares:" && echo "$shared"
    exit 1
  fi
  case $seen in *"$isa "*) ;; *) seen="$seen$isa " ;; esac
done
[ "$(printf '%s' "$seen" | wc -w)" -eq 2 ] || { echo "expected the objects of avx2 and avx512, saw: $seen"; exit 1; }
