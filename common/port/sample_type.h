// Samples of an IDL type, copied whole without knowing the type.
#pragma once

#include <dds/dds.h>

#include <cstddef>
#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include "common/util/result.h"

namespace dadrl {

// Immutable. Knows flat structures: numbers, booleans, bounded strings, sequences of numbers.
class SampleType {
 public:
  // kInvalidArgument: the type has other members.
  static Result<SampleType> Of(const dds_topic_descriptor_t& descriptor);

  // A copy that owns its sequences.
  std::shared_ptr<const void> Copy(const void* sample) const;
  // The values of the @key members: equal for samples of one instance.
  std::string Key(const void* sample) const;

 private:
  struct Member {
    size_t offset = 0;
    size_t size = 0;  // of a sequence: of an element
  };

  size_t size_ = 0;
  std::vector<Member> sequences_;
  std::vector<Member> keys_;
};

}  // namespace dadrl
