#include <algorithm>
#include <cmath>
#include <cstdio>
#include <cstring>
#include <map>
#include <memory>
#include <nlohmann/json.hpp>
#include <optional>
#include <system_error>

#include "common/io/mapped_file.h"
#include "common/io/npy.h"
#include "common/io/read_file.h"
#include "replay/storage/segment_log.h"
#include "replay/storage/state_file.h"
#include "replay/tools/array_layout.h"
#include "replay/tools/tool.h"

namespace dadrl {
namespace {

namespace fs = std::filesystem;

constexpr uint64_t kMaxIndexBytes = 1 << 20;

// The arrays of an exported folder, mapped: only the rows that are read are resident.
class Arrays {
 public:
  static Result<Arrays> Open(const fs::path& folder) {
    Arrays arrays;
    DADRL_RETURN_IF_ERROR(arrays.ReadIndex(folder / kArrayIndex));
    for (const ArrayLayout& layout : ArrayLayouts(arrays.spec_)) {
      const fs::path path = folder / (layout.name + ".npy");
      DADRL_ASSIGN_OR_RETURN(MappedFile file, MappedFile::Open(path));
      DADRL_ASSIGN_OR_RETURN(const NpyView view, ParseNpy(file.bytes(), layout.type, path));
      std::vector<size_t> shape = layout.row;
      shape.insert(shape.begin(), arrays.rows_);
      if (view.shape != shape) {
        return Fail(ErrorCode::kInvalidArgument, "{} has shape {}, {} says {}", path.string(),
                    ShapeText(view.shape), kArrayIndex, ShapeText(shape));
      }
      arrays.columns_.push_back({layout, view.values, std::move(file)});
    }
    return arrays;
  }
  std::span<const std::byte> Row(Column column, uint64_t row) const {
    const auto& [layout, values, file] = columns_[static_cast<size_t>(column)];
    return values.subspan(row * layout.row_bytes, layout.row_bytes);
  }
  template <typename T>
  T Value(Column column, uint64_t row) const {
    T value;
    std::memcpy(&value, Row(column, row).data(), sizeof(T));
    return value;
  }
  uint64_t rows() const { return rows_; }
  const ObservationSpec& spec() const { return spec_; }
  FloatCoding floats() const { return floats_; }

 private:
  struct Mapped {
    ArrayLayout layout;
    std::span<const std::byte> values;
    MappedFile file;
  };
  Status ReadIndex(const fs::path& path) {
    DADRL_ASSIGN_OR_RETURN(const std::string text, ReadTextFile(path, kMaxIndexBytes));
    try {
      const nlohmann::json index = nlohmann::json::parse(text);
      if (index.at("format") != "dadrl experience" || index.at("version") != kArrayFormat) {
        return Fail(ErrorCode::kCorrupt, "{} is no index of experience of version {}", path.string(),
                    kArrayFormat);
      }
      rows_ = index.at("rows").get<uint64_t>();
      spec_.vehicles = index.at("observation").at("vehicles").get<int>();
      spec_.history = index.at("observation").at("history").get<int>();
      floats_ = index.at("floats") == "float32" ? FloatCoding::kFloat32 : FloatCoding::kFloat16;
    } catch (const nlohmann::json::exception& exception) {
      return Fail(ErrorCode::kCorrupt, "{}: {}", path.string(), exception.what());
    }
    if (spec_.vehicles < 1 || spec_.vehicles > 64 || spec_.history < 1 || spec_.history > 50) {
      return Fail(ErrorCode::kCorrupt, "{}: {} vehicles and {} rows of history are out of range",
                  path.string(), spec_.vehicles, spec_.history);
    }
    return {};
  }

  uint64_t rows_ = 0;
  ObservationSpec spec_;
  FloatCoding floats_ = FloatCoding::kFloat16;
  std::vector<Mapped> columns_;
};

// The log of one shard, written chunk by chunk; what its restart must know goes into the state file.
class ShardWriter {
 public:
  static Result<std::unique_ptr<ShardWriter>> Create(const fs::path& directory, uint64_t schema) {
    auto writer = std::make_unique<ShardWriter>();
    SegmentLog::Recovery recovery;
    DADRL_ASSIGN_OR_RETURN(writer->log_, SegmentLog::Open(
                                             {.directory = directory, .schema = schema},
                                             [](const auto&, auto) { return true; }, recovery));
    writer->state_.schema = schema;
    return writer;
  }
  // False when the chunk's incarnation is one that a replay would not take any more.
  Result<bool> Append(std::span<const std::byte> bytes, const ChunkView& chunk, uint64_t transitions) {
    const ChunkIdentity& identity = chunk.header().identity;
    if (state_.sequences.Check(identity, identity.sequence) != SequenceTable::Verdict::kNext) return false;
    if (log_->NeedsSegment(bytes.size())) {
      log_->CloseSegment();
      DADRL_RETURN_IF_ERROR(log_->Sync());
      DADRL_RETURN_IF_ERROR(log_->StartSegment(bytes.size()));
    }
    DADRL_ASSIGN_OR_RETURN(const SegmentLog::Stored stored, log_->Append(bytes));
    state_.sequences.Accept(identity);
    state_.limiter.inserted += static_cast<int64_t>(transitions);
    state_.up_to = {stored.segment->id(), stored.segment->bytes()};
    return true;
  }
  Status Finish() {
    DADRL_RETURN_IF_ERROR(log_->Sync());
    return WriteReplayState(log_->directory() / "state", state_);
  }

 private:
  std::unique_ptr<SegmentLog> log_;
  ReplayState state_;
};

class Importer {
 public:
  Importer(const Arrays& arrays, std::vector<std::unique_ptr<ShardWriter>> shards)
      : arrays_(arrays),
        shards_(std::move(shards)),
        builder_(arrays.spec(), arrays.floats()),
        observation_(arrays.spec()) {}

  Status Run() {
    for (uint64_t row = 0; row < arrays_.rows(); ++row) DADRL_RETURN_IF_ERROR(AddRow(row));
    DADRL_RETURN_IF_ERROR(Flush(arrays_.rows()));
    for (const auto& shard : shards_) DADRL_RETURN_IF_ERROR(shard->Finish());
    return {};
  }

 private:
  // Of a row: what must agree for it to continue the chunk before it.
  struct Place {
    uint32_t actor = 0;
    uint64_t incarnation = 0;
    uint64_t episode = 0;
    uint32_t step = 0;
    bool operator==(const Place&) const = default;
  };

  Status AddRow(uint64_t row) {
    const Place place{
        arrays_.Value<uint32_t>(Column::kActor, row), arrays_.Value<uint64_t>(Column::kIncarnation, row),
        arrays_.Value<uint64_t>(Column::kEpisode, row), arrays_.Value<uint32_t>(Column::kStep, row)};
    if (place != next_ || ended_ || builder_.full()) {
      DADRL_RETURN_IF_ERROR(Flush(row));
      builder_.Begin(place.episode, place.step);
    }
    next_ = place;
    ++next_.step;
    return AddFrame(row);
  }

  Status AddFrame(uint64_t row) {
    DADRL_RETURN_IF_ERROR(LoadObservation(row));
    if (arrays_.Value<uint8_t>(Column::kHasAction, row) == 0) {
      builder_.AddFinal(observation_);
      ended_ = true;
      return {};
    }
    Action action{};
    std::memcpy(action.data(), arrays_.Row(Column::kActions, row).data(), sizeof(action));
    const bool terminated = arrays_.Value<uint8_t>(Column::kTerminated, row) != 0;
    const bool truncated = arrays_.Value<uint8_t>(Column::kTruncated, row) != 0;
    builder_.AddTransition(
        observation_, action, arrays_.Value<float>(Column::kRewards, row),
        static_cast<uint8_t>((terminated ? kTerminated : 0) | (truncated ? kTruncated : 0)),
        arrays_.Value<uint32_t>(Column::kPolicyVersion, row));
    ++transitions_;
    ended_ = terminated;
    return {};
  }

  Status LoadObservation(uint64_t row) {
    const auto load = [&](Column column, std::vector<float>& values) {
      std::memcpy(values.data(), arrays_.Row(column, row).data(), values.size() * sizeof(float));
      return std::all_of(values.begin(), values.end(), [](float value) { return std::isfinite(value); });
    };
    const bool finite =
        load(Column::kVehicles, observation_.vehicles) && load(Column::kEgo, observation_.ego);
    const std::span<const std::byte> pixels = arrays_.Row(Column::kContext, row);
    std::fill(observation_.context.begin(), observation_.context.end(), uint8_t{0});
    bool binary = true;
    for (size_t i = 0; i < pixels.size(); ++i) {
      const auto pixel = static_cast<uint8_t>(pixels[i]);
      binary = binary && pixel <= 1;
      observation_.context[i / 8] =
          static_cast<uint8_t>(observation_.context[i / 8] | (pixel & 1) << (i % 8));
    }
    if (finite && binary) return {};
    return Fail(ErrorCode::kInvalidArgument, "row {}: {}", row,
                finite ? "context.npy holds something else than 0 and 1"
                       : "vehicles.npy or ego.npy holds a number that is not finite");
  }

  // Stores the chunk under way, which ends before `row`.
  Status Flush(uint64_t row) {
    if (builder_.frames() == 0) return {};
    const std::pair stream{next_.actor, next_.incarnation};
    const std::vector<std::byte> bytes = builder_.Finish(
        {.actor = next_.actor, .incarnation = next_.incarnation, .sequence = ++sequences_[stream]});
    const Result<ChunkView> chunk = ChunkView::Parse(bytes);
    if (!chunk) {
      return Fail(ErrorCode::kInvalidArgument, "the frames before row {} are no part of an episode: {}", row,
                  chunk.error().message);
    }
    DADRL_ASSIGN_OR_RETURN(const bool taken,
                           shards_[next_.actor % shards_.size()]->Append(bytes, *chunk, transitions_));
    if (!taken) {
      return Fail(
          ErrorCode::kInvalidArgument,
          "before row {}: actor {} comes back to incarnation {} after {} later ones; sort the rows by "
          "incarnation",
          row, next_.actor, next_.incarnation, SequenceTable::kMaxIncarnations);
    }
    transitions_ = 0;
    ended_ = false;
    builder_.Begin(0, 0);
    return {};
  }

  const Arrays& arrays_;
  const std::vector<std::unique_ptr<ShardWriter>> shards_;
  ChunkBuilder builder_;
  Observation observation_;
  Place next_;
  bool ended_ = false;  // the last frame was an episode's last
  uint64_t transitions_ = 0;
  std::map<std::pair<uint32_t, uint64_t>, uint64_t> sequences_;
};

struct Options {
  std::string directory;
  std::string from;
  uint32_t shards = 1;
};

Result<int> Import(const Options& options) {
  std::error_code error;
  if (fs::exists(options.directory, error) && !fs::is_empty(options.directory, error)) {
    return Fail(ErrorCode::kInvalidArgument, "{} is there and not empty; name a new folder",
                options.directory);
  }
  DADRL_ASSIGN_OR_RETURN(const Arrays arrays, Arrays::Open(options.from));
  std::vector<std::unique_ptr<ShardWriter>> shards;
  for (uint32_t shard = 0; shard < options.shards; ++shard) {
    DADRL_ASSIGN_OR_RETURN(auto writer,
                           ShardWriter::Create(fs::path(options.directory) / fmt::format("shard-{}", shard),
                                               SchemaHash(arrays.spec())));
    shards.push_back(std::move(writer));
  }
  if (Status done = Importer(arrays, std::move(shards)).Run(); !done) {
    fs::remove_all(options.directory, error);  // all or nothing
    return tl::unexpected(std::move(done.error()));
  }
  fmt::print(stderr, "{} frames in {}\n", arrays.rows(), options.directory);
  return 0;
}

}  // namespace

Tool MakeImportTool(CLI::App& replay) {
  auto options = std::make_shared<Options>();
  CLI::App* app = replay.add_subcommand("import", "Make a replay folder of exported arrays");
  app->add_option("DIR", options->directory,
                  "New folder; its shard-K belong into the `replay` folder of a run")
      ->required();
  app->add_option("--from", options->from, "Folder of an export")->required()->type_name("ARRAYS");
  app->add_option("--shards", options->shards, "Spread over so many shards, by actor (default 1)")
      ->check(CLI::Range(1, 16));
  return {app, [options] { return Import(*options); }};
}

}  // namespace dadrl
