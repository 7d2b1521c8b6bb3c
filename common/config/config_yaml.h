// The configuration as YAML: what a run directory keeps and a user edits.
#pragma once

#include <filesystem>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "common/config/config.h"
#include "common/io/file_descriptor.h"
#include "common/util/result.h"

namespace dadrl {

// Overlays the file's keys on `config`. Unknown keys and sections are refused with the nearest known name and
// the line; limits and further refusals: yaml_document.h.
Status LoadYaml(const std::filesystem::path& file, Config& config, Links links = Links::kFollow);
// The same for YAML text; `origin` names it in errors.
Status ParseYaml(std::string_view text, std::string_view origin, Config& config);
// Of YAML text only what stands under these top-level keys; the rest is passed over, whatever it says. For
// files that must outlive changes of keys that mean nothing to their reader.
Status ParseYamlSections(std::string_view text, std::string_view origin,
                         std::span<const std::string_view> sections, Config& config);

// One "key=value" of the command line.
Status ApplyOverride(std::string_view assignment, Config& config);

// Every key with its value; with `explain`, each preceded by its sentence and range.
std::string ToYaml(const Config& config, bool explain);

}  // namespace dadrl
