// Which instruction set the kernels run on: one binary holds them all and picks at run time.
#pragma once

#include <optional>
#include <string_view>

namespace dadrl {

// Ordered: a processor that runs one also runs those before it.
enum class Isa { kScalar, kAvx2, kAvx512 };

// The best instruction set that this processor and its operating system support and that was compiled in.
Isa DetectIsa();

// The instruction set in use: what SetIsa chose, else the environment variable DADRL_ISA (scalar, avx2 or
// avx512; one that is unknown or unsupported here is refused with a warning), else DetectIsa(). Any thread.
Isa ActiveIsa();

// Chooses for the whole process; false, and no change, if this processor lacks it. Any thread, but not
// between a forward pass and its backward pass: each instruction set lays its activations out in its own way.
bool SetIsa(Isa isa);

std::string_view IsaName(Isa isa);  // "scalar", "avx2", "avx512"
std::optional<Isa> IsaFromName(std::string_view name);

// What a kernel has for `isa` (functions or tables, of one type): every kernel chooses by it. Other
// processors than x86-64 have the portable one alone; the other arguments need not exist there.
#if defined(__x86_64__)
#define DADRL_FOR_ISA(isa, portable, avx2, avx512) \
  ((isa) == ::dadrl::Isa::kAvx512 ? (avx512) : (isa) == ::dadrl::Isa::kAvx2 ? (avx2) : (portable))
#else
#define DADRL_FOR_ISA(isa, portable, avx2, avx512) (static_cast<void>(isa), (portable))
#endif

}  // namespace dadrl
