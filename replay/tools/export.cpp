#include <fcntl.h>

#include <algorithm>
#include <cstdio>
#include <limits>
#include <memory>
#include <nlohmann/json.hpp>
#include <system_error>

#include "common/io/atomic_file.h"
#include "common/io/file_descriptor.h"
#include "common/io/npy.h"
#include "common/step/step_spec_json.h"
#include "replay/tools/array_layout.h"
#include "replay/tools/shard_reader.h"
#include "replay/tools/tool.h"

namespace dadrl {
namespace {

namespace fs = std::filesystem;

constexpr size_t kBufferBytes = size_t{1} << 20;

// One array under way: header first, then rows through a buffer.
class ArrayWriter {
 public:
  static Result<ArrayWriter> Create(const fs::path& directory, const ArrayLayout& layout, uint64_t rows) {
    ArrayWriter writer;
    writer.path_ = directory / (layout.name + ".npy");
    DADRL_ASSIGN_OR_RETURN(writer.file_, FileDescriptor::Open(writer.path_, O_WRONLY | O_CREAT | O_EXCL));
    std::vector<size_t> shape = layout.row;
    shape.insert(shape.begin(), rows);
    const std::string header = NpyHeader(layout.type, shape);
    DADRL_RETURN_IF_ERROR(writer.Append(std::as_bytes(std::span(header))));
    return writer;
  }
  Status Append(std::span<const std::byte> bytes) {
    buffer_.insert(buffer_.end(), bytes.begin(), bytes.end());
    return buffer_.size() < kBufferBytes ? Status() : Flush();
  }
  Status Finish() {
    DADRL_RETURN_IF_ERROR(Flush());
    return SyncFile(file_, path_);
  }

 private:
  Status Flush() {
    const Status written = WriteAll(file_, buffer_, path_);
    buffer_.clear();
    return written;
  }
  fs::path path_;
  FileDescriptor file_;
  std::vector<std::byte> buffer_;
};

// Decodes chunks into rows of all arrays.
class Exporter {
 public:
  static Result<Exporter> Create(const fs::path& directory, const StepSpec& spec, uint64_t rows) {
    Exporter exporter(spec);
    for (const ArrayLayout& layout : ArrayLayouts(spec)) {
      DADRL_ASSIGN_OR_RETURN(ArrayWriter writer, ArrayWriter::Create(directory, layout, rows));
      exporter.arrays_.push_back(std::move(writer));
    }
    exporter.rows_left_ = rows;
    return exporter;
  }
  Status Add(const ChunkView& chunk) {
    for (int frame = 0; frame < chunk.frames() && rows_left_ > 0; ++frame, --rows_left_) {
      DADRL_RETURN_IF_ERROR(AddFrame(chunk, frame));
    }
    return {};
  }
  Status Finish() {
    for (ArrayWriter& array : arrays_) DADRL_RETURN_IF_ERROR(array.Finish());
    return {};
  }
  uint64_t rows_left() const { return rows_left_; }
  bool any_float32() const { return any_float32_; }

 private:
  explicit Exporter(const StepSpec& spec) : spec_(spec), codec_(spec, FloatCoding::kFloat16), row_(spec, 1) {}

  template <typename T>
  Status Put(StepArray array, T value) {
    return arrays_[IndexOf(spec_, array)].Append(std::as_bytes(std::span(&value, 1)));
  }

  Status AddFrame(const ChunkView& chunk, int frame) {
    const std::span<const std::byte> payload = chunk.payload(frame);
    DADRL_RETURN_IF_ERROR(codec_.Decode(payload, row_));
    any_float32_ = any_float32_ || CodingOf(payload) == FloatCoding::kFloat32;
    for (size_t i = 0; i < spec_.observation.size(); ++i) DADRL_RETURN_IF_ERROR(AddColumn(i));
    DADRL_RETURN_IF_ERROR(AddDecision(chunk.decision(frame)));
    const ChunkHeader& header = chunk.header();
    const uint8_t flags = chunk.flags(frame);
    const auto has = [&](uint8_t flag) { return static_cast<uint8_t>((flags & flag) != 0); };
    DADRL_RETURN_IF_ERROR(Put(StepArray::kRewards, chunk.reward(frame)));
    DADRL_RETURN_IF_ERROR(Put(StepArray::kTerminated, has(kTerminated)));
    DADRL_RETURN_IF_ERROR(Put(StepArray::kTruncated, has(kTruncated)));
    DADRL_RETURN_IF_ERROR(Put(StepArray::kHasDecision, has(kHasDecision)));
    DADRL_RETURN_IF_ERROR(Put(StepArray::kPolicyVersion, chunk.policy_version(frame)));
    DADRL_RETURN_IF_ERROR(Put(StepArray::kActor, header.identity.actor));
    DADRL_RETURN_IF_ERROR(Put(StepArray::kIncarnation, header.identity.incarnation));
    DADRL_RETURN_IF_ERROR(Put(StepArray::kEpisode, header.episode));
    DADRL_RETURN_IF_ERROR(Put(StepArray::kStep, header.first_frame + static_cast<uint32_t>(frame)));
    return Put(StepArray::kSuccess, has(kSuccess));
  }

  Status AddColumn(size_t index) {
    const std::span<const uint8_t> bits = row_.bits(index);
    if (bits.empty()) return arrays_[index].Append(std::as_bytes(row_.floats(index)));
    unpacked_.resize(spec_.observation[index].elements());
    for (size_t i = 0; i < unpacked_.size(); ++i) {
      unpacked_[i] = bits[i / 8] >> (i % 8) & 1;
    }
    return arrays_[index].Append(std::as_bytes(std::span(unpacked_)));
  }

  Status AddDecision(std::span<const std::byte> decision) {
    if (decision.size() != spec_.decision_floats() * sizeof(float)) {
      return Fail(ErrorCode::kCorrupt, "a decision of {} bytes; its columns are {}", decision.size(),
                  ColumnsText(spec_.decision));
    }
    for (size_t i = 0; i < spec_.decision.size(); ++i) {
      const size_t bytes = spec_.decision[i].bytes();
      DADRL_RETURN_IF_ERROR(arrays_[spec_.observation.size() + i].Append(decision.first(bytes)));
      decision = decision.subspan(bytes);
    }
    return {};
  }

  StepSpec spec_;
  PayloadCodec codec_;
  Columns row_;
  std::vector<uint8_t> unpacked_;  // a column of bits, a byte each
  std::vector<ArrayWriter> arrays_;
  uint64_t rows_left_ = 0;
  bool any_float32_ = false;
};

struct Options {
  std::string directory;
  std::string out;
  uint64_t limit = std::numeric_limits<uint64_t>::max();
};

uint64_t RowBytes(const StepSpec& spec) {
  uint64_t bytes = 0;
  for (const ArrayLayout& layout : ArrayLayouts(spec)) bytes += layout.row_bytes;
  return bytes;
}

Status PrepareFolder(const fs::path& out, uint64_t rows, const StepSpec& spec) {
  std::error_code error;
  if (fs::exists(out, error) && !fs::is_empty(out, error)) {
    return Fail(ErrorCode::kInvalidArgument, "--out: {} is there and not empty; name a new folder",
                out.string());
  }
  fs::create_directories(out, error);
  if (error) return Fail(ErrorCode::kInternal, "create {}: {}", out.string(), error.message());
  const uint64_t bytes = rows * RowBytes(spec);
  const fs::space_info space = fs::space(out, error);
  if (!error && bytes > space.available) {
    return Fail(ErrorCode::kExhausted,
                "{} frames take {:.1f} MB as arrays, {} has {:.1f} MB left; use --limit", rows, bytes / 1e6,
                out.string(), space.available / 1e6);
  }
  return {};
}

Status WriteIndex(const fs::path& out, const StepSpec& spec, uint64_t rows, bool float32) {
  nlohmann::ordered_json arrays = nlohmann::ordered_json::object();
  for (const ArrayLayout& layout : ArrayLayouts(spec)) {
    std::vector<size_t> shape = layout.row;
    shape.insert(shape.begin(), rows);
    arrays[layout.name] = {{"file", layout.name + ".npy"}, {"type", layout.type}, {"shape", shape}};
  }
  const nlohmann::ordered_json index = {{"format", "dadrl experience"},
                                        {"version", kArrayFormat},
                                        {"rows", rows},
                                        {"columns", StepSpecToJson(spec)},
                                        {"floats", float32 ? "float32" : "float16"},
                                        {"arrays", arrays}};
  return WriteFileAtomically(out / kArrayIndex, std::string_view(index.dump(2) + "\n"));
}

Result<int> Export(const Options& options) {
  DADRL_ASSIGN_OR_RETURN(const ShardReader reader, ShardReader::Open(options.directory));
  uint64_t rows = 0;
  uint64_t damaged = 0;
  reader.ForEachChunk(
      [&](const auto&, uint64_t, const ChunkView& chunk) {
        rows = std::min(options.limit, rows + static_cast<uint64_t>(chunk.frames()));
        return rows < options.limit;
      },
      [&](const Damage& damage) { damaged += damage.bytes; });
  DADRL_RETURN_IF_ERROR(PrepareFolder(options.out, rows, reader.spec()));
  DADRL_ASSIGN_OR_RETURN(Exporter exporter, Exporter::Create(options.out, reader.spec(), rows));
  Status done;
  reader.ForEachChunk(
      [&](const fs::path& file, uint64_t offset, const ChunkView& chunk) {
        done = exporter.Add(chunk);
        if (!done && done.error().code == ErrorCode::kCorrupt) {
          done = Fail(ErrorCode::kCorrupt, "{}: offset {}: {}", file.string(), offset, done.error().message);
        }
        return done && exporter.rows_left() > 0;
      },
      [](const Damage&) {});
  DADRL_RETURN_IF_ERROR(std::move(done));
  DADRL_RETURN_IF_ERROR(exporter.Finish());
  // Last: a folder without it is not complete.
  DADRL_RETURN_IF_ERROR(WriteIndex(options.out, reader.spec(), rows, exporter.any_float32()));
  fmt::print(stderr, "{} frames in {}{}\n", rows, options.out,
             damaged > 0 ? fmt::format("; {} damaged bytes were left out", damaged) : "");
  return 0;
}

}  // namespace

Tool MakeExportTool(CLI::App& replay) {
  auto options = std::make_shared<Options>();
  CLI::App* app = replay.add_subcommand("export", "Write stored experience as NumPy arrays");
  app->add_option("DIR", options->directory, "Run directory, its replay folder, one shard, or a snapshot")
      ->required();
  app->add_option("--out", options->out, "New folder for the arrays")->required()->type_name("ARRAYS");
  app->add_option("--limit", options->limit, "At most so many frames, the oldest first")
      ->check(CLI::Range(uint64_t{1}, std::numeric_limits<uint64_t>::max()))
      ->type_name("N");
  return {app, [options] { return Export(*options); }};
}

}  // namespace dadrl
