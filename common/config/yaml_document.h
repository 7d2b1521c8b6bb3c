// YAML from outside as a plain tree, for everybody who reads any: configurations, scenarios, the heads of
// policy files, what a run tells those who join it. Read event by event within limits, so that no file makes
// its reader recurse, expand or allocate without bound.
#pragma once

#include <cstddef>
#include <filesystem>
#include <string>
#include <string_view>
#include <vector>

#include "common/util/result.h"

namespace dadrl {

constexpr size_t kMaxYamlBytes = size_t{256} << 10;
constexpr int kMaxYamlDepth = 16;
constexpr int kMaxYamlNodes = 20000;

struct YamlEntry;

struct YamlNode {
  enum class Kind { kNull, kScalar, kList, kMap };
  Kind kind = Kind::kNull;
  int line = 1;
  std::string text;                // of a scalar
  std::vector<YamlNode> items;     // of a list
  std::vector<YamlEntry> entries;  // of a map, in the file's order; keys are unique

  bool IsScalar() const { return kind == Kind::kScalar; }
  bool IsList() const { return kind == Kind::kList; }
  bool IsMap() const { return kind == Kind::kMap; }
  // Of a map; null when there is no such key.
  const YamlNode* Find(std::string_view key) const;
};

struct YamlEntry {
  std::string key;
  int line = 1;
  YamlNode value;
};

// Of `text`; `origin` names it in errors, each "ORIGIN:LINE: reason". kInvalidArgument: it is not one YAML
// document of scalars, lists and maps with scalar keys; it holds an alias, an anchor, a tag, a key twice, or
// a control character; or it exceeds one of the limits above. An empty document is kNull.
Result<YamlNode> ParseYamlDocument(std::string_view text, std::string_view origin);

// The same of a file that a user named. Errors of ReadTextFile too. Blocks on the disk.
Result<YamlNode> LoadYamlDocument(const std::filesystem::path& file);

}  // namespace dadrl
