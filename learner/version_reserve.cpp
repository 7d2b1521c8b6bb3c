#include "learner/version_reserve.h"

#include <charconv>

#include "common/io/atomic_file.h"
#include "common/io/read_file.h"

namespace dadrl {
namespace {

// A restart skips at most this many numbers, which the staleness in versions then shows.
constexpr uint32_t kBlock = 16;

}  // namespace

Result<VersionReserve> VersionReserve::Open(const std::filesystem::path& directory) {
  const std::filesystem::path path = directory / "weights_version";
  const auto text = ReadTextFile(path, 64);
  if (!text && text.error().code == ErrorCode::kNotFound) return VersionReserve(path, 0);
  if (!text) return tl::unexpected<Error>(text.error());
  uint32_t highest = 0;
  const auto [end, error] = std::from_chars(text->data(), text->data() + text->size(), highest);
  const bool ends = std::string_view(end, text->data() + text->size()) == "\n";
  if (error != std::errc() || !ends || highest > kMaxWeightsVersion) {
    return Fail(
        ErrorCode::kCorrupt,
        "{} does not hold a version: write a number into it that is larger than every weights version of "
        "the run, and at most {}",
        path.string(), kMaxWeightsVersion);
  }
  return VersionReserve(path, highest);
}

Status VersionReserve::Use(uint32_t version) {
  if (version <= highest_) return {};
  const uint32_t highest = version + kBlock - 1;
  DADRL_RETURN_IF_ERROR(WriteFileAtomically(path_, fmt::format("{}\n", highest)));
  highest_ = highest;
  return {};
}

}  // namespace dadrl
