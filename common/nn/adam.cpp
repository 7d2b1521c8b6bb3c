#include "common/nn/adam.h"

#include <algorithm>
#include <array>
#include <cmath>

namespace dadrl::nn {

Range ShareOf(Range whole, int member, int members) {
  const size_t vectors = whole.count / kLanes;
  const size_t first = vectors * static_cast<size_t>(member) / static_cast<size_t>(members);
  const size_t end = vectors * static_cast<size_t>(member + 1) / static_cast<size_t>(members);
  return {whole.first + first * kLanes, (end - first) * kLanes};
}

bool ApplyAdam(const LaneKernels& kernels, const AdamSettings& settings, const AdamStep& step) {
  std::array<float*, kMaxGradients> gradients;
  for (size_t i = 0; i < step.gradients.size(); ++i) gradients[i] = step.gradients[i] + step.range.first;
  const double count = step.step;
  const double correction1 = 1.0 - std::pow(settings.beta1, count);
  const double correction2 = 1.0 - std::pow(settings.beta2, count);
  return kernels.adam({.count = step.range.count,
                       .parameters = step.parameters,
                       .first_moment = step.moments->first.data() + step.range.first,
                       .second_moment = step.moments->second.data() + step.range.first,
                       .gradients = gradients.data(),
                       .threads = static_cast<int>(step.gradients.size()),
                       .step_size = static_cast<float>(settings.learning_rate / correction1),
                       .inverse_root_correction = static_cast<float>(1.0 / std::sqrt(correction2)),
                       .beta1 = static_cast<float>(settings.beta1),
                       .beta2 = static_cast<float>(settings.beta2),
                       .epsilon = static_cast<float>(settings.epsilon),
                       .target = step.target,
                       .tau = static_cast<float>(step.tau)});
}

void ApplyAdam(const AdamSettings& settings, double gradient, uint64_t step, ScalarAdam& scalar) {
  const double count = step;
  scalar.first = settings.beta1 * scalar.first + (1.0 - settings.beta1) * gradient;
  scalar.second = settings.beta2 * scalar.second + (1.0 - settings.beta2) * gradient * gradient;
  const double root = std::sqrt(scalar.second / (1.0 - std::pow(settings.beta2, count)));
  scalar.value -= settings.learning_rate / (1.0 - std::pow(settings.beta1, count)) * scalar.first /
                  (root + settings.epsilon);
}

}  // namespace dadrl::nn
