// An instruction set for the length of a test.
#pragma once

#include "common/util/isa.h"

namespace dadrl {

// Restores the one in use before.
class IsaScope {
 public:
  explicit IsaScope(Isa isa) : before_(ActiveIsa()) { SetIsa(isa); }
  ~IsaScope() { SetIsa(before_); }
  IsaScope(const IsaScope&) = delete;
  IsaScope& operator=(const IsaScope&) = delete;

 private:
  Isa before_;
};

}  // namespace dadrl
