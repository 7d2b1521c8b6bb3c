// training.csv, which a learner that was killed may have left at any length.
#include "deploy/local/training_curve.h"

#include "tests/fuzz/outside_text.h"

namespace dadrl::fuzz {

const int kMutants = 10000;

bool Check(std::span<std::byte> input) {
  const TrainedSoFar trained = LastOfTraining(Written("training.csv", input));
  return trained.updates > 0;
}

Seeds MakeSeeds() {
  const std::string header = "time_s,updates,weights_version\n";
  return {.accepted = {AsBytes(header + "1.5,300,4\n"), AsBytes(header + "1.5,300,4\n2.5,400"),
                       AsBytes(header + Repeated("1.5,300,4\n", 2000))},
          .refused = {AsBytes(""), AsBytes(header), AsBytes(header + "1,2,3"), AsBytes(header + "\n,\n"),
                      AsBytes(std::string(9000, 'x')), AsBytes(header + "1,18446744073709551616,1\n"),
                      AsBytes(header + "1,-5,1\n")}};
}

}  // namespace dadrl::fuzz
