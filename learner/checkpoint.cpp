#include "learner/checkpoint.h"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <string_view>

#include "common/config/config_schema.h"
#include "common/io/atomic_file.h"
#include "common/io/byte_io.h"
#include "common/io/checksum.h"
#include "common/io/file_reader.h"
#include "learner/version_reserve.h"

namespace dadrl {
namespace {

constexpr FileKind kKind{.magic = "DADRLCKP",
                         .name = "a checkpoint",
                         .format = 2,
                         .remedy = "remove it and resume from the checkpoint before it"};
// No checkpoint is longer: three times what the largest networks that a configuration allows come to.
constexpr uint64_t kMaxFileBytes = uint64_t{4} << 30;
constexpr uint32_t kMostBlocks = 65536;
// Magic, format, blocks and file length: readable whatever the rest is.
constexpr size_t kHeadBytes = 8 + 4 + 4 + 8;

template <typename T>
void PutVector(ByteWriter& writer, const std::vector<T>& values) {
  writer.Put<uint64_t>(values.size());
  writer.PutBytes(std::as_bytes(std::span(values)));
}

// Everything before the blocks' bytes.
std::vector<std::byte> EncodeHeader(const Checkpoint& checkpoint) {
  std::vector<std::byte> header;
  ByteWriter writer(header);
  kKind.PutHead(writer);
  writer.Put<uint32_t>(checkpoint.blocks.size());
  writer.Put(uint64_t{0});  // file length, known below
  writer.Put(checkpoint.updates);
  writer.Put(checkpoint.weights_version);
  writer.Put(checkpoint.trained_s);
  writer.Put(checkpoint.cpu_s);
  writer.Put(checkpoint.networks.front().layout_hash);
  writer.PutText(checkpoint.config_yaml);
  PutVector(writer, checkpoint.published_ns);
  PutVector(writer, checkpoint.networks.front().parameters);
  uint64_t block_bytes = 0;
  for (const Checkpoint::Block& block : checkpoint.blocks) {
    writer.PutText(block.name);
    writer.Put<uint64_t>(block.bytes.size());
    block_bytes += block.bytes.size();
  }
  const uint64_t length = header.size() + block_bytes + sizeof(uint64_t);
  std::memcpy(header.data() + kHeadBytes - sizeof(length), &length, sizeof(length));
  return header;
}

// What follows the head.
void ReadBody(FileReader& reader, uint32_t format, uint32_t blocks, Checkpoint& checkpoint) {
  checkpoint.updates = reader.Get<uint64_t>();
  checkpoint.weights_version = reader.Get<uint32_t>();
  checkpoint.trained_s = reader.Get<double>();
  if (format >= 2) checkpoint.cpu_s = reader.Get<double>();
  const auto layout_hash = reader.Get<uint64_t>();
  checkpoint.config_yaml = reader.GetText();
  checkpoint.published_ns = reader.GetVector<int64_t>();
  checkpoint.networks.push_back({std::string(kPolicyNetwork), layout_hash, reader.GetVector<float>()});
  std::vector<uint64_t> lengths;
  for (uint32_t i = 0; i < blocks && reader.ok(); ++i) {
    checkpoint.blocks.push_back({reader.GetText(), {}});
    lengths.push_back(reader.Get<uint64_t>());
  }
  for (size_t i = 0; i < lengths.size() && reader.ok(); ++i) {
    checkpoint.blocks[i].bytes = reader.GetVector<std::byte>(lengths[i]);
  }
}

// Numbers that a training can have come to.
bool IsPossible(const Checkpoint& checkpoint) {
  constexpr double kLongest = 1e12;  // s
  constexpr uint64_t kMostUpdates = uint64_t{1} << 50;
  // Times are subtracted from each other.
  const auto is_span = [](double seconds) { return seconds >= 0.0 && seconds <= kLongest; };
  const auto is_time = [](int64_t ns) { return ns >= 0; };
  return checkpoint.updates <= kMostUpdates && std::ranges::all_of(checkpoint.published_ns, is_time) &&
         is_span(checkpoint.trained_s) && is_span(checkpoint.cpu_s) &&
         checkpoint.weights_version <= kMaxWeightsVersion &&
         std::ranges::all_of(checkpoint.networks.front().parameters,
                             [](float value) { return std::isfinite(value); });
}

bool ShapesNetworks(const std::string& key) {
  return key.starts_with("model.") || key.starts_with("observation.") || key == "algorithm.name";
}

}  // namespace

void CaptureState(Algorithm& algorithm, Checkpoint& checkpoint) {
  const std::vector<StateBlock> state = algorithm.state();
  checkpoint.blocks.resize(state.size());
  for (size_t i = 0; i < state.size(); ++i) {
    checkpoint.blocks[i].name = state[i].name;
    checkpoint.blocks[i].bytes.assign(state[i].bytes.begin(), state[i].bytes.end());
  }
  const std::vector<NamedNetwork> networks = algorithm.networks();
  checkpoint.networks.resize(networks.size());
  for (size_t i = 0; i < networks.size(); ++i) {
    checkpoint.networks[i].name = networks[i].name;
    checkpoint.networks[i].layout_hash = networks[i].layout_hash;
    checkpoint.networks[i].parameters.assign(networks[i].parameters.begin(), networks[i].parameters.end());
  }
}

Status RestoreState(const Checkpoint& checkpoint, const std::filesystem::path& path, Algorithm& algorithm) {
  const std::vector<StateBlock> state = algorithm.state();
  if (state.size() != checkpoint.blocks.size()) {
    return Fail(
        ErrorCode::kCorrupt,
        "checkpoint {} holds {} blocks of state, {} are needed: another version of the program wrote it",
        path.string(), checkpoint.blocks.size(), state.size());
  }
  for (size_t i = 0; i < state.size(); ++i) {
    const Checkpoint::Block& block = checkpoint.blocks[i];
    if (block.name != state[i].name || block.bytes.size() != state[i].bytes.size()) {
      return Fail(ErrorCode::kCorrupt,
                  "checkpoint {}: block {} is '{}' of {} bytes, '{}' of {} is needed: another version of the "
                  "program wrote it",
                  path.string(), i, block.name, block.bytes.size(), state[i].name, state[i].bytes.size());
    }
  }
  for (size_t i = 0; i < state.size(); ++i) {
    std::copy(checkpoint.blocks[i].bytes.begin(), checkpoint.blocks[i].bytes.end(), state[i].bytes.begin());
  }
  return {};
}

Status SaveCheckpoint(const std::filesystem::path& path, const Checkpoint& checkpoint) {
  const std::vector<std::byte> header = EncodeHeader(checkpoint);
  Xxh3Stream hash;
  auto file = AtomicFile::Create(path);
  if (!file) return tl::unexpected<Error>(std::move(file.error()));
  hash.Add(header);
  DADRL_RETURN_IF_ERROR(file->Append(header));
  for (const Checkpoint::Block& block : checkpoint.blocks) {
    hash.Add(block.bytes);
    DADRL_RETURN_IF_ERROR(file->Append(block.bytes));
  }
  const uint64_t digest = hash.Digest();
  DADRL_RETURN_IF_ERROR(file->Append(std::as_bytes(std::span(&digest, 1))));
  return file->Commit();
}

Result<Checkpoint> LoadCheckpoint(const std::filesystem::path& path) {
  DADRL_ASSIGN_OR_RETURN(FileReader reader, FileReader::Open(path, kMaxFileBytes));
  DADRL_ASSIGN_OR_RETURN(const uint32_t format, reader.GetHead(kKind));
  const auto blocks = reader.Get<uint32_t>();
  const auto length = reader.Get<uint64_t>();
  if (length != reader.file_bytes() || blocks > kMostBlocks) {
    return Fail(ErrorCode::kCorrupt, "{} is damaged ({} bytes, {} were written, in {} blocks): {}",
                path.string(), reader.file_bytes(), length, blocks, kKind.remedy);
  }
  Checkpoint checkpoint;
  ReadBody(reader, format, blocks, checkpoint);
  DADRL_RETURN_IF_ERROR(reader.CheckEnd(kKind.remedy));
  if (!IsPossible(checkpoint)) {
    return Fail(ErrorCode::kCorrupt, "{} is damaged (no training comes to its numbers): {}", path.string(),
                kKind.remedy);
  }
  return checkpoint;
}

Status CheckSameNetworks(const Config& saved, const Config& now, const std::filesystem::path& path) {
  Config saved_copy = saved;
  Config now_copy = now;
  const std::vector<ConfigField> before = SchemaOf(saved_copy);
  const std::vector<ConfigField> after = SchemaOf(now_copy);
  std::vector<std::string> differences;
  for (size_t i = 0; i < before.size(); ++i) {
    const std::string was = FormatValue(before[i]);
    const std::string is = FormatValue(after[i]);
    if (ShapesNetworks(before[i].key) && was != is) {
      differences.push_back(fmt::format("{} (there {}, now {})", before[i].key, was, is));
    }
  }
  if (differences.empty()) return {};
  return Fail(ErrorCode::kInvalidArgument,
              "checkpoint {} is of other networks: {}; give the checkpoint's values or start a new run",
              path.string(), fmt::join(differences, ", "));
}

}  // namespace dadrl
