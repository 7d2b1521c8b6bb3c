// A policy with a memory, and nothing else: what it does says how often it has acted in this episode.
#pragma once

#include <string>
#include <vector>

#include "common/model/policy_model.h"

namespace dadrl {

// The n-th Act of an episode (from 1) gives the action (n / 100, 0). Writes down what is asked of it, in
// `calls`: "load", "begin", "act 1", ...
class CountingPolicy final : public PolicyModel {
 public:
  CountingPolicy() { layout_.Add("memory", {4}, 0.0f); }

  std::vector<std::string> calls;

  const nn::ParamLayout& layout() const override { return layout_; }
  Status Load(std::span<const float>) override {
    calls.emplace_back("load");
    return {};
  }
  void BeginEpisode() override {
    calls.emplace_back("begin");
    acts_ = 0;
  }
  Action Act(const Observation&, Random*) override {
    calls.push_back("act " + std::to_string(++acts_));
    details_.value = 10.0f * static_cast<float>(acts_);
    return {static_cast<float>(acts_) / 100.0f, 0.0f};
  }
  const Details& last() const override { return details_; }

 private:
  nn::ParamLayout layout_;
  int acts_ = 0;
  Details details_;
};

}  // namespace dadrl
