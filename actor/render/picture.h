// Whole pictures of a recorded episode, as SVG text. The same recording gives the same text.
#pragma once

#include <string>
#include <vector>

#include "actor/render/recording.h"

namespace dadrl {

// One moment of the recording.
std::string FramePicture(const Recording& recording, int moment);

// The moments from `first` to `last` as an animation that plays in a browser in the episode's own time; every
// `every`-th is drawn and the movements between them are smooth. Plays once and stays on the last moment;
// opened by itself it can be paused and wound (it says how).
std::string AnimatedPicture(const Recording& recording, int first, int last, int every);

// Up to `count` >= 2 moments beside each other, with the curve of the whole episode below.
std::string StripPicture(const Recording& recording, const std::vector<int>& moments);

// `count` >= 2 moments between `first` and `last`, both included, that tell the story: evenly spaced, or the
// closer the nearer to a collision or another sudden end. Fewer when there are not as many.
std::vector<int> KeyMoments(const Recording& recording, int first, int last, int count);

}  // namespace dadrl
