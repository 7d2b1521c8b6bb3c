// What the targets of files and lines share: files in memory, and what a refusal looks like.
#pragma once

#include <algorithm>
#include <filesystem>
#include <span>
#include <string>
#include <string_view>

#include "common/util/result.h"
#include "tests/common/io/temporary_folder.h"
#include "tests/fuzz/harness.h"

namespace dadrl::fuzz {

// Where this process keeps its inputs.
inline const std::filesystem::path& Folder() {
  static const MemoryFolder folder;
  return folder.path();
}

// `bytes` as a file of that name in Folder().
inline std::filesystem::path Written(const std::filesystem::path& name, std::span<const std::byte> bytes) {
  const std::filesystem::path path = Folder() / name;
  std::filesystem::create_directories(path.parent_path());
  WritePlainly(path, bytes);
  return path;
}

inline std::string_view AsText(std::span<const std::byte> bytes) {
  return {reinterpret_cast<const char*>(bytes.data()), bytes.size()};
}

inline Bytes AsBytes(std::string_view text) {
  const std::span<const std::byte> bytes = std::as_bytes(std::span(text));
  return {bytes.begin(), bytes.end()};
}

inline std::string Repeated(std::string_view text, size_t times) {
  std::string all;
  for (size_t i = 0; i < times; ++i) all += text;
  return all;
}

// True when there is a value; a refusal is one line that a person can read, and a terminal show.
template <typename T>
bool Accepted(const Result<T>& result) {
  constexpr size_t kLongestReason = 2000;
  if (result) return true;
  const std::string& reason = result.error().message;
  Require(!reason.empty() && reason.size() < kLongestReason);
  Require(std::ranges::none_of(reason, [](char c) { return (c >= 0 && c < ' ') || c == 0x7f; }));
  return false;
}

// YAML that would make a careless reader recurse, expand or take more than it can hold.
inline std::vector<Bytes> BadYaml() {
  std::vector<Bytes> bad;
  for (const std::string& text :
       {std::string("task: &t\n  reward: *t\n"), std::string("a: &a [1]\nb: [*a, *a]\n"),
        std::string("task: {nonsense: {}}\n"), Repeated("[", 100000), Repeated("- ", 5000),
        Repeated("{a: ", 5000), Repeated("? ", 5000), std::string("a: !tag b\n"),
        std::string("seed: 1\nseed: 2\n"), std::string(300000, 'a'), std::string("seed: \0", 7),
        std::string("- 1\n- 2\n"), std::string("? [1]\n: 2\n"), std::string("seed: 1\n---\nseed: 2\n")}) {
    bad.push_back(AsBytes(text));
  }
  return bad;
}

// The same of JSON.
inline std::vector<Bytes> BadJson() {
  const std::string deep = Repeated("[", 20000);
  return {AsBytes(deep),
          AsBytes(deep + Repeated("]", 20000)),
          AsBytes(Repeated(R"({"a":)", 20000)),
          AsBytes(R"({"state": "running", "state": "finished"})"),
          AsBytes("[1]"),
          AsBytes("\xff")};
}

}  // namespace dadrl::fuzz
