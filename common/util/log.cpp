#include "common/util/log.h"

#include <spdlog/sinks/stdout_sinks.h>

namespace dadrl {

void InitLogging(const std::string& role) {
  auto logger = spdlog::stderr_logger_mt(role);
  logger->set_pattern("%Y-%m-%d %H:%M:%S.%e %L %n: %v");
  logger->flush_on(spdlog::level::info);
  spdlog::set_default_logger(std::move(logger));
}

}  // namespace dadrl
