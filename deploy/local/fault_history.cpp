#include "deploy/local/fault_history.h"

namespace dadrl {

std::vector<std::string> FaultHistory::Update(const std::vector<ProcessFault>& lasting, TimePoint now) {
  std::vector<std::string> said;
  for (const ProcessFault& reported : lasting) {
    Entry& entry = entries_[{reported.process, reported.fault.kind}];
    if (!entry.lasts) {
      entry = {.seconds = entry.seconds, .lasts = true, .since = now, .heard = now};
      said.push_back(fmt::format("fault of {}: {}; {}", reported.process, reported.fault.text,
                                 FaultMeaning(reported.fault.kind)));
    }
    entry.seconds += ToSeconds(now - entry.heard);
    entry.heard = now;
  }
  for (auto& [key, entry] : entries_) {
    if (!entry.lasts || now - entry.heard <= kGrace) continue;
    entry.lasts = false;
    said.push_back(fmt::format("{}: {}, after {:.0f} s", key.first, FaultOver(key.second),
                               ToSeconds(entry.heard - entry.since)));
  }
  return said;
}

std::string FaultHistory::Summary() const {
  std::string text;
  for (const auto& [key, entry] : entries_) {
    text += fmt::format("{}{} {} {:.0f} s", text.empty() ? "" : ", ", key.first, FaultName(key.second),
                        entry.seconds);
  }
  return text;
}

}  // namespace dadrl
