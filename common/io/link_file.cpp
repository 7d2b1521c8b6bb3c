#include "common/io/link_file.h"

#include <atomic>
#include <optional>
#include <string>
#include <string_view>
#include <system_error>

#include "common/io/atomic_file.h"
#include "common/io/read_file.h"
#include "common/util/log.h"

namespace dadrl {
namespace {

namespace fs = std::filesystem;

constexpr std::string_view kMark = "dadrl link: ";
constexpr uint64_t kMaxBytes = 512;

// The name that a small file holds; nothing when it is no link of ours.
std::optional<std::string> NameIn(const fs::path& file) {
  std::error_code error;
  if (!fs::is_regular_file(file, error) || fs::file_size(file, error) > kMaxBytes) return std::nullopt;
  const auto text = ReadTextFile(file, kMaxBytes);
  if (!text || !text->starts_with(kMark) || !text->ends_with('\n')) return std::nullopt;
  std::string name = text->substr(kMark.size(), text->size() - kMark.size() - 1);
  // Never out of its folder.
  const bool plain =
      !name.empty() && name != "." && name != ".." && name.find_first_of("/\n") == std::string::npos;
  return plain ? std::optional(std::move(name)) : std::nullopt;
}

}  // namespace

Status LinkAtomically(const fs::path& link, const fs::path& target) {
  std::error_code error;
  const fs::file_status there = fs::symlink_status(link, error);
  if (fs::exists(there) && !fs::is_symlink(there) && !NameIn(link)) {
    return Fail(ErrorCode::kInvalidArgument, "{} is no link and is left alone; it would point to {}",
                link.string(), target.string());
  }
  Status linked = SymlinkAtomically(link, target);
  // A full or failing disk is no reason to do it another way.
  if (linked || linked.error().code != ErrorCode::kInternal) return linked;
  if (fs::is_symlink(there)) fs::remove(link, error);  // from before there were none: no file replaces it
  const Status written =
      WriteFileAtomically(link, std::string_view(fmt::format("{}{}\n", kMark, target.string())));
  if (!written) return linked;
  static std::atomic<bool> said{false};
  if (!said.exchange(true)) {
    spdlog::warn("{}: a small file names {} instead, and every command follows it", linked.error().message,
                 target.string());
  }
  return {};
}

fs::path FollowLinks(const fs::path& path) {
  fs::path followed;
  for (const fs::path& part : path) {
    followed /= part;
    if (const auto name = NameIn(followed)) followed.replace_filename(*name);
  }
  return followed;
}

}  // namespace dadrl
