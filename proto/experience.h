// Experience as it travels and is stored: chunks of an episode's frames (design, section 6).
//
// An episode of T decisions is T + 1 frames when it was truncated (the last holds the observation after the
// last decision and no action), and T frames when it terminated (nothing follows a collision or the goal). A
// chunk is up to 64 consecutive frames of one episode. Frame payloads are compressed one by one, so that the
// replay stores and slices chunks without decoding a frame.
//
// Wire format, little endian: magic u32, version u32, actor u32, first_frame u32, frames u32, payload bytes
// u32, incarnation u64, sequence u64, episode u64, schema u64 | policy_version u32[n], action f32[n][2],
// reward f32[n], flags u8[n] padded with zeros to 4, offset u32[n + 1] | frame payloads | xxh3-64 of
// everything before. What a payload holds: payload_codec.cpp.
#pragma once

#include <cstddef>
#include <cstdint>
#include <cstring>
#include <memory>
#include <span>
#include <string_view>
#include <vector>

#include "common/config/config.h"
#include "common/step/columns.h"
#include "common/util/result.h"
#include "proto/payload_codec.h"

namespace dadrl {

constexpr uint16_t kExperienceVersion = 1;
constexpr int kMaxChunkFrames = 64;
// Nothing longer is ever accepted from a socket or a file.
constexpr size_t kMaxChunkBytes = size_t{4} << 20;
constexpr size_t kChunkHeaderBytes = 56;
// More than an incarnation can ever send: a million chunks a second for eight years. Numbers up to it never
// wrap, whatever is added to them.
constexpr uint64_t kMaxSequence = uint64_t{1} << 48;

// Bits of a frame's flags.
// A frame without an action is the final observation after a truncation: the last of its episode.
enum FrameFlag : uint8_t {
  kHasDecision = 1,  // decision, reward and policy_version are valid
  kTerminated = 2,   // the action ended the episode; nothing follows
  kTruncated = 4,    // the action was the last before the time limit; the next frame is the final observation
  kSuccess = 8,  // with kTerminated: by reaching the goal (none of experience from before it was recorded)
};

// Who wrote a chunk: the replay accepts each identity exactly once.
struct ChunkIdentity {
  uint32_t actor = 0;
  uint64_t incarnation = 0;  // wall time at which the actor process started, ns: grows with each restart
  uint64_t sequence = 0;     // 1, 2, 3, ... within an incarnation
  auto operator<=>(const ChunkIdentity&) const = default;
};

struct ChunkHeader {
  ChunkIdentity identity;
  uint64_t episode = 0;      // unique within the incarnation
  uint32_t first_frame = 0;  // of the chunk's first frame within its episode
  uint32_t frames = 0;
  uint64_t schema = 0;  // SchemaHash: a replay holds one schema
};

// Collects consecutive frames of one episode and serialises them. Not thread safe.
class ChunkBuilder {
 public:
  ChunkBuilder(const StepSpec& spec, FloatCoding floats);

  // Starts an empty chunk whose first frame is frame `first_frame` of `episode`.
  void Begin(uint64_t episode, uint32_t first_frame);
  // A frame with what was decided on it, the spec's decision_floats; `flags` of kTerminated, kTruncated and
  // kSuccess, kHasDecision is added.
  void AddTransition(ColumnRows observation, std::span<const float> decision, float reward, uint8_t flags,
                     uint32_t policy_version);
  // The observation after a truncation.
  void AddFinal(ColumnRows observation);
  int frames() const { return std::ssize(flags_); }
  // No other frame may be added: kMaxChunkFrames are in, or the next might exceed kMaxChunkBytes (which takes
  // an observation far larger than the default one).
  bool full() const;

  // The chunk's bytes under `identity`. Needs at least one frame.
  std::vector<std::byte> Finish(const ChunkIdentity& identity) const;

 private:
  void AddFrame(ColumnRows observation, float reward, uint8_t flags, uint32_t policy_version);

  PayloadCodec codec_;
  const size_t decision_floats_;
  uint64_t schema_;
  uint64_t episode_ = 0;
  uint32_t first_frame_ = 0;
  std::vector<uint32_t> policy_versions_;
  std::vector<float> decisions_;
  std::vector<float> rewards_;
  std::vector<uint8_t> flags_;
  std::vector<uint32_t> offsets_;
  std::vector<std::byte> payloads_;
};

// Why a chunk is not taken. ChunkView::Parse finds the first five, a replay the others.
enum class ChunkFault : int {
  kGarbage = 0,  // no chunk at all
  kVersion,      // of the format
  kLength,       // of the message, or of what it claims to hold
  kChecksum,
  kContents,  // impossible flags or numbers, or frames that cannot be decoded
  kSchema,    // of other columns
  kStale,     // of an actor that has been restarted since, or of one actor too many
  kCount,
};

// In a sentence ("checksum", "contents"); "unknown" for what is none.
std::string_view ChunkFaultName(ChunkFault fault);

// A validated look into a chunk's bytes; borrows them.
class ChunkView {
 public:
  // Checks magic, version, lengths, offsets, flags and their order, finiteness of decisions and rewards,
  // checksum; not the payloads, nor what spec and task allow (experience_bounds.h). Never reads outside
  // `bytes`. kCorrupt with what was wrong, and `fault` set.
  static Result<ChunkView> Parse(std::span<const std::byte> bytes, ChunkFault* fault = nullptr);

  // Looks at `copy` from now on: the same bytes at another place. Nothing is checked again.
  void Rebase(std::span<const std::byte> copy) { bytes_ = copy; }

  // Read anew at each call: the replay holds very many views, and asks few of them.
  ChunkHeader header() const;
  int frames() const { return static_cast<int>(frames_); }
  uint32_t policy_version(int frame) const { return Load<uint32_t>(policy_versions(), frame); }
  size_t decision_floats() const { return decision_floats_; }
  float decision(int frame, size_t index) const {
    return Load<float>(decisions() + static_cast<size_t>(frame) * decision_bytes(), static_cast<int>(index));
  }
  std::span<const std::byte> decision(int frame) const {
    return {decisions() + static_cast<size_t>(frame) * decision_bytes(), decision_bytes()};
  }
  float reward(int frame) const { return Load<float>(rewards(), frame); }
  uint8_t flags(int frame) const { return Load<uint8_t>(flag_bytes(), frame); }
  std::span<const std::byte> payload(int frame) const {
    return {payloads() + offset(frame), payloads() + offset(frame + 1)};
  }
  // Asks for what describes `frame` before it is read.
  void PrefetchColumns(int frame) const;
  // Where the payload of `frame` begins among the payloads; offset(frames()) is their end.
  uint32_t offset(int frame) const { return Load<uint32_t>(offsets(), frame); }
  size_t payload_bytes() const { return payload_bytes_; }
  std::span<const std::byte> bytes() const { return bytes_; }
  // Of everything before it; tells the chunk from every other.
  uint64_t checksum() const;

 private:
  template <typename T>
  static T Load(const std::byte* from, int index) {
    T value;
    std::memcpy(&value, from + static_cast<size_t>(index) * sizeof(T), sizeof(T));
    return value;
  }

  Status CheckFrames() const;

  // Where the columns begin.
  const std::byte* policy_versions() const { return bytes_.data() + kChunkHeaderBytes; }
  size_t decision_bytes() const { return decision_floats_ * sizeof(float); }
  const std::byte* decisions() const { return policy_versions() + frames_ * sizeof(uint32_t); }
  const std::byte* rewards() const { return decisions() + frames_ * decision_bytes(); }
  const std::byte* flag_bytes() const { return rewards() + frames_ * sizeof(float); }
  const std::byte* offsets() const { return flag_bytes() + (frames_ + size_t{3}) / 4 * 4; }
  const std::byte* payloads() const { return offsets() + (frames_ + size_t{1}) * sizeof(uint32_t); }

  std::span<const std::byte> bytes_;
  uint32_t payload_bytes_ = 0;
  uint16_t frames_ = 0;
  uint16_t decision_floats_ = 0;
};

}  // namespace dadrl
