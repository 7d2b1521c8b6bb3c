#include "learner/algorithms/algorithm.h"
#include "learner/algorithms/sac.h"

namespace dadrl {

Result<std::unique_ptr<Algorithm>> MakeAlgorithm(const Config& config) {
  if (config.algorithm.name != "sac") {
    return Fail(ErrorCode::kInvalidArgument, "algorithm.name: no algorithm '{}', there is: sac",
                config.algorithm.name);
  }
  return std::make_unique<Sac>(config);
}

}  // namespace dadrl
