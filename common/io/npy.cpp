#include "common/io/npy.h"

#include <algorithm>
#include <cassert>
#include <charconv>
#include <limits>
#include <set>

#include "common/io/atomic_file.h"
#include "common/io/byte_io.h"
#include "common/io/read_file.h"
#include "common/util/shown.h"

namespace dadrl {
namespace {

constexpr std::string_view kMagic = "\x93NUMPY";
constexpr size_t kHeaderAlignment = 64;
// NumPy's own have a hundred bytes, and arrays of at most 32 dimensions.
constexpr uint64_t kMaxHeaderBytes = 64 << 10;
constexpr size_t kMaxDimensions = 32;

// The header's text is a Python dictionary with these three keys, in any order.
struct Header {
  std::string type;
  bool column_major = false;
  std::vector<size_t> shape;
};

// Reads just as much Python as NumPy writes. After the first thing it does not expect, ok() is false.
class HeaderParser {
 public:
  explicit HeaderParser(std::string_view text) : rest_(text) {}

  Header Parse() {
    Header header;
    std::set<std::string> keys;
    for (Expect('{'); ok_ && !Accept('}');) {
      const std::string key = Text();
      Expect(':');
      ok_ = ok_ && keys.insert(key).second;
      if (key == "descr") {
        header.type = Text();
      } else if (key == "fortran_order") {
        header.column_major = Boolean();
      } else if (key == "shape") {
        header.shape = Shape();
      } else {
        ok_ = false;
      }
      if (!Accept(',') && Peek() != '}') ok_ = false;
    }
    ok_ = ok_ && keys.size() == 3 && Peek() == '\0';
    return header;
  }
  bool ok() const { return ok_; }

 private:
  char Peek() {
    rest_.remove_prefix(std::min(rest_.find_first_not_of(" \n"), rest_.size()));
    return rest_.empty() ? '\0' : rest_.front();
  }
  bool Accept(char wanted) {
    if (!ok_ || Peek() != wanted) return false;
    rest_.remove_prefix(1);
    return true;
  }
  void Expect(char wanted) { ok_ = Accept(wanted); }

  std::string Text() {
    const char quote = Peek();
    const size_t end = quote == '\'' || quote == '"' ? rest_.find(quote, 1) : std::string_view::npos;
    if (end == std::string_view::npos) {
      ok_ = false;
      return {};
    }
    std::string text(rest_.substr(1, end - 1));
    rest_.remove_prefix(end + 1);
    return text;
  }
  bool Boolean() {
    Peek();
    for (const auto& [word, value] : {std::pair("True", true), std::pair("False", false)}) {
      if (!rest_.starts_with(word)) continue;
      rest_.remove_prefix(std::string_view(word).size());
      return value;
    }
    ok_ = false;
    return false;
  }
  std::vector<size_t> Shape() {
    std::vector<size_t> shape;
    Expect('(');
    while (ok_ && !Accept(')')) {
      Peek();
      size_t size = 0;
      const auto [end, error] = std::from_chars(rest_.data(), rest_.data() + rest_.size(), size);
      ok_ = error == std::errc() && shape.size() < kMaxDimensions;
      rest_.remove_prefix(static_cast<size_t>(end - rest_.data()));
      shape.push_back(size);
      if (!Accept(',') && Peek() != ')') ok_ = false;
    }
    return shape;
  }

  std::string_view rest_;
  bool ok_ = true;
};

tl::unexpected<Error> Damaged(const std::filesystem::path& path, std::string_view what) {
  return Fail(ErrorCode::kCorrupt, "{} is damaged ({}): write it again", path.string(), what);
}

// Bytes an array of this shape takes; nothing when they cannot be counted.
uint64_t BytesOf(std::span<const size_t> shape, uint64_t size_of_one) {
  uint64_t bytes = size_of_one;
  for (const size_t size : shape) {
    if (size != 0 && bytes > std::numeric_limits<uint64_t>::max() / size) {
      return std::numeric_limits<uint64_t>::max();
    }
    bytes *= size;
  }
  return bytes;
}

}  // namespace

std::string ShapeText(std::span<const size_t> shape) {
  return fmt::format("({}{})", fmt::join(shape, ", "), shape.size() == 1 ? "," : "");
}

std::string NpyHeader(std::string_view type, std::span<const size_t> shape) {
  std::string text =
      fmt::format("{{'descr': '{}', 'fortran_order': False, 'shape': {}, }}", type, ShapeText(shape));
  constexpr size_t kFixed = kMagic.size() + 4;  // version, length
  const size_t length = (kFixed + text.size() + kHeaderAlignment) / kHeaderAlignment * kHeaderAlignment;
  text.resize(length - kFixed - 1, ' ');
  text += '\n';
  assert(text.size() <= std::numeric_limits<uint16_t>::max());
  std::string header(kMagic);
  header += {'\1', '\0', static_cast<char>(text.size() & 0xFF), static_cast<char>(text.size() >> 8)};
  return header + text;
}

Status WriteNpyBytes(const std::filesystem::path& path, std::string_view type, std::span<const size_t> shape,
                     std::span<const std::byte> values) {
  const std::string header = NpyHeader(type, shape);
  auto file = AtomicFile::Create(path);
  if (!file) return tl::unexpected<Error>(std::move(file.error()));
  DADRL_RETURN_IF_ERROR(file->Append(std::as_bytes(std::span(header))));
  DADRL_RETURN_IF_ERROR(file->Append(values));
  return file->Commit();
}

Result<NpyBytes> ReadNpyBytes(const std::filesystem::path& path, std::string_view type, uint64_t max_bytes) {
  NpyBytes array;
  DADRL_ASSIGN_OR_RETURN(array.file, ReadFile(path, max_bytes, Links::kFollow));
  DADRL_ASSIGN_OR_RETURN(NpyView view, ParseNpy(array.file, type, path));
  array.shape = std::move(view.shape);
  array.values = view.values;
  return array;
}

Result<NpyView> ParseNpy(std::span<const std::byte> file, std::string_view type,
                         const std::filesystem::path& path) {
  NpyView array;
  ByteReader reader(file);
  const std::span<const std::byte> magic = reader.GetBytes(kMagic.size());
  const auto format = reader.Get<uint8_t>();
  reader.Get<uint8_t>();  // minor
  if (!reader.ok() || !std::ranges::equal(magic, std::as_bytes(std::span(kMagic)))) {
    return Fail(ErrorCode::kCorrupt, "{} is no .npy file: write it with numpy.save", path.string());
  }
  if (format < 1 || format > 3) return Damaged(path, fmt::format("format {}", format));
  const uint64_t length = format == 1 ? reader.Get<uint16_t>() : reader.Get<uint32_t>();
  if (length > kMaxHeaderBytes) return Damaged(path, fmt::format("a header of {} bytes", length));
  const std::span<const std::byte> text = reader.GetBytes(length);
  HeaderParser parser({reinterpret_cast<const char*>(text.data()), text.size()});
  Header header = parser.Parse();
  if (!reader.ok() || !parser.ok()) return Damaged(path, "header");
  if (header.type != type) {
    return Fail(ErrorCode::kInvalidArgument, "{} holds numbers of type '{}', '{}' is needed: a.astype('{}')",
                path.string(), Shown(header.type), type, type);
  }
  if (header.column_major) {
    return Fail(ErrorCode::kInvalidArgument,
                "{} is column-major (fortran_order): save numpy.ascontiguousarray(a)", path.string());
  }
  array.shape = std::move(header.shape);
  array.values = reader.GetBytes(reader.remaining());
  const auto size_of_one = static_cast<uint64_t>(type.back() - '0');
  const uint64_t expected = BytesOf(array.shape, size_of_one);
  if (array.values.size() != expected) {
    return Damaged(path, fmt::format("{} bytes behind the header, shape {} has {}", array.values.size(),
                                     ShapeText(array.shape), expected));
  }
  return array;
}

}  // namespace dadrl
