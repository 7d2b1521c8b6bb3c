#include "common/io/json_text.h"

#include <cmath>

#include "common/util/shown.h"

namespace dadrl {
namespace {

using Json = nlohmann::ordered_json;

struct TooDeep {};

}  // namespace

Result<Json> ParseJson(std::string_view text, std::string_view origin) {
  const auto limit_depth = [](int depth, Json::parse_event_t event, const Json&) {
    // The first level begins at depth 0.
    const bool begins =
        event == Json::parse_event_t::array_start || event == Json::parse_event_t::object_start;
    if (begins && depth >= kMaxJsonDepth) throw TooDeep();
    return true;
  };
  try {
    return Json::parse(text, limit_depth);
  } catch (const TooDeep&) {
    return Fail(ErrorCode::kCorrupt, "{} is nested deeper than {} levels", origin, kMaxJsonDepth);
  } catch (const Json::exception& exception) {
    return Fail(ErrorCode::kCorrupt, "{} is not JSON: {}", origin, Shown(exception.what(), 200));
  }
}

const Json* JsonFields::Find(const char* key) const {
  if (!object_.is_object()) return nullptr;
  const auto found = object_.find(key);
  return found == object_.end() ? nullptr : &*found;
}

uint64_t JsonFields::Whole(const char* key, uint64_t max) {
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
