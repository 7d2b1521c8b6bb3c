#include "common/config/config_yaml.h"

#include <algorithm>

#include "common/config/config_schema.h"
#include "common/config/yaml_document.h"
#include "common/io/read_file.h"
#include "common/util/shown.h"

namespace dadrl {
namespace {

std::vector<std::string> KeysOf(const std::vector<ConfigField>& fields) {
  std::vector<std::string> keys;
  for (const ConfigField& field : fields) keys.push_back(field.key);
  return keys;
}

Status AssignKey(const std::vector<ConfigField>& fields, const std::string& key, const std::string& value,
                 const std::string& where) {
  const auto field =
      std::find_if(fields.begin(), fields.end(), [&](const ConfigField& f) { return f.key == key; });
  if (field == fields.end()) {
    return Fail(ErrorCode::kInvalidArgument, "{}unknown key '{}'; the nearest is '{}'", where, Shown(key),
                NearestName(key, KeysOf(fields)));
  }
  Status assigned = AssignValue(*field, value);
  if (!assigned) return Fail(assigned.error().code, "{}{}", where, assigned.error().message);
  return {};
}

// "task" of "task.max_steps", "task" and "task.reward" of "task.reward.crash".
std::vector<std::string> SectionsOf(const std::vector<ConfigField>& fields) {
  std::vector<std::string> sections;
  for (const ConfigField& field : fields) {
    for (size_t dot = field.key.find('.'); dot != std::string::npos; dot = field.key.find('.', dot + 1)) {
      sections.push_back(field.key.substr(0, dot));
    }
  }
  return sections;
}

bool Contains(const std::vector<std::string>& names, const std::string& name) {
  return std::ranges::find(names, name) != names.end();
}

Status AssignNode(const std::vector<ConfigField>& fields, const YamlNode& node, const std::string& prefix,
                  std::string_view origin) {
  const std::vector<std::string> sections = SectionsOf(fields);
  for (const YamlEntry& entry : node.entries) {
    const std::string key = prefix.empty() ? entry.key : prefix + "." + entry.key;
    const std::string where = fmt::format("{}:{}: ", origin, entry.line);
    const bool section = Contains(sections, key);
    if (entry.value.IsScalar() && !section) {
      DADRL_RETURN_IF_ERROR(AssignKey(fields, key, entry.value.text, where));
    } else if (entry.value.IsMap() && section) {
      DADRL_RETURN_IF_ERROR(AssignNode(fields, entry.value, key, origin));
    } else if (section) {
      return Fail(ErrorCode::kInvalidArgument, "{}'{}' needs 'key: value' lines below it", where, key);
    } else if (Contains(KeysOf(fields), key)) {
      return Fail(ErrorCode::kInvalidArgument, "{}'{}' needs one value", where, key);
    } else {
      return Fail(ErrorCode::kInvalidArgument, "{}unknown section '{}'; the nearest is '{}'", where,
                  Shown(key), NearestName(key, sections));
    }
  }
  return {};
}

Status CheckRoot(const YamlNode& root, std::string_view origin) {
  if (root.IsMap() || root.kind == YamlNode::Kind::kNull) return {};
  return Fail(ErrorCode::kInvalidArgument, "{}:{}: expected 'key: value' lines", origin, root.line);
}

// "a.b.c" under "a.d" shares "a": prints the section heads that `key` opens.
void OpenSections(std::string& out, const std::string& key, const std::string& previous, size_t& depth) {
  size_t common = 0;
  for (size_t dot = key.find('.'); dot != std::string::npos; dot = key.find('.', dot + 1)) {
    if (previous.compare(0, dot + 1, key, 0, dot + 1) == 0) common = dot + 1;
  }
  depth = static_cast<size_t>(std::count(key.begin(), key.begin() + static_cast<long>(common), '.'));
  for (size_t start = common, dot = key.find('.', start); dot != std::string::npos;
       start = dot + 1, dot = key.find('.', start)) {
    out += fmt::format("{:{}}{}:\n", "", 2 * depth, key.substr(start, dot - start));
    ++depth;
  }
}

std::string Range(const ConfigField& field) {
  if (!field.choices.empty()) return fmt::format(" ({})", fmt::join(field.choices, " | "));
  if (field.min < field.max) return fmt::format(" ({:g} to {:g})", field.min, field.max);
  return "";
}

}  // namespace

Status ParseYaml(std::string_view text, std::string_view origin, Config& config) {
  DADRL_ASSIGN_OR_RETURN(const YamlNode root, ParseYamlDocument(text, origin));
  DADRL_RETURN_IF_ERROR(CheckRoot(root, origin));
  return AssignNode(SchemaOf(config), root, "", origin);
}

Status ParseYamlSections(std::string_view text, std::string_view origin,
                         std::span<const std::string_view> sections, Config& config) {
  DADRL_ASSIGN_OR_RETURN(YamlNode root, ParseYamlDocument(text, origin));
  DADRL_RETURN_IF_ERROR(CheckRoot(root, origin));
  std::erase_if(root.entries, [&](const YamlEntry& entry) {
    return std::ranges::find(sections, entry.key) == sections.end();
  });
  return AssignNode(SchemaOf(config), root, "", origin);
}

Status LoadYaml(const std::filesystem::path& file, Config& config, Links links) {
  const Result<std::string> text = ReadTextFile(file, kMaxYamlBytes, links);
  if (!text) return Fail(ErrorCode::kInvalidArgument, "cannot read configuration: {}", text.error().message);
  return ParseYaml(*text, file.string(), config);
}

Status ApplyOverride(std::string_view assignment, Config& config) {
  const size_t equals = assignment.find('=');
  if (equals == std::string_view::npos) {
    return Fail(ErrorCode::kInvalidArgument, "--set {}: expected key=value", assignment);
  }
  return AssignKey(SchemaOf(config), std::string(assignment.substr(0, equals)),
                   std::string(assignment.substr(equals + 1)), "--set: ");
}

std::string ToYaml(const Config& config, bool explain) {
  Config copy = config;
  std::string out;
  std::string previous;
  for (const ConfigField& field : SchemaOf(copy)) {
    size_t depth = 0;
    OpenSections(out, field.key, previous, depth);
    const std::string leaf = field.key.substr(field.key.rfind('.') + 1);
    if (explain) out += fmt::format("{:{}}# {}{}\n", "", 2 * depth, field.help, Range(field));
    out += fmt::format("{:{}}{}: {}\n", "", 2 * depth, leaf, FormatValue(field));
    previous = field.key;
  }
  return out;
}

}  // namespace dadrl
