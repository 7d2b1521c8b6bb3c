#include "actor/render/render_command.h"

#include <fmt/format.h>

#include <algorithm>
#include <cctype>
#include <cmath>
#include <memory>
#include <span>

#include "actor/render/picture.h"
#include "actor/render/rasterize.h"
#include "actor/render/recording.h"
#include "common/io/atomic_file.h"
#include "common/liveness/working_thread.h"

namespace dadrl {
namespace {

namespace fs = std::filesystem;

enum class Kind { kAnimation, kStrip, kFrames, kGallery };

constexpr int kFrameEvery = 5;
// What a disk may take for the pictures of an episode before the process is taken to hang.
constexpr Duration kSlowDisk = std::chrono::minutes(2);
constexpr const char* kFramePrefix = "frame-";

Result<Kind> KindOf(const RenderOptions& options) {
  const bool folder = options.out.ends_with('/');
  if (options.gallery) {
    if (folder) return Kind::kGallery;
    return Fail(ErrorCode::kInvalidArgument,
                "--out: '{}' does not end in /; a range of seeds is drawn into a folder", options.out);
  }
  if (folder) return Kind::kFrames;
  if (options.out.ends_with(".svg")) return Kind::kAnimation;
  if (options.out.ends_with(".png")) return Kind::kStrip;
  return Fail(
      ErrorCode::kInvalidArgument,
      "--out: '{}' does not say what to draw; end it in .svg (animation), .png (strip of moments) or / "
      "(a folder of frames)",
      options.out);
}

// Before anything is driven.
Status PrepareOutput(const RenderOptions& options, Kind kind) {
  fs::path folder = options.out;
  std::error_code error;
  if (kind == Kind::kFrames || kind == Kind::kGallery) {
    fs::create_directories(folder, error);
    if (error) {
      return Fail(ErrorCode::kInternal, "--out: the folder {} cannot be made: {}", options.out,
                  error.message());
    }
  } else {
    folder = folder.has_parent_path() ? folder.parent_path() : fs::path(".");
    if (!fs::is_directory(folder, error)) {
      return Fail(ErrorCode::kNotFound, "--out: there is no folder {}; make it first", folder.string());
    }
  }
  // Nothing stays of it: not committed.
  if (const auto probe = AtomicFile::Create(folder / "probe"); !probe) {
    return Fail(probe.error().code, "--out: {}", probe.error().message);
  }
  return {};
}

// The first and last moment to show.
struct Part {
  int first = 0;
  int last = 0;
};

Result<Part> PartToShow(const Recording& recording, const RenderOptions& options) {
  const int end = recording.summary.steps;
  const double length_s = end * kStepSeconds;
  if (options.from_s >= length_s) {
    return Fail(ErrorCode::kInvalidArgument, "--from {}: the episode of seed {} ends after {:.1f} s ({})",
                options.from_s, recording.summary.seed, length_s, OutcomeSentence(recording));
  }
  const double to_s = std::min(options.to_s.value_or(length_s), length_s);
  const Part part{static_cast<int>(std::lround(options.from_s / kStepSeconds)),
                  static_cast<int>(std::lround(to_s / kStepSeconds))};
  if (part.first >= part.last) {
    return Fail(ErrorCode::kInvalidArgument, "--from {} --to {}: nothing lies between them", options.from_s,
                to_s);
  }
  return part;
}

Status WriteStrip(const Recording& recording, const RenderOptions& options, const Part& part,
                  const fs::path& file) {
  const std::string svg =
      StripPicture(recording, KeyMoments(recording, part.first, part.last, options.moments));
  DADRL_ASSIGN_OR_RETURN(const std::vector<std::byte> png, RasterizePng(svg));
  return WriteFileAtomically(file, png);
}

// frame-0123.svg, of at least four digits: no other name is ours.
bool IsFrame(std::string_view name) {
  const std::string_view prefix = kFramePrefix;
  const std::string_view suffix = ".svg";
  if (!name.starts_with(prefix) || !name.ends_with(suffix)) return false;
  if (name.size() < prefix.size() + 4 + suffix.size()) return false;
  const std::string_view number = name.substr(prefix.size(), name.size() - prefix.size() - suffix.size());
  return std::ranges::all_of(number, [](unsigned char c) { return std::isdigit(c) != 0; });
}

// Those of an earlier, longer episode would be taken for this one's.
Status RemoveOldFrames(const fs::path& folder) {
  std::error_code error;
  for (const fs::directory_entry& entry : fs::directory_iterator(folder, error)) {
    if (IsFrame(entry.path().filename().string())) fs::remove(entry.path(), error);
    if (error) break;
  }
  if (!error) return {};
  return Fail(ErrorCode::kInternal, "--out: the frames in {} cannot be replaced: {}", folder.string(),
              error.message());
}

Result<std::vector<std::string>> WriteFrames(const Recording& recording, const RenderOptions& options,
                                             const Part& part) {
  const fs::path folder = options.out;
  DADRL_RETURN_IF_ERROR(RemoveOldFrames(folder));
  const int every = options.every > 0 ? options.every : kFrameEvery;
  std::vector<std::string> files;
  for (int moment = part.first;; moment = std::min(moment + every, part.last)) {
    files.push_back((folder / fmt::format("{}{:04}.svg", kFramePrefix, moment)).string());
    DADRL_RETURN_IF_ERROR(
        WriteFileAtomically(files.back(), std::string_view(FramePicture(recording, moment))));
    if (moment == part.last) return files;
  }
}

Result<std::vector<std::string>> WritePictures(const Recording& recording, const RenderOptions& options,
                                               Kind kind) {
  DADRL_ASSIGN_OR_RETURN(const Part part, PartToShow(recording, options));
  switch (kind) {
    case Kind::kFrames:
      return WriteFrames(recording, options, part);
    case Kind::kAnimation: {
      const int every = std::max(1, options.every);
      DADRL_RETURN_IF_ERROR(WriteFileAtomically(
          options.out, std::string_view(AnimatedPicture(recording, part.first, part.last, every))));
      return std::vector<std::string>{options.out};
    }
    case Kind::kStrip: {
      DADRL_RETURN_IF_ERROR(WriteStrip(recording, options, part, options.out));
      return std::vector<std::string>{options.out};
    }
    case Kind::kGallery: {
      const fs::path file = fs::path(options.out) / fmt::format("{}-{}.png", recording.summary.seed,
                                                                OutcomeName(recording.summary.outcome));
      DADRL_RETURN_IF_ERROR(WriteStrip(recording, options, part, file));
      return std::vector<std::string>{file.string()};
    }
  }
  return {};
}

}  // namespace

Status RunRender(const RenderOptions& options, const OnRendered& on_rendered) {
  DADRL_ASSIGN_OR_RETURN(const Kind kind, KindOf(options));
  DADRL_RETURN_IF_ERROR(PrepareOutput(options, kind));
  DADRL_ASSIGN_OR_RETURN(const PolicySetup setup, MakePolicy(options.policy, options.config, {}));
  DADRL_ASSIGN_OR_RETURN(const std::unique_ptr<DrivingEnvironment> environment,
                         DrivingEnvironment::Create(setup.config, setup.environment));
  const WorkingThread working("render");
  for (const uint64_t seed : options.seeds) {
    RenderedEpisode rendered{.seed = seed};
    if (const auto recording = RecordEpisode(*environment, *setup.policy, setup.description, seed)) {
      rendered.outcome = recording->summary.outcome;
      rendered.steps = recording->summary.steps;
      rendered.episode_return = recording->summary.episode_return;
      rendered.sentence = OutcomeSentence(*recording);
      if (!options.outcome || *options.outcome == rendered.outcome) {
        const LongWork writing(kSlowDisk);
        DADRL_ASSIGN_OR_RETURN(rendered.files, WritePictures(*recording, options, kind));
      }
    } else {
      rendered.error = recording.error().message;
    }
    if (!on_rendered(rendered)) break;
  }
  return {};
}

}  // namespace dadrl
