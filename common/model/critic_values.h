// What both critics say about actions: for showing and comparing networks, not for training.
#pragma once

#include <memory>
#include <span>

#include "common/config/config.h"
#include "common/nn/param_layout.h"
#include "common/step/driving_shape.h"
#include "common/util/result.h"

namespace dadrl {

// The critics' networks on batches of any size, in blocks of sixteen. Not thread safe.
class CriticValues {
 public:
  CriticValues(const DrivingShape& spec, const ModelConfig& model);
  ~CriticValues();

  const nn::ParamLayout& layout() const;

  // Copies the parameters. kInvalidArgument when the length is wrong, kCorrupt when
  // one is not finite.
  Status Load(std::span<const float> parameters);

  // q1 and q2 [rows] of `observations` and their `actions` [rows, 2]. Requires a Load.
  void Evaluate(ColumnRows observations, std::span<const float> actions, std::span<float> q1,
                std::span<float> q2);

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace dadrl
