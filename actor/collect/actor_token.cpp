#include "actor/collect/actor_token.h"

#include <charconv>
#include <optional>
#include <random>
#include <string_view>
#include <system_error>

#include "common/io/atomic_file.h"
#include "common/io/read_file.h"
#include "common/util/log.h"

namespace dadrl {
namespace {

constexpr size_t kHexDigits = 16;  // of each half

std::optional<uint64_t> ParseHex(std::string_view digits) {
  uint64_t value = 0;
  const auto [end, error] = std::from_chars(digits.data(), digits.data() + digits.size(), value, 16);
  if (error != std::errc() || end != digits.data() + digits.size()) return std::nullopt;
  return value;
}

std::optional<LeaseToken> ReadToken(const std::filesystem::path& file) {
  const Result<std::string> text = ReadTextFile(file, 2 * kHexDigits + 1);
  if (!text || text->size() != 2 * kHexDigits + 1) return std::nullopt;
  const auto high = ParseHex(std::string_view(*text).substr(0, kHexDigits));
  const auto low = ParseHex(std::string_view(*text).substr(kHexDigits, kHexDigits));
  if (!high || !low) return std::nullopt;
  return LeaseToken{*high, *low};
}

LeaseToken RandomToken() {
  std::random_device device;
  const auto half = [&device] { return uint64_t{device()} << 32 | device(); };
  const uint64_t high = half();
  return {high, half()};
}

}  // namespace

LeaseToken KeptToken(const std::filesystem::path& run_directory, const std::string& name) {
  const std::filesystem::path file = run_directory / "incarnations" / (name + ".token");
  if (const auto token = ReadToken(file)) return *token;
  std::error_code ignored;  // what matters fails below as well
  std::filesystem::create_directories(file.parent_path(), ignored);
  const LeaseToken token = RandomToken();
  const std::string text = fmt::format("{:016x}{:016x}\n", token.high, token.low);
  const Status kept = WriteFileAtomically(file, std::string_view(text));
  if (!kept) spdlog::warn("{}", kept.error().message);
  return token;
}

}  // namespace dadrl
