// Register tiles are arrays whose loops must vanish at compile time; this asks for it.
#pragma once

#if defined(__clang__)
#define DADRL_UNROLL _Pragma("clang loop unroll(full)")
#else
#define DADRL_UNROLL _Pragma("GCC unroll 64")
#endif

#define DADRL_INLINE inline __attribute__((always_inline))
