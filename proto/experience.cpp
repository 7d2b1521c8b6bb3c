#include "proto/experience.h"

#include <array>
#include <cassert>
#include <cmath>
#include <cstring>
#include <utility>

#include "common/io/byte_io.h"
#include "common/io/checksum.h"
#include "common/step/step_spec.h"
#include "common/util/enum_array.h"
#include "common/util/prefetch.h"

namespace dadrl {
namespace {

constexpr uint32_t kChunkMagic = 0x43584441;  // "ADXC"

// As it is on the wire: there are no gaps.
struct WireHeader {
  uint32_t magic;
  uint16_t version;
  uint16_t decision_floats;
  uint32_t actor;
  uint32_t first_frame;
  uint32_t frames;
  uint32_t payload_bytes;
  uint64_t incarnation;
  uint64_t sequence;
  uint64_t episode;
  uint64_t schema;
};
static_assert(sizeof(WireHeader) == kChunkHeaderBytes);

WireHeader LoadHeader(std::span<const std::byte> bytes) {
  WireHeader header;
  std::memcpy(&header, bytes.data(), sizeof(header));
  return header;
}

constexpr size_t PaddedFlags(size_t frames) { return (frames + 3) / 4 * 4; }
constexpr size_t ColumnBytes(size_t frames, size_t decision_floats) {
  return frames * 4 * (1 + decision_floats + 1) + PaddedFlags(frames) + (frames + 1) * 4;
}

// Before they were counted a decision was an action of two.
constexpr uint16_t kUncountedDecisionFloats = 2;

}  // namespace

ChunkBuilder::ChunkBuilder(const StepSpec& spec, FloatCoding floats)
    : codec_(spec, floats), decision_floats_(spec.decision_floats()), schema_(SchemaHash(spec)) {
  assert(decision_floats_ >= 1 && decision_floats_ <= kMaxDecisionFloats);
  Begin(0, 0);
}

void ChunkBuilder::Begin(uint64_t episode, uint32_t first_frame) {
  episode_ = episode;
  first_frame_ = first_frame;
  policy_versions_.clear();
  decisions_.clear();
  rewards_.clear();
  flags_.clear();
  offsets_.assign(1, 0);
  payloads_.clear();
}

void ChunkBuilder::AddTransition(ColumnRows observation, std::span<const float> decision, float reward,
                                 uint8_t flags, uint32_t policy_version) {
  assert((flags & ~(kTerminated | kTruncated | kSuccess)) == 0);
  assert(decision.size() == decision_floats_);
  decisions_.insert(decisions_.end(), decision.begin(), decision.end());
  AddFrame(observation, reward, flags | kHasDecision, policy_version);
}

void ChunkBuilder::AddFinal(ColumnRows observation) {
  decisions_.resize(decisions_.size() + decision_floats_);
  AddFrame(observation, 0.0f, 0, 0);
}

void ChunkBuilder::AddFrame(ColumnRows observation, float reward, uint8_t flags, uint32_t policy_version) {
  assert(!full());
  codec_.Encode(observation, payloads_);
  policy_versions_.push_back(policy_version);
  rewards_.push_back(reward);
  flags_.push_back(flags);
  offsets_.push_back(payloads_.size());
}

bool ChunkBuilder::full() const {
  const size_t frames = flags_.size();
  const size_t with_another = kChunkHeaderBytes + ColumnBytes(frames + 1, decision_floats_) +
                              payloads_.size() + codec_.max_payload_bytes() + kChecksumBytes;
  return frames == kMaxChunkFrames || (frames > 0 && with_another > kMaxChunkBytes);
}

std::vector<std::byte> ChunkBuilder::Finish(const ChunkIdentity& identity) const {
  assert(!flags_.empty());
  const size_t frames = flags_.size();
  std::vector<std::byte> bytes;
  bytes.reserve(kChunkHeaderBytes + ColumnBytes(frames, decision_floats_) + payloads_.size() +
                kChecksumBytes);
  ByteWriter writer(bytes);
  const WireHeader header{.magic = kChunkMagic,
                          .version = kExperienceVersion,
                          .decision_floats = static_cast<uint16_t>(decision_floats_),
                          .actor = identity.actor,
                          .first_frame = first_frame_,
                          .frames = static_cast<uint32_t>(frames),
                          .payload_bytes = static_cast<uint32_t>(payloads_.size()),
                          .incarnation = identity.incarnation,
                          .sequence = identity.sequence,
                          .episode = episode_,
                          .schema = schema_};
  writer.PutBytes(std::as_bytes(std::span(&header, 1)));
  writer.PutBytes(std::as_bytes(std::span(policy_versions_)));
  writer.PutBytes(std::as_bytes(std::span(decisions_)));
  writer.PutBytes(std::as_bytes(std::span(rewards_)));
  writer.PutBytes(std::as_bytes(std::span(flags_)));
  bytes.resize(bytes.size() + PaddedFlags(frames) - frames);
  writer.PutBytes(std::as_bytes(std::span(offsets_)));
  writer.PutBytes(payloads_);
  AppendChecksum(bytes);
  return bytes;
}

Result<ChunkView> ChunkView::Parse(std::span<const std::byte> bytes, ChunkFault* fault) {
  const auto checking = [fault](ChunkFault what) {
    if (fault != nullptr) *fault = what;
  };
  checking(ChunkFault::kLength);
  if (bytes.size() < kChunkHeaderBytes + kChecksumBytes || bytes.size() > kMaxChunkBytes) {
    return Fail(ErrorCode::kCorrupt, "chunk of {} bytes; one has {} to {}", bytes.size(),
                kChunkHeaderBytes + kChecksumBytes, kMaxChunkBytes);
  }
  const WireHeader header = LoadHeader(bytes);
  checking(ChunkFault::kGarbage);
  if (header.magic != kChunkMagic) return Fail(ErrorCode::kCorrupt, "chunk has no magic number");
  checking(ChunkFault::kVersion);
  if (header.version != kExperienceVersion) {
    return Fail(ErrorCode::kCorrupt, "chunk has version {}, this build reads {}", header.version,
                kExperienceVersion);
  }
  checking(ChunkFault::kLength);
  if (header.frames < 1 || header.frames > kMaxChunkFrames) {
    return Fail(ErrorCode::kCorrupt, "chunk of {} frames; one has 1 to {}", header.frames, kMaxChunkFrames);
  }
  const uint16_t decision_floats =
      header.decision_floats == 0 ? kUncountedDecisionFloats : header.decision_floats;
  if (decision_floats > kMaxDecisionFloats) {
    return Fail(ErrorCode::kCorrupt, "chunk's decisions have {} numbers; they have at most {}",
                decision_floats, kMaxDecisionFloats);
  }
  const size_t expected =
      kChunkHeaderBytes + ColumnBytes(header.frames, decision_floats) + header.payload_bytes + kChecksumBytes;
  if (bytes.size() != expected) {
    return Fail(ErrorCode::kCorrupt, "chunk of {} bytes, its header says {}", bytes.size(), expected);
  }
  checking(ChunkFault::kChecksum);
  if (!CheckedContent(bytes)) return Fail(ErrorCode::kCorrupt, "chunk fails its checksum");
  ChunkView view;
  view.bytes_ = bytes;
  view.frames_ = header.frames;
  view.decision_floats_ = decision_floats;
  view.payload_bytes_ = header.payload_bytes;
  checking(ChunkFault::kContents);
  if (header.sequence == 0 || header.sequence > kMaxSequence ||
      header.first_frame > UINT32_MAX - kMaxChunkFrames) {
    return Fail(ErrorCode::kCorrupt, "chunk with sequence {} and first frame {}", header.sequence,
                header.first_frame);
  }
  if (view.offset(0) != 0 || view.offset(view.frames()) != header.payload_bytes) {
    return Fail(ErrorCode::kCorrupt, "chunk's offsets do not span its payloads");
  }
  DADRL_RETURN_IF_ERROR(view.CheckFrames());
  return view;
}

ChunkHeader ChunkView::header() const {
  const WireHeader header = LoadHeader(bytes_);
  return {.identity = {header.actor, header.incarnation, header.sequence},
          .episode = header.episode,
          .first_frame = header.first_frame,
          .frames = header.frames,
          .schema = header.schema};
}

Status ChunkView::CheckFrames() const {
  for (int i = 0; i < frames(); ++i) {
    // Rising offsets: no payload is empty, and none overlaps another.
    if (offset(i + 1) <= offset(i)) return Fail(ErrorCode::kCorrupt, "chunk's frame {} has no payload", i);
    bool finite = std::isfinite(reward(i));
    for (size_t k = 0; k < decision_floats_; ++k) finite &= std::isfinite(decision(i, k));
    if (!finite) {
      return Fail(ErrorCode::kCorrupt, "chunk's frame {} has a decision or a reward that is not finite", i);
    }
    const uint8_t bits = flags(i);
    const bool last = i == frames() - 1;
    const bool known = (bits & ~(kHasDecision | kTerminated | kTruncated | kSuccess)) == 0;
    const bool one_end = (bits & (kTerminated | kTruncated)) != (kTerminated | kTruncated);
    const bool succeeds_at_end = (bits & kSuccess) == 0 || (bits & kTerminated) != 0;
    const bool final_frame = (bits & kHasDecision) == 0;
    const bool ends_here = final_frame || (bits & kTerminated) != 0;
    const bool after_truncation = i > 0 && (flags(i - 1) & kTruncated) != 0;
    // In a chunk's first frame a final observation may follow a truncation of the chunk before.
    const bool final_in_place = i == 0 || final_frame == after_truncation;
    if (!known || !one_end || !succeeds_at_end || (final_frame && bits != 0) || (ends_here && !last) ||
        !final_in_place) {
      return Fail(ErrorCode::kCorrupt, "chunk's frame {} of {} has impossible flags {:#04x}", i, frames(),
                  bits);
    }
  }
  return {};
}

std::string_view ChunkFaultName(ChunkFault fault) {
  static constexpr EnumArray<ChunkFault, std::string_view> kNames = {
      "garbage", "version", "length", "checksum", "contents", "schema", "stale"};
  return fault >= ChunkFault{} && fault < ChunkFault::kCount ? kNames[fault] : "unknown";
}

uint64_t ChunkView::checksum() const { return Load<uint64_t>(&bytes_[bytes_.size() - kChecksumBytes], 0); }

void ChunkView::PrefetchColumns(int frame) const {
  const auto at = static_cast<size_t>(frame);
  Prefetch(policy_versions() + sizeof(uint32_t) * at, 1);
  Prefetch(decisions() + decision_bytes() * at, 1);
  Prefetch(rewards() + sizeof(float) * at, 1);
  Prefetch(flag_bytes() + at, 1);
  Prefetch(offsets() + sizeof(uint32_t) * at, 1);
}

}  // namespace dadrl
