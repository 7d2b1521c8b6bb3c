// The name of a snapshot, which becomes a part of a path.
#include <algorithm>
#include <cctype>
#include <filesystem>
#include <string>

#include "replay/storage/snapshot_folder.h"
#include "tests/fuzz/harness.h"

namespace dadrl::fuzz {
namespace {

Bytes Input(const std::string& name) {
  const auto bytes = std::as_bytes(std::span(name));
  return {bytes.begin(), bytes.end()};
}

}  // namespace

const int kMutants = 200000;

bool Check(std::span<std::byte> input) {
  const std::string name(reinterpret_cast<const char*>(input.data()), input.size());
  const Status checked = CheckSnapshotName(name);
  const auto printable = [](unsigned char c) { return c >= ' ' && c != 0x7f; };
  if (!checked) {
    Require(std::ranges::all_of(checked.error().message, printable));
    Require(checked.error().message.size() < 400);
    return false;
  }
  // It names one folder, and that where it belongs.
  const std::filesystem::path folder = "/run/snapshots/shard-0";
  const std::filesystem::path path = (folder / name).lexically_normal();
  Require(path.parent_path() == folder && path.filename() == name && name.size() <= 64);
  Require(PartialSnapshot(path) != path && std::ranges::all_of(name, printable));
  return true;
}

Seeds MakeSeeds() {
  Seeds seeds;
  for (const std::string& name :
       {std::string("mine"), std::string("20260131T235959Z"), std::string("a-b_c.d")}) {
    seeds.accepted.push_back(Input(name));
  }
  for (const std::string& name :
       {std::string("../x"), std::string("/etc"), std::string(), std::string("."), std::string("a/b"),
        std::string("x.partial"), std::string("a\n\x1b[2J"), std::string(300, 'x'), std::string(1, '\0')}) {
    seeds.refused.push_back(Input(name));
  }
  return seeds;
}

}  // namespace dadrl::fuzz
