// One table of every configuration key: loader, writer, `--set`, range checks and documentation all walk it.
#pragma once

#include <cstdint>
#include <string>
#include <string_view>
#include <variant>
#include <vector>

#include "common/config/config.h"
#include "common/util/result.h"

namespace dadrl {

// The value of `scenario` that means all of them: every episode's seed chooses one.
inline constexpr const char* kAllScenarios = "all";

struct ConfigField {
  std::string key;   // dotted: "algorithm.gamma"
  std::string help;  // one sentence, with the unit
  double min = 0.0;  // inclusive, numbers only
  double max = 0.0;
  std::string reason;                // of the range, where it is no matter of taste: part of the refusal
  std::vector<std::string> choices;  // enumerations only

  // Into the Config that SchemaOf was given. Enumerations are seen as an index into `choices`.
  struct EnumTarget {
    void* target;
    int (*get)(const void*);
    void (*set)(void*, int);
  };
  std::variant<bool*, int*, int64_t*, uint64_t*, double*, std::string*, EnumTarget> target;
};

// Every field of `config`, in the order they are written. The pointers live as long as `config`.
std::vector<ConfigField> SchemaOf(Config& config);

// The value as YAML text ("0.998", "shared", "true").
std::string FormatValue(const ConfigField& field);

// Parses and range-checks `text`; the error names key, value and range or choices.
Status AssignValue(const ConfigField& field, std::string_view text);

// The candidate with the smallest edit distance: "did you mean ...".
std::string NearestName(std::string_view name, const std::vector<std::string>& candidates);

}  // namespace dadrl
