#include "common/config/config_yaml.h"

#include <yaml-cpp/yaml.h>

#include <algorithm>
#include <fstream>
#include <sstream>

#include "common/config/config_schema.h"

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
    return Fail(ErrorCode::kInvalidArgument, "{}unknown key '{}'; the nearest is '{}'", where, key,
                NearestName(key, KeysOf(fields)));
  }
  Status assigned = AssignValue(*field, value);
  if (!assigned) return Fail(assigned.error().code, "{}{}", where, assigned.error().message);
  return {};
}

Status AssignNode(const std::vector<ConfigField>& fields, const YAML::Node& node, const std::string& prefix,
                  std::string_view origin) {
  for (const auto& entry : node) {
    const std::string name = entry.first.as<std::string>();
    const std::string key = prefix.empty() ? name : prefix + "." + name;
    if (entry.second.IsMap()) {
      DADRL_RETURN_IF_ERROR(AssignNode(fields, entry.second, key, origin));
      continue;
    }
    const std::string where = fmt::format("{}:{}: ", origin, entry.first.Mark().line + 1);
    if (!entry.second.IsScalar()) {
      return Fail(ErrorCode::kInvalidArgument, "{}'{}' needs one value", where, key);
    }
    DADRL_RETURN_IF_ERROR(AssignKey(fields, key, entry.second.Scalar(), where));
  }
  return {};
}

// Overlays what stands under the top-level keys that `wanted(name)` accepts.
template <typename Wanted>
Status ParseRoot(std::string_view text, std::string_view origin, Wanted wanted, Config& config) {
  try {
    const YAML::Node root = YAML::Load(std::string(text));
    if (root.IsNull()) return {};
    if (!root.IsMap()) return Fail(ErrorCode::kInvalidArgument, "{}: expected 'key: value' lines", origin);
    YAML::Node chosen(YAML::NodeType::Map);
    for (const auto& entry : root) {
      if (wanted(entry.first.as<std::string>())) chosen[entry.first] = entry.second;
    }
    return AssignNode(SchemaOf(config), chosen, "", origin);
  } catch (const YAML::Exception& exception) {
    return Fail(ErrorCode::kInvalidArgument, "{}: not YAML: {}", origin, exception.what());
  }
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
  return ParseRoot(
      text, origin, [](const std::string&) { return true; }, config);
}

Status ParseYamlSections(std::string_view text, std::string_view origin,
                         std::span<const std::string_view> sections, Config& config) {
  const auto wanted = [&](const std::string& name) {
    return std::find(sections.begin(), sections.end(), name) != sections.end();
  };
  return ParseRoot(text, origin, wanted, config);
}

Status LoadYaml(const std::filesystem::path& file, Config& config) {
  std::ifstream stream(file);
  if (!stream) return Fail(ErrorCode::kInvalidArgument, "cannot read configuration {}", file.string());
  std::stringstream text;
  text << stream.rdbuf();
  return ParseYaml(text.str(), file.string(), config);
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
