// Restoring a snapshot whose folder somebody else has had in hand. Input: a name for the snapshot, then
// entries, each a kind and a name.
#include <sys/stat.h>

#include <fstream>
#include <string>

#include "common/io/byte_io.h"
#include "replay/storage/segment_log.h"
#include "replay/storage/snapshot_folder.h"
#include "replay/storage/snapshot_restore.h"
#include "tests/common/io/temporary_folder.h"
#include "tests/fuzz/harness.h"

namespace dadrl::fuzz {
namespace {

namespace fs = std::filesystem;

enum Kind : uint8_t { kFile, kLink, kLinkToFolder, kFifo, kFolder, kKinds };

std::string NameOf(uint8_t number) {
  if (number == 0) return "state";
  return number < 10 ? SegmentLog::NameOf(number) : "file-" + std::to_string(number);
}

void Put(const fs::path& outside, const fs::path& path, Kind kind) {
  std::error_code taken;  // the first of a name counts
  if (fs::symlink_status(path, taken).type() != fs::file_type::not_found) return;
  switch (kind) {
    case kFile:
      std::ofstream(path) << "content";
      return;
    case kLink:
      return fs::create_symlink(outside / "secret", path, taken);
    case kLinkToFolder:
      return fs::create_directory_symlink(outside, path, taken);
    case kFifo:
      Require(mkfifo(path.c_str(), 0600) == 0);
      return;
    default:
      fs::create_directory(path, taken);
  }
}

// Only regular files, each of which came from the snapshot.
void CheckRestored(const fs::path& replay) {
  for (const fs::directory_entry& entry : fs::recursive_directory_iterator(replay)) {
    if (entry.symlink_status().type() == fs::file_type::directory) {
      Require(entry.path().filename() == "shard-0");
      continue;
    }
    Require(entry.symlink_status().type() == fs::file_type::regular);
    std::ifstream file(entry.path());
    Require(std::string(std::istreambuf_iterator<char>(file), {}) == "content");
  }
}

Bytes Input(const std::string& name, std::initializer_list<std::pair<Kind, uint8_t>> entries) {
  Bytes bytes;
  ByteWriter writer(bytes);
  writer.PutText(name);
  for (const auto& [kind, number] : entries) {
    writer.Put(static_cast<uint8_t>(kind));
    writer.Put(number);
  }
  return bytes;
}

}  // namespace

const int kMutants = 5000;

bool Check(std::span<std::byte> input) {
  const MemoryFolder root;
  const fs::path run = root.path() / "run";
  const fs::path outside = root.path() / "outside";
  const fs::path snapshot = SnapshotFolder(run, 0) / "mine";
  fs::create_directories(snapshot);
  fs::create_directories(outside);
  std::ofstream(outside / "secret") << "secret";
  ByteReader reader(input);
  const std::string name = reader.GetText();
  while (reader.ok() && reader.remaining() >= 2) {
    const auto kind = static_cast<Kind>(reader.Get<uint8_t>() % kKinds);
    Put(outside, snapshot / NameOf(reader.Get<uint8_t>()), kind);
  }
  const bool restored = RestoreSnapshot(run, name).has_value();
  Require(restored == fs::exists(run / "replay"));
  Require(!fs::exists(run / "replay.restored"));
  if (restored) CheckRestored(run / "replay");
  // Nothing happened outside.
  Require(std::distance(fs::directory_iterator(root.path()), {}) == 2);
  Require(std::distance(fs::directory_iterator(outside), {}) == 1);
  Require(fs::file_size(outside / "secret") == 6);
  return restored;
}

Seeds MakeSeeds() {
  return {
      .accepted = {Input("mine", {{kFile, 0}, {kFile, 1}, {kFile, 2}}),
                   Input("mine", {{kFile, 0}, {kFile, 1}, {kLink, 11}, {kFifo, 12}, {kFolder, 13}})},
      .refused = {Input("mine", {{kFile, 0}, {kLink, 1}}), Input("mine", {{kLink, 0}, {kFile, 1}}),
                  Input("mine", {{kFile, 0}, {kLinkToFolder, 1}}), Input("mine", {{kFile, 0}, {kFifo, 1}}),
                  Input("mine", {{kFile, 0}, {kFolder, 1}}), Input("../shard-0/mine", {{kFile, 0}}),
                  Input("", {{kFile, 0}}), Input("yours", {{kFile, 0}})}};
}

}  // namespace dadrl::fuzz
