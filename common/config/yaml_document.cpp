#include "common/config/yaml_document.h"

#include <yaml-cpp/eventhandler.h>
#include <yaml-cpp/yaml.h>

#include <algorithm>
#include <optional>
#include <set>
#include <sstream>
#include <stdexcept>

#include "common/io/read_file.h"
#include "common/util/shown.h"

namespace dadrl {
namespace {

// Thrown through yaml-cpp's parser, which holds nothing that it would lose.
struct Refusal {
  int line;
  std::string reason;
};

int LineOf(const YAML::Mark& mark) { return mark.line + 1; }

// Builds the tree and refuses what is not for us at the first event of it, before the parser goes deeper.
class Builder : public YAML::EventHandler {
 public:
  YamlNode Take() { return std::move(root_); }

  void OnDocumentStart(const YAML::Mark&) override {}
  void OnDocumentEnd() override {}
  void OnAlias(const YAML::Mark& mark, YAML::anchor_t) override {
    throw Refusal{LineOf(mark), "aliases (*name) are not taken: write the value out"};
  }
  void OnNull(const YAML::Mark& mark, YAML::anchor_t anchor) override {
    Check(mark, "", anchor);
    Add(mark, YamlNode::Kind::kNull, "");
  }
  void OnScalar(const YAML::Mark& mark, const std::string& tag, YAML::anchor_t anchor,
                const std::string& value) override {
    Check(mark, tag, anchor);
    Add(mark, YamlNode::Kind::kScalar, value);
  }
  void OnSequenceStart(const YAML::Mark& mark, const std::string& tag, YAML::anchor_t anchor,
                       YAML::EmitterStyle::value) override {
    Check(mark, tag, anchor);
    Open(mark, YamlNode::Kind::kList);
  }
  void OnSequenceEnd() override { open_.pop_back(); }
  void OnMapStart(const YAML::Mark& mark, const std::string& tag, YAML::anchor_t anchor,
                  YAML::EmitterStyle::value) override {
    Check(mark, tag, anchor);
    Open(mark, YamlNode::Kind::kMap);
  }
  void OnMapEnd() override { open_.pop_back(); }

 private:
  // A list or a map whose end has not come. The nodes around it do not move until then: only the innermost
  // grows.
  struct OpenNode {
    YamlNode* node;
    std::set<std::string> keys;
    bool key_read = false;
  };

  void Check(const YAML::Mark& mark, const std::string& tag, YAML::anchor_t anchor) {
    if (anchor != 0) throw Refusal{LineOf(mark), "anchors (&name) are not taken: write the value out"};
    // "?" and "!" are what yaml-cpp gives to values without a tag, and to quoted ones.
    if (!tag.empty() && tag != "?" && tag != "!") {
      throw Refusal{LineOf(mark), fmt::format("the tag {} is not taken: remove it", Shown(tag))};
    }
    if (++nodes_ > kMaxYamlNodes) {
      throw Refusal{LineOf(mark), fmt::format("more than {} values: shorten it", kMaxYamlNodes)};
    }
  }

  void Open(const YAML::Mark& mark, YamlNode::Kind kind) {
    if (std::ssize(open_) == kMaxYamlDepth) {
      throw Refusal{LineOf(mark), fmt::format("nested deeper than {} levels", kMaxYamlDepth)};
    }
    open_.push_back({.node = Add(mark, kind, ""), .keys = {}});
  }

  YamlNode* Add(const YAML::Mark& mark, YamlNode::Kind kind, const std::string& text) {
    YamlNode node{.kind = kind, .line = LineOf(mark), .text = text, .items = {}, .entries = {}};
    if (open_.empty()) return &(root_ = std::move(node));
    OpenNode& open = open_.back();
    if (open.node->IsList()) return &open.node->items.emplace_back(std::move(node));
    if (!open.key_read) return AddKey(node);
    open.key_read = false;
    return &(open.node->entries.back().value = std::move(node));
  }

  YamlNode* AddKey(const YamlNode& node) {
    if (!node.IsScalar()) throw Refusal{node.line, "a key must be one word"};
    OpenNode& open = open_.back();
    if (!open.keys.insert(node.text).second) {
      throw Refusal{node.line, fmt::format("the key '{}' stands here a second time", Shown(node.text))};
    }
    open.node->entries.push_back({.key = node.text, .line = node.line, .value = {}});
    open.key_read = true;
    return nullptr;
  }

  YamlNode root_;
  std::vector<OpenNode> open_;
  int nodes_ = 0;
};

// What tells a binary file, or one in UTF-16: no text in UTF-8 has them.
std::optional<Refusal> FindControlCharacter(std::string_view text) {
  const auto bad = std::ranges::find_if(text, [](char c) {
    const auto byte = static_cast<unsigned char>(c);
    return (byte < 0x20 && c != '\t' && c != '\n' && c != '\r') || byte == 0x7f || byte >= 0xfe;
  });
  if (bad == text.end()) return std::nullopt;
  const auto line = 1 + std::count(text.begin(), bad, '\n');
  return Refusal{static_cast<int>(line), fmt::format("holds the byte {:#04x}: it is not a text file",
                                                     static_cast<unsigned char>(*bad))};
}

YamlNode Parse(std::string_view text) {
  std::istringstream stream{std::string(text)};
  YAML::Parser parser(stream);
  Builder builder;
  if (!parser.HandleNextDocument(builder)) return {};
  YamlNode root = builder.Take();
  Builder second;
  if (parser.HandleNextDocument(second)) {
    throw Refusal{second.Take().line, "a second document begins: keep one"};
  }
  return root;
}

}  // namespace

const YamlNode* YamlNode::Find(std::string_view key) const {
  const auto found = std::ranges::find(entries, key, &YamlEntry::key);
  return found == entries.end() ? nullptr : &found->value;
}

Result<YamlNode> ParseYamlDocument(std::string_view text, std::string_view origin) {
  if (text.size() > kMaxYamlBytes) {
    return Fail(ErrorCode::kInvalidArgument, "{}: {} bytes of YAML, at most {} are read", origin, text.size(),
                kMaxYamlBytes);
  }
  try {
    if (const auto refusal = FindControlCharacter(text)) throw *refusal;
    return Parse(text);
  } catch (const Refusal& refusal) {
    return Fail(ErrorCode::kInvalidArgument, "{}:{}: {}", origin, refusal.line, refusal.reason);
  } catch (const YAML::Exception& exception) {
    return Fail(ErrorCode::kInvalidArgument, "{}:{}: not YAML: {}", origin, LineOf(exception.mark),
                exception.msg);
  } catch (const std::exception& exception) {
    return Fail(ErrorCode::kInvalidArgument, "{}: not YAML: {}", origin, exception.what());
  }
}

Result<YamlNode> LoadYamlDocument(const std::filesystem::path& file) {
  DADRL_ASSIGN_OR_RETURN(const std::string text, ReadTextFile(file, kMaxYamlBytes, Links::kFollow));
  return ParseYamlDocument(text, file.string());
}

}  // namespace dadrl
