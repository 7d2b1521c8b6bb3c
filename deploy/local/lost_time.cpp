#include "deploy/local/lost_time.h"

#include <fmt/format.h>

#include <algorithm>
#include <numeric>
#include <utility>
#include <vector>

namespace dadrl {

void LostTime::Observe(TimePoint now, std::span<const std::string> faults) {
  if (begun_ && !faults.empty()) Add(faults.front(), now - last_);
  Skip(now);
}

void LostTime::Skip(TimePoint now) {
  begun_ = true;
  last_ = now;
}

void LostTime::Add(const std::string& fault, Duration lost) { by_fault_[fault] += lost; }

Duration LostTime::total() const {
  return std::accumulate(by_fault_.begin(), by_fault_.end(), Duration::zero(),
                         [](Duration sum, const auto& entry) { return sum + entry.second; });
}

bool LostTime::HeldUp(Duration trained) const {
  const Duration lost = total();
  return lost > kNegligible && 2 * lost > trained;
}

std::string LostTime::Sentence(Duration trained) const {
  if (by_fault_.empty()) return {};
  std::vector<std::pair<std::string, Duration>> longest_first(by_fault_.begin(), by_fault_.end());
  std::stable_sort(longest_first.begin(), longest_first.end(),
                   [](const auto& a, const auto& b) { return a.second > b.second; });
  std::string text =
      fmt::format("{:.0f} of {:.0f} s lost to faults:", ToSeconds(total()), ToSeconds(trained));
  for (size_t i = 0; i < longest_first.size(); ++i) {
    const auto& [fault, lost] = longest_first[i];
    text += fmt::format("{} {:.0f} s {}", i == 0 ? "" : ",", ToSeconds(lost), fault);
  }
  return text;
}

}  // namespace dadrl
