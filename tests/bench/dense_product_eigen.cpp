// The only user of Eigen here, compiled for AVX-512 and called only where that runs: no other object
// instantiates these templates, so the linker has nothing to mix up.
#define EIGEN_DONT_PARALLELIZE
#include <Eigen/Core>

#include "tests/bench/dense_product.h"

namespace dadrl::bench {

void EigenProduct(const float* input, const float* weight, float* output, int batch, int inputs,
                  int outputs) {
  const Eigen::Map<const Eigen::MatrixXf> x(input, batch, inputs);
  const Eigen::Map<const Eigen::MatrixXf> w(weight, inputs, outputs);
  Eigen::Map<Eigen::MatrixXf>(output, batch, outputs).noalias() = x * w;
}

}  // namespace dadrl::bench
