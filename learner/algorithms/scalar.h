// The numbers that a learning algorithm reports of each update, declared once: training log, TensorBoard,
// telemetry, panel and divergence guard walk this table and know none of them by name.
#pragma once

#include <string_view>

namespace dadrl {

// What a scalar estimates, where that bounds it (DivergenceGuard). One that is bounded is given by every
// update.
enum class ScalarKind {
  kUnbounded,
  kValue,         // a return, or a mean of returns
  kSquaredError,  // of values, summed over at most two critics
  kTemperature,   // reward units a nat
};

struct ScalarSpec {
  std::string_view
      name;  // "critic_loss": snake_case, unique, at most kMaxScalarName bytes (proto/telemetry.h)
  std::string_view tag;  // in TensorBoard: "loss/critic"
  ScalarKind kind = ScalarKind::kUnbounded;
};

}  // namespace dadrl
