#include "learner/tensorboard_writer.h"

#include <fcntl.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>
#include <string>

#include "common/io/byte_io.h"
#include "common/io/crc32c.h"
#include "common/util/clock.h"

namespace dadrl {
namespace {

// Field numbers of event.proto and summary.proto.
constexpr uint32_t kEventWallTime = 1;
constexpr uint32_t kEventStep = 2;
constexpr uint32_t kEventFileVersion = 3;
constexpr uint32_t kEventSummary = 5;
constexpr uint32_t kEventSessionLog = 7;
constexpr uint32_t kSessionLogStatus = 1;
constexpr uint64_t kSessionStart = 1;
constexpr uint32_t kSummaryValue = 1;
constexpr uint32_t kValueTag = 1;
constexpr uint32_t kValueSimple = 2;

// Protobuf's wire encoding, as far as events need it.
class Message {
 public:
  void Varint(uint32_t field, uint64_t value) {
    PutVarint(field << 3 | 0u);
    PutVarint(value);
  }
  void Double(uint32_t field, double value) {
    PutVarint(field << 3 | 1u);
    ByteWriter(bytes_).Put(value);
  }
  void Bytes(uint32_t field, std::span<const std::byte> value) {
    PutVarint(field << 3 | 2u);
    PutVarint(value.size());
    ByteWriter(bytes_).PutBytes(value);
  }
  void Text(uint32_t field, std::string_view value) { Bytes(field, std::as_bytes(std::span(value))); }
  void Float(uint32_t field, float value) {
    PutVarint(field << 3 | 5u);
    ByteWriter(bytes_).Put(value);
  }
  std::span<const std::byte> bytes() const { return bytes_; }

 private:
  void PutVarint(uint64_t value) {
    for (; value >= 0x80; value >>= 7) bytes_.push_back(static_cast<std::byte>(value | 0x80));
    bytes_.push_back(static_cast<std::byte>(value));
  }
  std::vector<std::byte> bytes_;
};

constexpr std::string_view kPrefix = "events.out.tfevents.";

// For the name of a new file, seconds: later than every file there, also after the clock was set back or when
// two learners start within a second. TensorBoard ignores a file whose name sorts before one it has read.
int64_t NameTime(const std::filesystem::path& directory, int64_t now_s) {
  std::error_code ignored;
  for (const auto& entry : std::filesystem::directory_iterator(directory, ignored)) {
    const std::string name = entry.path().filename().string();
    if (!name.starts_with(kPrefix)) continue;
    int64_t time_s = 0;
    std::from_chars(name.data() + kPrefix.size(), name.data() + name.size(), time_s);
    now_s = std::max(now_s, time_s + 1);
  }
  return now_s;
}

}  // namespace

Result<TensorBoardWriter> TensorBoardWriter::Create(const std::filesystem::path& directory,
                                                    int64_t first_step) {
  std::error_code failed;
  std::filesystem::create_directories(directory, failed);
  if (failed) {
    return Fail(ErrorCode::kInternal, "cannot create {}: {}; choose another run directory",
                directory.string(), failed.message());
  }
  std::array<char, 256> host{};
  if (::gethostname(host.data(), host.size() - 1) != 0 || host[0] == '\0') host = {'h', 'o', 's', 't'};
  const double now_s = 1e-9 * WallTimeNs();
  const std::filesystem::path path =
      directory / fmt::format("{}{}.{}.{}", kPrefix, NameTime(directory, static_cast<int64_t>(now_s)),
                              host.data(), ::getpid());
  auto file = FileDescriptor::Open(path, O_WRONLY | O_CREAT | O_APPEND);
  if (!file) return tl::unexpected<Error>(std::move(file.error()));
  TensorBoardWriter writer(path, std::move(*file));
  if (Status begun = writer.Begin(now_s, first_step); !begun) {
    std::filesystem::remove(path, failed);  // TensorBoard shall not meet half a beginning
    return tl::unexpected<Error>(std::move(begun.error()));
  }
  return writer;
}

Status TensorBoardWriter::Begin(double wall_time_s, int64_t first_step) {
  Message version;
  version.Double(kEventWallTime, wall_time_s);
  version.Text(kEventFileVersion, "brain.Event:2");
  DADRL_RETURN_IF_ERROR(WriteRecord(version.bytes()));
  Message session;
  session.Varint(kSessionLogStatus, kSessionStart);
  Message start;
  start.Double(kEventWallTime, wall_time_s);
  start.Varint(kEventStep, static_cast<uint64_t>(first_step));
  start.Bytes(kEventSessionLog, session.bytes());
  return WriteRecord(start.bytes());
}

Status TensorBoardWriter::Add(int64_t step, double wall_time_s, std::span<const TaggedScalar> scalars) {
  Message summary;
  for (const TaggedScalar& scalar : scalars) {
    if (!std::isfinite(scalar.value)) continue;
    Message value;
    value.Text(kValueTag, scalar.tag);
    value.Float(kValueSimple, static_cast<float>(scalar.value));
    summary.Bytes(kSummaryValue, value.bytes());
  }
  Message event;
  event.Double(kEventWallTime, wall_time_s);
  event.Varint(kEventStep, static_cast<uint64_t>(step));
  event.Bytes(kEventSummary, summary.bytes());
  return WriteRecord(event.bytes());
}

Status TensorBoardWriter::WriteRecord(std::span<const std::byte> event) {
  std::vector<std::byte> record;
  ByteWriter writer(record);
  writer.Put<uint64_t>(event.size());
  writer.Put(MaskedCrc32c(std::span(record).first(sizeof(uint64_t))));
  writer.PutBytes(event);
  writer.Put(MaskedCrc32c(event));
  return AppendWhole(file_, record, path_);
}

}  // namespace dadrl
