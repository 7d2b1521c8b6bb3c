// Which instruction set the numeric kernels run on. One binary holds them all and picks at run time.
#pragma once

#include <optional>
#include <string_view>

namespace dadrl::nn {

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

}  // namespace dadrl::nn
