#include "common/port/sample_type.h"

#include <dds/ddsc/dds_opcodes.h>

#include <cstring>

namespace dadrl {
namespace {

// Of a number or boolean; 0 for what is none.
size_t ScalarSize(uint32_t type) {
  switch (type) {
    case DDS_OP_VAL_1BY:
    case DDS_OP_VAL_BLN:
      return 1;
    case DDS_OP_VAL_2BY:
      return 2;
    case DDS_OP_VAL_4BY:
      return 4;
    case DDS_OP_VAL_8BY:
      return 8;
    default:
      return 0;
  }
}

constexpr size_t kAlignment = alignof(std::max_align_t);
constexpr size_t Aligned(size_t bytes) { return (bytes + kAlignment - 1) / kAlignment * kAlignment; }

const dds_sequence_t& SequenceAt(const void* sample, size_t offset) {
  return *reinterpret_cast<const dds_sequence_t*>(static_cast<const std::byte*>(sample) + offset);
}

}  // namespace

// Each member is an instruction of two words and more (dds_opcodes.h): what it is, where it stands, its
// bound.
Result<SampleType> SampleType::Of(const dds_topic_descriptor_t& descriptor) {
  SampleType type;
  type.size_ = descriptor.m_size;
  for (const uint32_t* op = descriptor.m_ops; (*op & DDS_OP_MASK) != DDS_OP_RTS;) {
    const uint32_t kind = (*op & DDS_OP_TYPE_MASK) >> 16;
    const bool is_sequence = kind == DDS_OP_VAL_SEQ || kind == DDS_OP_VAL_BSQ;
    const size_t size = ScalarSize(is_sequence ? (*op & DDS_OP_SUBTYPE_MASK) >> 8 : kind);
    const bool external = (*op & DDS_OP_TYPE_FLAGS_MASK) != 0;
    if ((*op & DDS_OP_MASK) != DDS_OP_ADR || external || (size == 0 && kind != DDS_OP_VAL_BST)) {
      return Fail(ErrorCode::kInvalidArgument,
                  "type {} has a member that memory ports cannot copy (op {:#x})", descriptor.m_typename,
                  *op);
    }
    if (is_sequence) type.sequences_.push_back({op[1], size});
    if ((*op & DDS_OP_FLAG_KEY) != 0) type.keys_.push_back({op[1], size});
    op += kind == DDS_OP_VAL_BSQ || kind == DDS_OP_VAL_BST ? 3 : 2;
  }
  return type;
}

// One block: the structure, then what its sequences hold.
std::shared_ptr<const void> SampleType::Copy(const void* sample) const {
  size_t bytes = Aligned(size_);
  for (const Member& member : sequences_) {
    bytes += Aligned(SequenceAt(sample, member.offset)._length * member.size);
  }
  const std::shared_ptr<std::max_align_t[]> block(new std::max_align_t[Aligned(bytes) / kAlignment]);
  auto* const copy = reinterpret_cast<std::byte*>(block.get());
  std::memcpy(copy, sample, size_);
  std::byte* contents = copy + Aligned(size_);
  for (const Member& member : sequences_) {
    auto& sequence = *reinterpret_cast<dds_sequence_t*>(copy + member.offset);
    const size_t length = sequence._length * member.size;
    if (length > 0) std::memcpy(contents, sequence._buffer, length);
    sequence = {._maximum = sequence._length,
                ._length = sequence._length,
                ._buffer = reinterpret_cast<uint8_t*>(contents),
                ._release = false};
    contents += Aligned(length);
  }
  return {block, copy};
}

std::string SampleType::Key(const void* sample) const {
  std::string key;
  for (const Member& member : keys_) {
    key.append(static_cast<const char*>(sample) + member.offset, member.size);
  }
  return key;
}

}  // namespace dadrl
