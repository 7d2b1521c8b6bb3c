// What leaves the program as plain arrays, against an implementation that shares nothing with it: forward.py.
#include <gmock/gmock.h>

#include <cmath>
#include <nlohmann/json.hpp>

#include "common/config/config_yaml.h"
#include "common/io/npy.h"
#include "common/model/networks.h"
#include "common/model/policy_file.h"
#include "common/util/isa.h"
#include "tests/deploy/cli/run_command.h"
#include "tests/golden/golden.h"
#include "tests/paths.h"

namespace dadrl {
namespace {

using testing::HasSubstr;
using testing::IsEmpty;
using Json = nlohmann::json;
using Shape = std::vector<size_t>;

constexpr size_t kCount = 19;  // no multiple of sixteen

std::vector<float> Fresh(const nn::ParamLayout& layout, uint64_t salt) {
  std::vector<float> parameters(layout.size());
  golden::FillParameters(layout, salt, parameters);
  for (float& p : parameters) p *= 1.5f;  // so that log stds reach their limits
  return parameters;
}

class OpenModelTest : public testing::Test {
 protected:
  void SetUp() override {
    std::filesystem::create_directory(observations_);
    WriteObservations();
  }

  void SavePolicyOf(bool with_critic = true) {
    const DrivingShape spec = DrivingShape::From(config_.observation);
    const PolicyNetwork policy(spec, config_.model);
    const CriticNetwork critic(spec, config_.model);
    const std::vector<float> parameters = Fresh(policy.layout, 1);
    const std::vector<float> critics = Fresh(critic.layout, 2);
    std::vector<NamedNetwork> networks = {{kPolicyNetwork, policy.layout.hash(), parameters},
                                          {kCriticNetwork, critic.layout.hash(), critics}};
    if (!with_critic) networks.pop_back();
    ASSERT_TRUE(SavePolicy(
        policy_,
        {.policy_version = 3, .updates = 70, .config_yaml = ToYaml(config_, false), .networks = networks}));
  }

  // An empty road, a full one, vehicles that have just come or just gone, an empty and a full picture.
  void WriteObservations() {
    const auto vehicles = static_cast<size_t>(config_.observation.vehicles);
    const auto history = static_cast<size_t>(config_.observation.history);
    std::vector<float> rows = golden::Uniform(5, kCount * vehicles * history * 7);
    for (size_t i = 0; i < kCount; ++i) {
      for (size_t v = 0; v < vehicles; ++v) {
        for (size_t t = 0; t < history; ++t) {
          float* row = rows.data() + ((i * vehicles + v) * history + t) * 7;
          const bool gone = t + 1 == history && (i + v) % 7 == 0;
          const bool not_yet = t < (i * 5 + v * 3) % (history + 1);
          const bool absent = i == 0 || (i != 1 && (gone || not_yet));
          row[0] = absent ? 1.0f : 0.0f;
          if (absent) std::fill(row + 1, row + 7, 0.0f);
        }
      }
    }
    std::vector<uint8_t> pixels(kCount * 2 * 128 * 128);
    for (size_t i = 0; i < pixels.size(); ++i) {
      const size_t y = i / 128 % 128;
      const size_t x = i % 128;
      const size_t sample = i / (2 * 128 * 128);
      pixels[i] = sample == 2 ? 0 : sample == 3 ? 1 : (x * (sample + 1) + y * 3) / 40 % 2;
    }
    Write("vehicles", {kCount, vehicles, history, 7}, rows);
    Write("ego", {kCount, history, 20}, golden::Uniform(6, kCount * history * 20));
    Write("context", {kCount, 2, 128, 128}, pixels);
  }

  template <typename T>
  void Write(const std::string& name, const Shape& shape, const std::vector<T>& values) {
    const Status written = WriteNpy<T>(observations_ / (name + ".npy"), shape, values);
    ASSERT_TRUE(written) << written.error().message;
  }

  CommandOutput Export() { return Dadrl({"export", "--policy", policy_, "--out", export_}); }
  CommandOutput Act(bool json = true) {
    std::vector<std::string> arguments = {"act", "--policy", policy_, "--observations", observations_};
    if (json) arguments.emplace_back("--json");
    return Dadrl(arguments);
  }

  // `dadrl act` and NumPy on the export, on the same observations.
  void ExpectNumPyAgrees() {
    const CommandOutput exported = Export();
    ASSERT_EQ(exported.exit_code, 0) << exported.err;
    const CommandOutput ours = Act();
    ASSERT_EQ(ours.exit_code, 0) << ours.err;
    const CommandOutput theirs = RunCommand(
        {"/usr/bin/python3", DADRL_SOURCE_DIR "/tests/deploy/open_model/forward.py", export_, observations_});
    ASSERT_EQ(theirs.exit_code, 0) << theirs.err;
    const Json a = Json::parse(ours.out).flatten();
    const Json b = Json::parse(theirs.out).flatten();
    ASSERT_EQ(a.size(), b.size());
    EXPECT_EQ(a.at("/observations"), kCount);
    for (const auto& [key, value] : b.items()) {
      ASSERT_TRUE(a.contains(key)) << key;
      ASSERT_EQ(a[key].is_number(), value.is_number()) << key;
      if (!value.is_number()) continue;
      const double expected = value.get<double>();
      EXPECT_NEAR(a[key].get<double>(), expected, 1e-5 * std::max(1.0, std::abs(expected))) << key;
    }
  }

  TemporaryFolder folder_;
  std::filesystem::path policy_ = folder_.path() / "policy.dadrl";
  std::filesystem::path observations_ = folder_.path() / "observations";
  std::filesystem::path export_ = folder_.path() / "export";
  Config config_;
};

TEST_F(OpenModelTest, NumPyAgreesOnTheDefaultNetworks) {
  SavePolicyOf();
  ExpectNumPyAgrees();
  const Json act = Json::parse(Act().out);
  double spread = 0.0;
  for (size_t i = 0; i < kCount; ++i) {
    spread = std::max(spread, std::abs(act["q1"][i].get<double>() - act["q1"][0].get<double>()));
    double attention = 0.0;
    for (const Json& weight : act["attention"][i]) attention += weight.get<double>();
    EXPECT_EQ(attention == 0.0, i == 0) << "only the first road is empty";
    EXPECT_LT(attention, 1.0);
  }
  EXPECT_GT(spread, 1e-2) << "the networks see the observations";
}

TEST_F(OpenModelTest, NumPyAgreesOnAblationsAndOtherSizes) {
  config_.observation.vehicles = 3;
  config_.observation.history = 2;
  config_.model.hidden = 40;
  WriteObservations();
  for (const auto& [stae, context, layer_norm] :
       {std::tuple(false, true, false), std::tuple(true, false, true), std::tuple(true, true, false)}) {
    SCOPED_TRACE(fmt::format("stae {} context {} critic layer norm {}", stae, context, layer_norm));
    config_.model.stae = stae;
    config_.model.context = context;
    config_.model.critic_layer_norm = layer_norm;
    SavePolicyOf();
    ExpectNumPyAgrees();
    std::filesystem::remove_all(export_);
  }
}

// The same program on a machine without AVX-512, or without any vectors.
TEST_F(OpenModelTest, NumPyAgreesOnEveryInstructionSet) {
  SavePolicyOf();
  const Json best = Json::parse(Act().out);
  for (const Isa isa : {Isa::kAvx2, Isa::kScalar}) {
    if (isa >= DetectIsa()) continue;  // that one is what the other tests run
    SCOPED_TRACE(IsaName(isa));
    ASSERT_EQ(setenv("DADRL_ISA", std::string(IsaName(isa)).c_str(), 1), 0);
    ExpectNumPyAgrees();
    EXPECT_NE(Json::parse(Act().out), best) << "another order of additions";
    ASSERT_EQ(unsetenv("DADRL_ISA"), 0);
    std::filesystem::remove_all(export_);
  }
}

TEST_F(OpenModelTest, FileWithoutCriticsHasNoValues) {
  SavePolicyOf(false);
  ExpectNumPyAgrees();
  EXPECT_FALSE(Json::parse(Act().out).contains("q1"));
  EXPECT_FALSE(std::filesystem::exists(export_ / "critic"));
}

TEST_F(OpenModelTest, IndexDescribesEveryFile) {
  SavePolicyOf();
  ASSERT_EQ(Export().exit_code, 0);
  const Json index = Json::parse(FileText(export_ / "index.json"));
  EXPECT_EQ(index["format"], 1);
  EXPECT_EQ(index["source"], "policy.dadrl");
  EXPECT_EQ(index["updates"], 70);
  size_t files = 2;  // index.json and config.yaml
  for (const auto& [network, tensors] : index["networks"].items()) {
    for (const Json& tensor : tensors) {
      ++files;
      EXPECT_EQ(tensor["file"], network + "/" + tensor["name"].get<std::string>() + ".npy");
      const auto array = ReadNpy<float>(export_ / tensor["file"].get<std::string>(), 1 << 24);
      ASSERT_TRUE(array) << array.error().message;
      EXPECT_EQ(Json(array->shape), tensor["shape"]);
    }
  }
  const auto written = std::filesystem::recursive_directory_iterator(export_);
  EXPECT_EQ(std::count_if(begin(written), end(written), [](const auto& e) { return e.is_regular_file(); }),
            static_cast<long>(files));
  Config config;
  EXPECT_TRUE(LoadYaml(export_ / index["config"].get<std::string>(), config));
}

TEST_F(OpenModelTest, ShowsALineAnObservation) {
  SavePolicyOf();
  const CommandOutput output = Act(false);
  EXPECT_EQ(output.exit_code, 0);
  EXPECT_EQ(std::count(output.out.begin(), output.out.end(), '\n'), static_cast<long>(kCount) + 1);
}

TEST_F(OpenModelTest, SecondExportIntoTheSameFolderIsRefused) {
  SavePolicyOf();
  ASSERT_EQ(Export().exit_code, 0);
  const CommandOutput again = Export();
  EXPECT_EQ(again.exit_code, 2);
  EXPECT_THAT(again.err, HasSubstr("is not empty: choose a new folder"));
}

TEST_F(OpenModelTest, FolderThatCannotBeIsNamed) {
  SavePolicyOf();
  const CommandOutput output = Dadrl({"export", "--policy", policy_, "--out", policy_ / "under_a_file"});
  EXPECT_EQ(output.exit_code, 1);
  EXPECT_THAT(output.err, HasSubstr("under_a_file"));
}

class BadPolicyTest : public OpenModelTest {
 protected:
  void Save(const PolicyFile& file) {
    PolicyToSave policy{.config_yaml = ToYaml(file.config, false), .networks = {}};
    for (const StoredNetwork& network : file.networks) policy.networks.push_back(network.view());
    ASSERT_TRUE(SavePolicy(policy_, policy));
  }
  void ExpectRefused(int exit_code, const std::string& message) {
    for (const CommandOutput& output : {Export(), Act()}) {
      EXPECT_EQ(output.exit_code, exit_code) << output.err;
      EXPECT_THAT(output.out, IsEmpty());
      EXPECT_THAT(output.err, HasSubstr(message));
      EXPECT_EQ(std::count(output.err.begin(), output.err.end(), '\n'), 1) << output.err;
    }
    EXPECT_FALSE(std::filesystem::exists(export_));
  }
};

TEST_F(BadPolicyTest, Missing) { ExpectRefused(1, policy_); }

TEST_F(BadPolicyTest, NoPolicyAtAll) {
  std::ofstream(policy_) << "something else, whatever it is called";
  ExpectRefused(1, "is not a policy file");
}

TEST_F(BadPolicyTest, OtherNetworksThanItsConfiguration) {
  SavePolicyOf();
  PolicyFile file = LoadPolicy(policy_).value();
  file.config.model.hidden = 80;
  Save(file);
  ExpectRefused(2, "network 'policy' of another layout");
}

TEST_F(BadPolicyTest, CriticsOfAnotherLength) {
  SavePolicyOf();
  PolicyFile file = LoadPolicy(policy_).value();
  file.networks.at(1).parameters.pop_back();
  Save(file);
  ExpectRefused(2, "network 'critic' of another layout");
}

TEST_F(BadPolicyTest, NetworkOfAnotherProgram) {
  SavePolicyOf();
  PolicyFile file = LoadPolicy(policy_).value();
  file.networks.at(1).name = "prophet";
  Save(file);
  ExpectRefused(2, "network 'prophet' is none that this program knows");
}

TEST_F(BadPolicyTest, PolicyOfAnotherProgram) {
  SavePolicyOf();
  PolicyFile file = LoadPolicy(policy_).value();
  file.config.model.policy = "squashed_cauchy";
  Save(file);
  ExpectRefused(2, "model.policy: 'squashed_cauchy' is unknown");
}

class BadObservationsTest : public OpenModelTest {
 protected:
  void SetUp() override {
    OpenModelTest::SetUp();
    SavePolicyOf();
  }
  void ExpectRefused(int exit_code, const std::string& message) {
    const CommandOutput output = Act();
    EXPECT_EQ(output.exit_code, exit_code) << output.err;
    EXPECT_THAT(output.out, IsEmpty());
    EXPECT_THAT(output.err, HasSubstr(message));
    EXPECT_EQ(std::count(output.err.begin(), output.err.end(), '\n'), 1) << output.err;
  }
};

TEST_F(BadObservationsTest, MissingArray) {
  std::filesystem::remove(observations_ / "ego.npy");
  ExpectRefused(1, "ego.npy");
}

TEST_F(BadObservationsTest, WrongShapes) {
  Write("vehicles", {1, 5, 5, 7}, std::vector<float>(175));
  ExpectRefused(2, "vehicles.npy has shape (1, 5, 5, 7), the policy's configuration needs (N, 6, 5, 7)");
  Write("vehicles", {6, 5, 7}, std::vector<float>(210));
  ExpectRefused(2, "vehicles.npy has shape (6, 5, 7)");
  Write("vehicles", {0, 6, 5, 7}, std::vector<float>());
  ExpectRefused(2, "with N from 1");
}

TEST_F(BadObservationsTest, TooMany) {
  Write("ego", {20'100, 5, 20}, std::vector<float>(20'100 * 100));
  ExpectRefused(2, "ego.npy is longer than 20000 observations of shape (5, 20): take fewer");
}

TEST_F(BadObservationsTest, CountsThatDiffer) {
  Write("ego", {2, 5, 20}, std::vector<float>(200));
  ExpectRefused(2, "ego.npy holds 2 observations, the first column 19: record them together");
}

TEST_F(BadObservationsTest, WrongTypes) {
  Write("ego", {kCount, 5, 20}, std::vector<double>(kCount * 100));
  ExpectRefused(2, "ego.npy holds numbers of type '<f8', '<f4' is needed");
  Write("ego", {kCount, 5, 20}, std::vector<float>(kCount * 100));
  Write("context", {kCount, 2, 128, 128}, std::vector<float>(kCount * 2 * 128 * 128));
  ExpectRefused(2, "context.npy holds numbers of type '<f4', '|u1' is needed");
}

TEST_F(BadObservationsTest, ColumnMajorDamagedOrNoArray) {
  const auto ego = observations_ / "ego.npy";
  std::string text = FileText(ego);
  const std::string good = text;
  text.replace(text.find("False"), 5, "True ");
  std::ofstream(ego, std::ios::binary) << text;
  ExpectRefused(2, "column-major");
  std::ofstream(ego, std::ios::binary) << good.substr(0, good.size() - 1);
  ExpectRefused(1, "is damaged");
  std::ofstream(ego, std::ios::binary) << "1,2,3\n";
  ExpectRefused(1, "ego.npy is no .npy file");
}

TEST_F(BadObservationsTest, ValuesThatCannotBe) {
  std::vector<float> ego(kCount * 100);
  ego[250] = std::nanf("");
  Write("ego", {kCount, 5, 20}, ego);
  ExpectRefused(2, "ego.npy: observation 2 has a value that is not finite (nan)");
  ego[250] = 0.0f;
  Write("ego", {kCount, 5, 20}, ego);
  std::vector<uint8_t> pixels(kCount * 2 * 128 * 128);
  pixels[3 * 2 * 128 * 128 + 7] = 255;
  Write("context", {kCount, 2, 128, 128}, pixels);
  ExpectRefused(2, "context.npy: observation 3 has a pixel of 255, only 0 and 1");
}

}  // namespace
}  // namespace dadrl
