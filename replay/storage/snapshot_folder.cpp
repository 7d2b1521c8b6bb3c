#include "replay/storage/snapshot_folder.h"

#include <sys/stat.h>

#include <algorithm>
#include <array>
#include <cctype>
#include <cerrno>
#include <cstdio>
#include <ctime>
#include <set>
#include <string_view>
#include <system_error>

#include "common/io/io_error.h"
#include "common/util/shown.h"

namespace dadrl {
namespace {

namespace fs = std::filesystem;

constexpr std::string_view kShape = "00000000T000000Z";  // of an automatic name
constexpr std::string_view kPartial = ".partial";

bool IsAutomatic(const std::string& name) {
  return std::equal(name.begin(), name.end(), kShape.begin(), kShape.end(), [](char c, char shape) {
    return shape == '0' ? std::isdigit(static_cast<unsigned char>(c)) != 0 : c == shape;
  });
}

std::vector<std::string> NamesIn(const fs::path& folder) {
  std::vector<std::string> names;
  std::error_code error;
  for (const fs::directory_entry& entry : fs::directory_iterator(folder, error)) {
    names.push_back(entry.path().filename().string());
  }
  return names;
}

Status Remove(const fs::path& folder) {
  std::error_code error;
  fs::remove_all(folder, error);
  if (error) return tl::unexpected(IoError("remove", folder, error.value()));
  return {};
}

}  // namespace

fs::path SnapshotFolder(const fs::path& run_directory, uint32_t shard) {
  return run_directory / "snapshots" / fmt::format("shard-{}", shard);
}

fs::path PartialSnapshot(const fs::path& snapshot) {
  fs::path partial = snapshot;
  return partial += kPartial;
}

Status CheckSnapshotName(const std::string& name) {
  const bool plain = std::all_of(name.begin(), name.end(), [](unsigned char c) {
    return std::isalnum(c) != 0 || c == '-' || c == '_' || c == '.';
  });
  if (plain && !name.empty() && name.size() <= 64 && name.front() != '.' && !name.ends_with(kPartial)) {
    return {};
  }
  return Fail(
      ErrorCode::kInvalidArgument,
      "snapshot name '{}' is not 1 to 64 letters, digits, '-', '_' or '.' (not in front, not .partial at "
      "the end)",
      Shown(name));
}

std::string AutomaticSnapshotName(int64_t wall_time_ns) {
  const std::time_t seconds = wall_time_ns / 1'000'000'000;
  std::tm utc{};
  gmtime_r(&seconds, &utc);
  std::array<char, 32> text{};
  const size_t length = std::strftime(text.data(), text.size(), "%Y%m%dT%H%M%SZ", &utc);
  return {text.data(), length};
}

std::string NextSnapshotName(const fs::path& folder, int64_t wall_time_ns) {
  std::string newest;
  for (const std::string& name : NamesIn(folder)) {
    if (IsAutomatic(name)) newest = std::max(newest, name);
  }
  std::string next = AutomaticSnapshotName(wall_time_ns);
  if (next > newest) return next;
  std::tm utc{};
  if (strptime(newest.c_str(), "%Y%m%dT%H%M%SZ", &utc) == nullptr) return next;
  return AutomaticSnapshotName((timegm(&utc) + 1) * 1'000'000'000);
}

SnapshotUse UseOfSnapshots(const fs::path& folder, const fs::path& shard) {
  SnapshotUse use;
  std::set<ino_t> counted;  // links do not cross file systems, so the number alone tells files apart
  const auto visit = [&](const fs::path& directory, bool counts) {
    std::error_code error;
    for (const fs::directory_entry& entry : fs::directory_iterator(directory, error)) {
      struct stat status {};
      if (lstat(entry.path().c_str(), &status) != 0 || !S_ISREG(status.st_mode)) continue;
      if (counted.insert(status.st_ino).second && counts) use.bytes += static_cast<uint64_t>(status.st_size);
    }
  };
  visit(shard, false);
  std::error_code error;
  for (const fs::directory_entry& entry : fs::directory_iterator(folder, error)) {
    if (entry.symlink_status(error).type() != fs::file_type::directory) continue;
    ++use.snapshots;
    visit(entry.path(), true);
  }
  return use;
}

Status RemoveOldSnapshots(const fs::path& folder, int kept) {
  std::vector<std::string> names = NamesIn(folder);
  std::erase_if(names, [](const std::string& name) { return !IsAutomatic(name); });
  std::sort(names.begin(), names.end());
  const size_t surplus = names.size() - std::min(names.size(), static_cast<size_t>(kept));
  for (size_t i = 0; i < surplus; ++i) {
    const fs::path snapshot = folder / names[i];
    const fs::path partial = PartialSnapshot(snapshot);
    DADRL_RETURN_IF_ERROR(Remove(partial));
    if (rename(snapshot.c_str(), partial.c_str()) != 0) {
      return tl::unexpected(IoError("rename", snapshot, errno));
    }
    DADRL_RETURN_IF_ERROR(Remove(partial));
  }
  return {};
}

Status RemovePartialSnapshots(const fs::path& folder) {
  for (const std::string& name : NamesIn(folder)) {
    if (name.ends_with(kPartial)) DADRL_RETURN_IF_ERROR(Remove(folder / name));
  }
  return {};
}

}  // namespace dadrl
