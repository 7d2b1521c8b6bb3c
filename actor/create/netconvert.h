// Road networks by SUMO's netconvert.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "common/util/result.h"

namespace dadrl {

// Where a road comes from.
struct RoadSource {
  std::filesystem::path file;
  bool osm = false;        // an OpenStreetMap extract; else a .net.xml, or plain XML
  bool left_hand = false;  // where one drives on the left: no file of these says so, except a .net.xml
};

// Writes the network of `source` to `output`, a new .net.xml: a .net.xml is copied as it is; plain XML is its
// NAME.nod.xml, with NAME.edg.xml and whatever there is of NAME.con.xml, .tll.xml and .typ.xml beside it;
// a map is read by the types that netconvert has for OpenStreetMap. Runs netconvert and waits for it.
// kInvalidArgument: the file is something else, or netconvert refuses it, in its words. kNotFound: there is
// no such file, or no netconvert.
Status BuildNetwork(const RoadSource& source, const std::filesystem::path& output);

// Runs `command`, searched in PATH, and returns what it said on standard error. kNotFound: no such program;
// kInvalidArgument: it ended with another exit code than 0, with the end of what it said.
Result<std::string> RunProgram(const std::vector<std::string>& command);

}  // namespace dadrl
