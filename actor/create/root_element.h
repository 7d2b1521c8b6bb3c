// What kind of road file one has, whatever it is called.
#pragma once

#include <filesystem>
#include <string>

#include "common/util/result.h"

namespace dadrl {

// The name of the first element of an XML file ("net", "osm", "nodes", ...); empty where the file is not XML,
// "?" where it is compressed. kNotFound: no such file; kInvalidArgument: it is a folder.
Result<std::string> RootElement(const std::filesystem::path& file);

}  // namespace dadrl
