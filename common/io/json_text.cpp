#include "common/io/json_text.h"

#include <array>
#include <cmath>
#include <set>

#include "common/util/shown.h"

namespace dadrl {
namespace {

using Json = nlohmann::ordered_json;

struct Refused {
  std::string reason;
};

// Ends the parsing before what it builds grows too deep or too slow.
class Limits {
 public:
  void Check(int depth, Json::parse_event_t event, const Json& parsed) {
    const auto level = static_cast<size_t>(depth);
    const bool object = event == Json::parse_event_t::object_start;
    if (object || event == Json::parse_event_t::array_start) {
      // The first level begins at depth 0.
      if (depth >= kMaxJsonDepth) {
        throw Refused{fmt::format("is nested deeper than {} levels", kMaxJsonDepth)};
      }
      if (object) keys_[level].clear();
    } else if (event == Json::parse_event_t::key) {
      // A key is one level deeper than its object.
      std::set<std::string>& keys = keys_[level - 1];
      const std::string& key = parsed.get_ref<const std::string&>();
      if (!keys.insert(key).second) throw Refused{fmt::format("names '{}' twice", Shown(key))};
      if (keys.size() > kMaxJsonKeys) {
        throw Refused{fmt::format("has an object of more than {} fields", kMaxJsonKeys)};
      }
    }
  }

 private:
  std::array<std::set<std::string>, kMaxJsonDepth> keys_;  // of the object begun at each level
};

}  // namespace

Result<Json> ParseJson(std::string_view text, std::string_view origin) {
  Limits limits;
  const auto check = [&limits](int depth, Json::parse_event_t event, const Json& parsed) {
    limits.Check(depth, event, parsed);
    return true;
  };
  try {
    return Json::parse(text, check);
  } catch (const Refused& refused) {
    return Fail(ErrorCode::kCorrupt, "{} {}", origin, refused.reason);
  } catch (const Json::exception& exception) {
    return Fail(ErrorCode::kCorrupt, "{} is not JSON: {}", origin, Shown(exception.what(), 200));
  }
}

const Json* JsonFields::Find(const char* key) const {
  if (!object_.is_object()) return nullptr;
  const auto found = object_.find(key);
  return found == object_.end() ? nullptr : &*found;
}

uint64_t JsonFields::Unsigned(const char* key, uint64_t max) {
  const Json* const value = Find(key);
  if (value == nullptr || !value->is_number_unsigned() || value->get<uint64_t>() > max) Refuse(key);
  return ok() ? value->get<uint64_t>() : 0;
}

double JsonFields::Number(const char* key, double min, double max) {
  const Json* const value = Find(key);
  const double number = value != nullptr && value->is_number() ? value->get<double>() : std::nan("");
  if (!(number >= min && number <= max)) Refuse(key);
  return ok() ? number : 0.0;
}

bool JsonFields::Boolean(const char* key) {
  const Json* const value = Find(key);
  if (value == nullptr || !value->is_boolean()) Refuse(key);
  return ok() && value->get<bool>();
}

std::string JsonFields::Text(const char* key, size_t most_bytes) {
  const Json* const value = Find(key);
  if (value == nullptr || !value->is_string() || value->get_ref<const std::string&>().size() > most_bytes)
    Refuse(key);
  return ok() ? value->get<std::string>() : std::string();
}

}  // namespace dadrl
