#include "actor/collect/wait_notice.h"

#include "common/util/log.h"

namespace dadrl {

void WaitNotice::Update(const std::string& whom, TimePoint now) {
  if (whom.empty()) {
    if (!noticed_.empty()) spdlog::info("no longer waiting for {}", noticed_);
    noticed_.clear();
    return;
  }
  if (!noticed_.empty() && now < next_) return;
  spdlog::info("waiting for {}", whom);
  noticed_ = whom;
  next_ = now + kInterval;
}

}  // namespace dadrl
