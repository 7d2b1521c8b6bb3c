#include "common/util/log.h"

#include <gmock/gmock.h>
#include <spdlog/sinks/ostream_sink.h>

#include <memory>
#include <sstream>

namespace dadrl {
namespace {

TEST(Log, NoMessageForgesALineOrSteersTheTerminal) {
  std::ostringstream out;
  spdlog::logger logger("replay-0", std::make_shared<spdlog::sinks::ostream_sink_st>(out));
  logger.set_formatter(LogFormatter());
  logger.warn("peer says: {}", "x\n2026-01-01 00:00:00.000 E learner: gone\x1b[31m");
  EXPECT_THAT(
      out.str(),
      testing::EndsWith(" W replay-0: peer says: x\\x0a2026-01-01 00:00:00.000 E learner: gone\\x1b[31m\n"));
}

}  // namespace
}  // namespace dadrl
