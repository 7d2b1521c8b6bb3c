// Moments of an episode shown one after another. A still picture is a film of one moment, so that everything
// is drawn by the same code: what does not change becomes an attribute, what changes an SVG (SMIL) animation.
#pragma once

#include <string>
#include <vector>

#include "actor/render/recording.h"
#include "actor/render/svg.h"

namespace dadrl {

// Borrows the recording. Immutable.
class Film {
 public:
  // `moments`: indices into the recording's, increasing, at least one.
  Film(const Recording& recording, std::vector<int> moments);

  const Recording& recording() const { return recording_; }
  size_t size() const { return moments_.size(); }
  bool still() const { return size() == 1; }
  int index(size_t i) const { return moments_[i]; }
  const Moment& operator[](size_t i) const { return recording_.moments[static_cast<size_t>(moments_[i])]; }
  // From the first moment shown to the last, seconds; the last one stays.
  double duration() const { return StartOf(size() - 1); }
  // When moment i is shown, seconds after the first.
  double StartOf(size_t i) const { return (moments_[i] - moments_.front()) * kStepSeconds; }
  // True when the episode's last moment is the last one shown.
  bool shows_end() const { return moments_.back() + 1 == std::ssize(recording_.moments); }

 private:
  const Recording& recording_;
  std::vector<int> moments_;
};

// One value a moment; empty text and "none" are values like others.
using Track = std::vector<std::string>;

enum class Motion {
  kSmooth,  // glides from value to value
  kSteps,   // jumps
};

// Gives `node` the attribute over the moments first, first + 1, ... of the film (track.size() of them);
// before and after these the nearest value holds.
void Animate(svg::Node node, const Film& film, const char* attribute, const Track& track, Motion motion,
             size_t first = 0);
// The same for "translate" or "rotate"; values as in transform's parentheses.
void AnimateTransform(svg::Node node, const Film& film, const char* type, const Track& track, Motion motion,
                      size_t first = 0);
// Shown where `visible`.
void AnimateVisibility(svg::Node node, const Film& film, const std::vector<bool>& visible);

// A text that takes few values: one element for each.
void AddWords(svg::Node parent, const Film& film, Point at, const Track& words, svg::Attributes attributes);

// A number that takes many values, set from digits on rolls; all values have the same length (pad with
// spaces). `at` is the right end of the baseline.
void AddDigits(svg::Node parent, const Film& film, Point at, double font_size, const Track& numbers,
               svg::Attributes attributes);
// What AddDigits refers to; once in a picture that is not still.
void AddDigitRoll(svg::Node defs);

}  // namespace dadrl
