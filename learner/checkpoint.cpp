#include "learner/checkpoint.h"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <string_view>

#include "common/config/config_schema.h"
#include "common/io/atomic_file.h"
#include "common/io/byte_io.h"
#include "common/io/checksum.h"
#include "common/io/read_file.h"
#include "learner/version_reserve.h"

namespace dadrl {
namespace {

constexpr std::string_view kMagic = "DADRLCKP";
constexpr uint32_t kFormat = 1;
constexpr uint64_t kMaxFileBytes = uint64_t{16} << 30;
// Magic, format, blocks and file length: readable whatever the rest is.
constexpr size_t kHeadBytes = 8 + 4 + 4 + 8;
constexpr std::string_view kRemedy = "remove it and resume from the checkpoint before it";

tl::unexpected<Error> Damaged(const std::filesystem::path& path, std::string_view what) {
  return Fail(ErrorCode::kCorrupt, "checkpoint {} is damaged ({}): {}", path.string(), what, kRemedy);
}

template <typename T>
void PutVector(ByteWriter& writer, const std::vector<T>& values) {
  writer.Put(static_cast<uint64_t>(values.size()));
  writer.PutBytes(std::as_bytes(std::span(values)));
}

template <typename T>
std::vector<T> GetVector(ByteReader& reader) {
  const auto count = reader.Get<uint64_t>();
  // A count that overflows the product must not look small.
  const std::span<const std::byte> bytes =
      reader.GetBytes(count > reader.remaining() ? UINT64_MAX : count * sizeof(T));
  std::vector<T> values(bytes.size() / sizeof(T));
  if (!values.empty()) std::memcpy(values.data(), bytes.data(), bytes.size());
  return values;
}

// Everything before the blocks' bytes.
std::vector<std::byte> EncodeHeader(const Checkpoint& checkpoint) {
  std::vector<std::byte> header;
  ByteWriter writer(header);
  writer.PutBytes(std::as_bytes(std::span(kMagic)));
  writer.Put(kFormat);
  writer.Put(static_cast<uint32_t>(checkpoint.blocks.size()));
  writer.Put(uint64_t{0});  // file length, known below
  writer.Put(checkpoint.updates);
  writer.Put(checkpoint.weights_version);
  writer.Put(checkpoint.trained_s);
  writer.Put(checkpoint.layout_hash);
  writer.PutText(checkpoint.config_yaml);
  PutVector(writer, checkpoint.published_ns);
  PutVector(writer, checkpoint.policy);
  uint64_t block_bytes = 0;
  for (const Checkpoint::Block& block : checkpoint.blocks) {
    writer.PutText(block.name);
    writer.Put(static_cast<uint64_t>(block.bytes.size()));
    block_bytes += block.bytes.size();
  }
  const uint64_t length = header.size() + block_bytes + sizeof(uint64_t);
  std::memcpy(header.data() + kHeadBytes - sizeof(length), &length, sizeof(length));
  return header;
}

// The body of a file whose checksum holds.
bool DecodeBody(ByteReader& reader, uint32_t blocks, Checkpoint& checkpoint) {
  checkpoint.updates = reader.Get<uint64_t>();
  checkpoint.weights_version = reader.Get<uint32_t>();
  checkpoint.trained_s = reader.Get<double>();
  checkpoint.layout_hash = reader.Get<uint64_t>();
  checkpoint.config_yaml = reader.GetText();
  checkpoint.published_ns = GetVector<int64_t>(reader);
  checkpoint.policy = GetVector<float>(reader);
  std::vector<uint64_t> lengths;
  for (uint32_t i = 0; i < blocks && reader.ok(); ++i) {
    checkpoint.blocks.push_back({reader.GetText(), {}});
    lengths.push_back(reader.Get<uint64_t>());
  }
  for (size_t i = 0; i < lengths.size() && reader.ok(); ++i) {
    const std::span<const std::byte> bytes = reader.GetBytes(lengths[i]);
    checkpoint.blocks[i].bytes.assign(bytes.begin(), bytes.end());
  }
  return reader.ok() && reader.remaining() == 0;
}

// Numbers that a training can have come to.
bool IsPossible(const Checkpoint& checkpoint) {
  constexpr double kLongest = 1e12;  // s
  constexpr uint64_t kMostUpdates = uint64_t{1} << 50;
  // Times are subtracted from each other.
  const auto is_time = [](int64_t ns) { return ns >= 0; };
  return checkpoint.updates <= kMostUpdates && std::ranges::all_of(checkpoint.published_ns, is_time) &&
         checkpoint.trained_s >= 0.0 && checkpoint.trained_s <= kLongest &&
         checkpoint.weights_version <= kMaxWeightsVersion &&
         std::ranges::all_of(checkpoint.policy, [](float value) { return std::isfinite(value); });
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
  const std::span<const float> policy = algorithm.published_policy();
  checkpoint.policy.assign(policy.begin(), policy.end());
  checkpoint.layout_hash = algorithm.layout_hash();
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
  DADRL_ASSIGN_OR_RETURN(const std::vector<std::byte> bytes, ReadFile(path, kMaxFileBytes));
  ByteReader head(bytes);
  const std::span<const std::byte> magic = head.GetBytes(kMagic.size());
  const auto format = head.Get<uint32_t>();
  const auto blocks = head.Get<uint32_t>();
  const auto length = head.Get<uint64_t>();
  if (!head.ok() || std::memcmp(magic.data(), kMagic.data(), kMagic.size()) != 0) {
    return Fail(ErrorCode::kCorrupt, "{} is not a checkpoint: {}", path.string(), kRemedy);
  }
  if (format != kFormat) {
    return Fail(
        ErrorCode::kInvalidArgument,
        "checkpoint {} is of format {}, this program reads format {}: resume with the program that wrote it",
        path.string(), format, kFormat);
  }
  if (length != bytes.size() || length < kHeadBytes + sizeof(uint64_t)) return Damaged(path, "length");
  const std::span<const std::byte> content = std::span(bytes).first(bytes.size() - sizeof(uint64_t));
  if (ByteReader(std::span(bytes).subspan(content.size())).Get<uint64_t>() != Xxh3(content)) {
    return Damaged(path, "checksum");
  }
  Checkpoint checkpoint;
  ByteReader body(content.subspan(kHeadBytes));
  if (!DecodeBody(body, blocks, checkpoint) || !IsPossible(checkpoint)) return Damaged(path, "contents");
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
