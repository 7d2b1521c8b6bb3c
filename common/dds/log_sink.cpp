#include "common/dds/log_sink.h"

#include <dds/dds.h>
#include <dds/ddsrt/log.h>

#include <chrono>
#include <map>
#include <mutex>
#include <string>
#include <tuple>
#include <utility>

#include "common/util/log.h"
#include "common/util/mutex.h"

namespace dadrl::dds {
namespace {

constexpr std::chrono::seconds kQuiet{10};

class LogSink {
 public:
  void Write(const dds_log_data_t& data) DADRL_EXCLUDES(mutex_) {
    uint64_t suppressed = 0;
    {
      MutexLock lock(mutex_);
      Place& place = places_[{data.file, data.line}];
      const auto now = std::chrono::steady_clock::now();
      if (place.shown && now - place.last < kQuiet) {
        ++place.suppressed;
        return;
      }
      suppressed = std::exchange(place.suppressed, 0);
      place.shown = true;
      place.last = now;
    }
    std::string text(data.message, data.size);
    while (!text.empty() && text.back() == '\n') text.pop_back();
    if (suppressed > 0) text += fmt::format(" ({} more like it)", suppressed);
    const bool error = (data.priority & (DDS_LC_ERROR | DDS_LC_FATAL)) != 0;
    spdlog::log(error ? spdlog::level::err : spdlog::level::warn, "DDS: {}", text);
  }

 private:
  struct Place {
    bool shown = false;
    std::chrono::steady_clock::time_point last;
    uint64_t suppressed = 0;
  };
  Mutex mutex_;
  std::map<std::pair<const char*, uint32_t>, Place> places_ DADRL_GUARDED_BY(mutex_);
};

}  // namespace

void InstallLogSink() {
  // Never destroyed: Cyclone's threads may still log while the process's statics go.
  static LogSink* const sink = [] {
    auto* created = new LogSink;
    dds_set_log_sink(
        [](void* context, const dds_log_data_t* data) { static_cast<LogSink*>(context)->Write(*data); },
        created);
    return created;
  }();
  std::ignore = sink;
}

}  // namespace dadrl::dds
