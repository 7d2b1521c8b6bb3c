#include <algorithm>
#include <cstdio>
#include <cstring>
#include <map>
#include <memory>
#include <system_error>

#include "common/config/config_yaml.h"
#include "common/io/io_error.h"
#include "common/util/clock.h"
#include "proto/experience_bounds.h"
#include "replay/storage/columns_file.h"
#include "replay/storage/segment_log.h"
#include "replay/storage/state_file.h"
#include "replay/tools/imported_arrays.h"
#include "replay/tools/tool.h"

namespace dadrl {
namespace {

namespace fs = std::filesystem;

std::string BoundsText(const std::vector<ColumnSpec>& columns) {
  std::string text;
  for (const ColumnSpec& column : columns) {
    text += fmt::format("{}{} within [-{}, {}]", text.empty() ? "" : ", ", column.name, column.bound,
                        column.bound);
  }
  return text;
}

// How far ahead of this machine's another's clock may be.
constexpr uint64_t kClockSkewNs = uint64_t{86400} * 1'000'000'000;

// The log of one shard, written chunk by chunk; what its restart must know goes into the state file.
class ShardWriter {
 public:
  static Result<std::unique_ptr<ShardWriter>> Create(const fs::path& directory, const StepSpec& spec) {
    auto writer = std::make_unique<ShardWriter>();
    const uint64_t schema = SchemaHash(spec);
    SegmentLog::Recovery recovery;
    DADRL_ASSIGN_OR_RETURN(writer->log_, SegmentLog::Open(
                                             {.directory = directory, .schema = schema},
                                             [](const auto&, auto) { return true; }, recovery));
    writer->state_.schema = schema;
    DADRL_RETURN_IF_ERROR(WriteColumns(directory, spec));
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
  Importer(const ImportedArrays& arrays, const ExperienceBounds& bounds,
           std::vector<std::unique_ptr<ShardWriter>> shards)
      : arrays_(arrays),
        bounds_(bounds),
        shards_(std::move(shards)),
        builder_(arrays.spec(), arrays.floats()),
        columns_(arrays.spec(), 1),
        decision_(arrays.spec().decision_floats()) {}

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
    const Place place{arrays_.Value<uint32_t>(StepArray::kActor, row),
                      arrays_.Value<uint64_t>(StepArray::kIncarnation, row),
                      arrays_.Value<uint64_t>(StepArray::kEpisode, row),
                      arrays_.Value<uint32_t>(StepArray::kStep, row)};
    if (place != next_ || ended_ || builder_.full()) {
      DADRL_RETURN_IF_ERROR(Flush(row));
      builder_.Begin(place.episode, place.step);
    }
    next_ = place;
    ++next_.step;
    return AddFrame(row);
  }

  Status AddFrame(uint64_t row) {
    for (size_t i = 0; i < arrays_.spec().observation.size(); ++i) {
      DADRL_RETURN_IF_ERROR(LoadColumn(i, row));
    }
    DADRL_RETURN_IF_ERROR(CheckFlags(row));
    if (arrays_.Value<uint8_t>(StepArray::kHasDecision, row) == 0) {
      builder_.AddFinal(columns_);
      ended_ = true;
      return {};
    }
    LoadDecision(row);
    const auto reward = arrays_.Value<float>(StepArray::kRewards, row);
    DADRL_RETURN_IF_ERROR(CheckDecision(row, reward));
    const bool terminated = arrays_.Value<uint8_t>(StepArray::kTerminated, row) != 0;
    const bool truncated = arrays_.Value<uint8_t>(StepArray::kTruncated, row) != 0;
    const bool success = arrays_.Value<uint8_t>(StepArray::kSuccess, row) != 0;
    builder_.AddTransition(columns_, decision_, reward,
                           static_cast<uint8_t>((terminated ? kTerminated : 0) |
                                                (truncated ? kTruncated : 0) | (success ? kSuccess : 0)),
                           arrays_.Value<uint32_t>(StepArray::kPolicyVersion, row));
    ++transitions_;
    ended_ = terminated;
    return {};
  }

  Status CheckFlags(uint64_t row) const {
    for (const StepArray array :
         {StepArray::kHasDecision, StepArray::kTerminated, StepArray::kTruncated, StepArray::kSuccess}) {
      if (arrays_.Value<uint8_t>(array, row) <= 1) continue;
      return Fail(ErrorCode::kInvalidArgument, "row {}: {}.npy holds something else than 0 and 1", row,
                  arrays_.Name(IndexOf(arrays_.spec(), array)));
    }
    const auto incarnation = arrays_.Value<uint64_t>(StepArray::kIncarnation, row);
    if (incarnation <= static_cast<uint64_t>(WallTimeNs()) + kClockSkewNs) return {};
    return Fail(
        ErrorCode::kInvalidArgument,
        "row {}: incarnation {} is a time to come: the run's own actors would be taken for older ones", row,
        incarnation);
  }

  void LoadDecision(uint64_t row) {
    const StepSpec& spec = arrays_.spec();
    float* to = decision_.data();
    for (size_t i = 0; i < spec.decision.size(); ++i) {
      std::memcpy(to, arrays_.Row(spec.observation.size() + i, row).data(), spec.decision[i].bytes());
      to += spec.decision[i].elements();
    }
  }

  Status CheckDecision(uint64_t row, float reward) const {
    if (!IsPossibleDecision(arrays_.spec(), decision_)) {
      return Fail(ErrorCode::kInvalidArgument, "row {}: the decision ({}) is beyond its columns' bounds: {}",
                  row, fmt::join(decision_, ", "), BoundsText(arrays_.spec().decision));
    }
    if (bounds_.AllowsReward(reward)) return {};
    return Fail(ErrorCode::kInvalidArgument,
                "row {}: a reward of {}, a decision of this task earns at most {:.4g} either way; give the "
                "configuration it was collected with: --config RUN/config.yaml",
                row, reward, bounds_.reward);
  }

  Status LoadColumn(size_t index, uint64_t row) {
    const ColumnSpec& column = arrays_.spec().observation[index];
    const std::span<const std::byte> from = arrays_.Row(index, row);
    if (column.type == ElementType::kBit) return LoadBits(index, row, from);
    const std::span<float> values = columns_.floats(index);
    std::memcpy(values.data(), from.data(), values.size_bytes());
    bool possible = true;
    for (const float value : values) possible &= std::abs(value) <= column.bound;
    if (possible) return {};
    return Fail(ErrorCode::kInvalidArgument, "row {}: {}.npy holds a number that is not within [-{}, {}]",
                row, arrays_.Name(index), column.bound, column.bound);
  }

  Status LoadBits(size_t index, uint64_t row, std::span<const std::byte> from) {
    const std::span<uint8_t> bits = columns_.bits(index);
    std::ranges::fill(bits, uint8_t{0});
    bool binary = true;
    for (size_t i = 0; i < from.size(); ++i) {
      const uint8_t bit = std::to_integer<uint8_t>(from[i]);
      binary = binary && bit <= 1;
      bits[i / 8] |= (bit & 1) << (i % 8);
    }
    if (binary) return {};
    return Fail(ErrorCode::kInvalidArgument, "row {}: {}.npy holds something else than 0 and 1", row,
                arrays_.Name(index));
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

  const ImportedArrays& arrays_;
  const ExperienceBounds bounds_;
  const std::vector<std::unique_ptr<ShardWriter>> shards_;
  ChunkBuilder builder_;
  Columns columns_;
  std::vector<float> decision_;
  Place next_;
  bool ended_ = false;  // the last frame was an episode's last
  uint64_t transitions_ = 0;
  std::map<std::pair<uint32_t, uint64_t>, uint64_t> sequences_;
};

struct Options {
  std::string directory;
  std::string from;
  std::string config;
  uint32_t shards = 1;
};

// The folder that is made. Whatever goes wrong afterwards, nothing that was there before is removed.
class NewFolder {
 public:
  static Result<NewFolder> Create(const fs::path& path) {
    std::error_code error;
    const fs::file_status there = fs::symlink_status(path, error);
    const bool exists = there.type() != fs::file_type::not_found;
    if (exists && (there.type() != fs::file_type::directory || !fs::is_empty(path, error))) {
      return Fail(ErrorCode::kInvalidArgument, "{} is there and no empty folder; name a new one",
                  path.string());
    }
    if (!exists) fs::create_directories(path, error);
    if (error) return tl::unexpected(IoError("create", path, error.value()));
    return NewFolder(path, !exists);
  }
  // What was made in it, and it, unless it was there.
  void Remove(uint32_t shards) const {
    std::error_code ignored;  // the first error is the one to report
    for (uint32_t shard = 0; shard < shards; ++shard) fs::remove_all(Shard(shard), ignored);
    if (ours_) fs::remove(path_, ignored);
  }
  fs::path Shard(uint32_t shard) const { return path_ / fmt::format("shard-{}", shard); }

 private:
  NewFolder(fs::path path, bool ours) : path_(std::move(path)), ours_(ours) {}
  fs::path path_;
  bool ours_;
};

Status Fill(const NewFolder& folder, const ImportedArrays& arrays, const ExperienceBounds& bounds,
            uint32_t shards) {
  std::vector<std::unique_ptr<ShardWriter>> writers;
  for (uint32_t shard = 0; shard < shards; ++shard) {
    DADRL_ASSIGN_OR_RETURN(auto writer, ShardWriter::Create(folder.Shard(shard), arrays.spec()));
    writers.push_back(std::move(writer));
  }
  return Importer(arrays, bounds, std::move(writers)).Run();
}

Result<int> Import(const Options& options) {
  Config config;
  if (!options.config.empty()) DADRL_RETURN_IF_ERROR(LoadYaml(options.config, config));
  DADRL_ASSIGN_OR_RETURN(const ImportedArrays arrays, ImportedArrays::Open(options.from));
  DADRL_ASSIGN_OR_RETURN(const NewFolder folder, NewFolder::Create(options.directory));
  if (Status done = Fill(folder, arrays, ExperienceBounds::From(config), options.shards); !done) {
    folder.Remove(options.shards);  // all or nothing
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
  app->add_option(
         "--config", options->config,
         "Configuration it was collected with, which says what a reward can be (default: dadrl's own)")
      ->type_name("FILE");
  app->add_option("--shards", options->shards, "Spread over so many shards, by actor (default 1)")
      ->check(CLI::Range(1, 16));
  return {app, [options] { return Import(*options); }};
}

}  // namespace dadrl
