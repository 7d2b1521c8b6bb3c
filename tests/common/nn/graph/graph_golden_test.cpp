// Every kind of node against PyTorch in float64, and against finite differences.
#include "tests/common/nn/graph/graph_cases.h"
#include "tests/common/nn/lane_test.h"
#include "tests/common/util/isa_scope.h"

namespace dadrl::nn {
namespace {

using GraphGolden = EveryIsa;

TEST_P(GraphGolden, EveryNodeAgreesForwardAndBackward) {
  const IsaScope isa(GetParam());
  for (const GraphCase& c : GraphCases()) {
    SCOPED_TRACE(c.name);
    CaseUnderTest test(c);
    test.Forward();
    golden::ExpectAgrees(test.Output(), golden::Floats("graph/" + c.name + "/output"), "output");
    test.Backward();
    golden::ExpectTensorsAgree(test.layout(), test.gradients(),
                               golden::Floats("graph/" + c.name + "/gradient"), "gradient of");
  }
}

// The padding of gradients and what was there before: both must survive.
TEST_P(GraphGolden, ASecondPassAddsTheSameGradientAgain) {
  const IsaScope isa(GetParam());
  for (const GraphCase& c : GraphCases()) {
    SCOPED_TRACE(c.name);
    CaseUnderTest test(c);
    test.Forward();
    test.Backward();
    const std::vector<float> once(test.gradients().begin(), test.gradients().end());
    test.Forward();
    test.Backward();
    for (size_t i = 0; i < once.size(); ++i) {
      ASSERT_NEAR(test.gradients()[i], 2.0f * once[i], 1e-5f * (1.0f + std::abs(once[i]))) << i;
    }
  }
}

TEST(GraphTest, GradientsAreTheSlopesOfTheLoss) {
  for (const GraphCase& c : GraphCases()) {
    SCOPED_TRACE(c.name);
    CaseUnderTest test(c);
    test.Forward();
    test.Backward();
    const std::vector<float> start(test.parameters().begin(), test.parameters().end());
    std::vector<float> direction(start.size());  // the padding stays zero
    for (const TensorInfo& tensor : test.layout().tensors()) {
      std::ranges::copy(golden::Uniform(400 + tensor.offset, tensor.size),
                        direction.begin() + static_cast<ptrdiff_t>(tensor.offset));
    }
    constexpr float kStep = 2e-4f;  // so short that no kink of a ReLU lies within
    const auto loss_at = [&](float distance) {
      for (size_t i = 0; i < start.size(); ++i) test.parameters()[i] = start[i] + distance * direction[i];
      test.Forward();
      return test.Loss();
    };
    double slope = 0.0;
    for (size_t i = 0; i < start.size(); ++i) {
      slope += static_cast<double>(test.gradients()[i]) * static_cast<double>(direction[i]);
    }
    const double difference = loss_at(kStep) - loss_at(-kStep);
    EXPECT_NEAR(difference / (2.0 * static_cast<double>(kStep)), slope, 1e-2 * (1.0 + std::abs(slope)));
  }
}

TEST(GraphTest, AFreshLayerNormChangesNoScale) {
  ParamLayout layout;
  Graph graph;
  graph.LayerNorm(layout, "norm", graph.Input(1, 20));
  std::vector<float> parameters(layout.size(), 1.0f);
  layout.Initialize(1, parameters);
  EXPECT_EQ(parameters, std::vector<float>(layout.size(), 0.0f)) << "the gain is stored less one";
}

TEST(GraphTest, InputsGetNoGradient) {
  ParamLayout layout;
  Graph graph;
  const Value input = graph.Input(2, 3);
  const Value output = graph.Dense(layout, "output", graph.Relu(input), 4);
  EXPECT_FALSE(graph.trained(input));
  EXPECT_TRUE(graph.trained(output));
  EXPECT_EQ(graph.shape(output), (RowShape{2, 4}));
}

INSTANTIATE_TEST_SUITE_P(Isa, GraphGolden, AllIsas(), IsaTestName);

}  // namespace
}  // namespace dadrl::nn
