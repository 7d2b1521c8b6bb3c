// What the program owns of SUMO's options, under every name that SUMO knows them by.
#include "actor/sim/sumo_options.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cstdio>
#include <regex>
#include <set>
#include <string>

namespace dadrl {
namespace {

using testing::HasSubstr;

// "  -n, --net-file FILE": both names of every option that this SUMO has.
std::vector<std::pair<std::string, std::string>> OptionsOfSumo() {
  std::FILE* const help = popen("sumo --help 2>/dev/null", "re");
  std::string text;
  for (int c = 0; (c = std::fgetc(help)) != EOF;) text += static_cast<char>(c);
  pclose(help);
  std::vector<std::pair<std::string, std::string>> options;
  const std::regex line(R"(\n +(?:-(\S), )?--([a-zA-Z0-9.-]+))");
  for (std::sregex_iterator at(text.begin(), text.end(), line), end; at != end; ++at) {
    options.emplace_back((*at)[2], (*at)[1]);
  }
  return options;
}

const std::set<std::string> kOwned = {"step-length",
                                      "seed",
                                      "random",
                                      "begin",
                                      "end",
                                      "net-file",
                                      "load-state",
                                      "load-state.offset",
                                      "load-state.remove-vehicles",
                                      "configuration-file",
                                      "save-configuration",
                                      "save-configuration.relative",
                                      "save-template",
                                      "save-schema",
                                      "save-commented",
                                      "remote-port",
                                      "num-clients",
                                      "gui-settings-file",
                                      "help",
                                      "version",
                                      "print-options",
                                      "verbose",
                                      "no-step-log",
                                      "step-log.period",
                                      "duration-log.statistics"};

bool WritesAFile(const std::string& name) {
  static const std::set<std::string> kOthers = {"log", "message-log", "error-log", "netstate-dump",
                                                "output-prefix"};
  return name.ends_with("output") || name.ends_with(".file") || name.starts_with("save-") ||
         kOthers.contains(name);
}

TEST(SumoOptions, AreRefusedByLongAndShortNameWhereTheProgramOwnsThemAndTakenOtherwise) {
  const auto options = OptionsOfSumo();
  ASSERT_GT(options.size(), 200u);
  std::set<std::string> met;
  for (const auto& [name, letter] : options) {
    if (kOwned.contains(name)) met.insert(name);
    const bool owned = kOwned.contains(name) || WritesAFile(name);
    EXPECT_EQ(ScenarioOption(name).has_value(), !owned) << name;
    EXPECT_EQ(ScenarioOption("--" + name).has_value(), !owned) << name;
    if (letter.empty()) continue;
    EXPECT_EQ(ScenarioOption(letter).has_value(), !owned) << letter;
    EXPECT_EQ(ScenarioOption("-" + letter).has_value(), !owned) << letter;
  }
  EXPECT_EQ(met, kOwned);  // none of them under a name that SUMO has not
}

TEST(SumoOptions, OwnedOnesAreRefusedByTheirOldNames) {
  for (const char* name : {"net", "srand", "abs-rand", "configuration", "save-config"}) {
    EXPECT_FALSE(ScenarioOption(name)) << name;
  }
  EXPECT_THAT(ScenarioOption("step-length").error().message, HasSubstr("driver.actionStepLength"));
  EXPECT_THAT(ScenarioOption("verbose").error().message, HasSubstr("standard output is the program's own"));
}

TEST(SumoOptions, NamesThatWouldBeTwoWordsAreNone) {
  for (const char* name : {"seed=1", "step-length 0.5", "", "--", "a\nb", "x\"y", "é"}) {
    ASSERT_FALSE(ScenarioOption(name)) << name;
    EXPECT_THAT(ScenarioOption(name).error().message, HasSubstr("is not the name of an option"));
  }
}

TEST(SumoOptions, FilesOfTheScenariosOwnGoByTheirLongName) {
  for (const char* name : {"route-files", "routes", "r", "-r", "--routes"}) {
    EXPECT_EQ(ScenarioOption(name).value(), kRouteFiles) << name;
  }
  for (const char* name : {"additional-files", "additional", "a", "--additional-files"}) {
    EXPECT_EQ(ScenarioOption(name).value(), kAdditionalFiles) << name;
  }
}

}  // namespace
}  // namespace dadrl
