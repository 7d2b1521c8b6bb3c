// JSON from outside: what an earlier session, another process or a user left. Read within limits, because
// nlohmann's copies and dumps recurse as deep as the text does, and its ordered objects look for a key among
// all that they have.
#pragma once

#include <concepts>
#include <cstdint>
#include <nlohmann/json.hpp>
#include <string>
#include <string_view>

#include "common/util/result.h"

namespace dadrl {

constexpr int kMaxJsonDepth = 16;
constexpr size_t kMaxJsonKeys = 1000;  // of one object

// kCorrupt, with `origin` in front, when `text` is no JSON, not UTF-8, nested deeper than kMaxJsonDepth, or
// has an object with a key twice or with more than kMaxJsonKeys. The caller bounds the length.
Result<nlohmann::ordered_json> ParseJson(std::string_view text, std::string_view origin);

// Typed fields of an object that it borrows, never truncated or guessed. After the first that is missing or
// out of range, bad() names it, and every value is zero or empty: check it once, at the end.
class JsonFields {
 public:
  explicit JsonFields(const nlohmann::ordered_json& object) : object_(object) {}

  // From 0 to `max`.
  template <std::integral T>
  T Whole(const char* key, T max) {
    return static_cast<T>(Unsigned(key, static_cast<uint64_t>(max)));
  }
  double Number(const char* key, double min, double max);  // JSON has no NaN and no infinity
  bool Boolean(const char* key);
  std::string Text(const char* key, size_t most_bytes);

  bool Has(const char* key) const { return Find(key) != nullptr; }
  // Null when it is missing.
  const nlohmann::ordered_json* Find(const char* key) const;
  void Refuse(const char* key) {
    if (bad_.empty()) bad_ = key;
  }
  bool ok() const { return bad_.empty(); }
  const std::string& bad() const { return bad_; }

 private:
  uint64_t Unsigned(const char* key, uint64_t max);

  const nlohmann::ordered_json& object_;
  std::string bad_;
};

}  // namespace dadrl
