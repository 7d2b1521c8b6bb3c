// An observation's bytes, on the wire and on disk: each column by the codec that its spec names.
#pragma once

#include <cstddef>
#include <memory>
#include <span>
#include <vector>

#include "common/config/config.h"
#include "common/step/columns.h"
#include "common/util/result.h"

namespace dadrl {

// Histories and halves: lossless for fp32, to half precision for fp16 (finite values beyond 65504 become
// 65504); all else is lossless. Keeps its scratch memory; one a thread.
class PayloadCodec {
 public:
  // `spec` passes CheckSpec. `floats`: how histories are written; either is read.
  PayloadCodec(const StepSpec& spec, FloatCoding floats);
  ~PayloadCodec();
  PayloadCodec(PayloadCodec&&) noexcept;
  PayloadCodec& operator=(PayloadCodec&&) noexcept;

  // No payload of this spec is longer.
  size_t max_payload_bytes() const;

  // Appends the payload of one row to `out`.
  void Encode(ColumnRows row, std::vector<std::byte>& out);
  // Fills one row of columns of this spec. kCorrupt when the payload is not exactly one observation of it,
  // with finite floats within their columns' bounds (the row is then unspecified); reads nothing beyond it,
  // whatever it holds.
  Status Decode(std::span<const std::byte> payload, MutableColumnRows row);

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

// How a payload's histories are coded; for payloads that Decode accepts.
FloatCoding CodingOf(std::span<const std::byte> payload);

}  // namespace dadrl
