#include "common/util/isa.h"

#include <spdlog/spdlog.h>

#include <atomic>
#include <optional>
#include <string>

#include "common/util/enum_array.h"
#include "common/util/environment.h"
#include "common/util/shown.h"

namespace dadrl {
namespace {

constexpr EnumArray<Isa, std::string_view, 3> kNames = {"scalar", "avx2", "avx512"};

Isa InitialIsa() {
  const Isa best = DetectIsa();
  const std::optional<std::string> wanted = FromEnvironment(kIsaVariable);
  if (!wanted) return best;
  const auto isa = IsaFromName(*wanted);
  if (isa && *isa <= best) return *isa;
  spdlog::warn("{}={} is not an instruction set of this processor (scalar to {}); using {}", kIsaVariable,
               Shown(*wanted), IsaName(best), IsaName(best));
  return best;
}

std::atomic<Isa>& Choice() {
  static std::atomic<Isa> choice(InitialIsa());
  return choice;
}

}  // namespace

Isa DetectIsa() {
#if defined(__x86_64__)
  __builtin_cpu_init();
  const bool avx2 = __builtin_cpu_supports("avx2") && __builtin_cpu_supports("fma");
  const bool avx512 = __builtin_cpu_supports("avx512f") && __builtin_cpu_supports("avx512bw") &&
                      __builtin_cpu_supports("avx512dq") && __builtin_cpu_supports("avx512vl");
  if (avx2 && avx512) return Isa::kAvx512;
  if (avx2) return Isa::kAvx2;
#endif
  return Isa::kScalar;
}

Isa ActiveIsa() { return Choice().load(std::memory_order_relaxed); }

bool SetIsa(Isa isa) {
  if (isa > DetectIsa()) return false;
  Choice().store(isa, std::memory_order_relaxed);
  return true;
}

std::string_view IsaName(Isa isa) { return kNames[isa]; }

std::optional<Isa> IsaFromName(std::string_view name) {
  for (size_t i = 0; i < kNames.size(); ++i) {
    if (kNames[i] == name) return kNames.At(i);
  }
  return std::nullopt;
}

}  // namespace dadrl
