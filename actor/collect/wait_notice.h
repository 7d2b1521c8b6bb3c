// Says for whom a process waits, without saying it all the time.
#pragma once

#include <string>

#include "common/util/clock.h"

namespace dadrl {

// A line when a wait begins, every kInterval while it lasts, and when it is over. Not thread safe.
class WaitNotice {
 public:
  static constexpr Duration kInterval = std::chrono::seconds(10);

  // `whom`: "the replay at 127.0.0.1:7410"; empty when for nobody.
  void Update(const std::string& whom, TimePoint now);

 private:
  std::string noticed_;  // the wait that was logged, until it is over
  TimePoint next_{};
};

}  // namespace dadrl
