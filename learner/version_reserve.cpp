#include "learner/version_reserve.h"

#include "common/io/number_file.h"

namespace dadrl {
namespace {

// A restart skips at most this many numbers, which the staleness in versions then shows.
constexpr uint32_t kBlock = 16;

}  // namespace

Result<VersionReserve> VersionReserve::Open(const std::filesystem::path& directory) {
  const std::filesystem::path path = directory / "weights_version";
  const Result<uint64_t> number = ReadNumber(path);
  if (!number && number.error().code == ErrorCode::kNotFound) return VersionReserve(path, 0);
  if (!number && number.error().code != ErrorCode::kCorrupt) return tl::unexpected<Error>(number.error());
  if (!number || *number > kMaxWeightsVersion) {
    return Fail(
        ErrorCode::kCorrupt,
        "{} does not hold a version: write a number into it that is larger than every weights version of "
        "the run, and at most {}",
        path.string(), kMaxWeightsVersion);
  }
  return VersionReserve(path, static_cast<uint32_t>(*number));
}

Status VersionReserve::Use(uint32_t version) {
  if (version <= highest_) return {};
  const uint32_t highest = version + kBlock - 1;
  DADRL_RETURN_IF_ERROR(WriteNumber(path_, highest));
  highest_ = highest;
  return {};
}

}  // namespace dadrl
