// The whole episode as a curve of the ego's speed, with what happened.
#pragma once

#include <string>
#include <vector>

#include "actor/render/film.h"

namespace dadrl {

// A moment that the reader finds elsewhere in the picture.
struct TimelineMark {
  int moment = 0;  // index into the recording
  std::string label;
};

// A film of several moments gets a cursor that runs along. Spans below the curve: lane commands, off the
// route, against the traffic.
void DrawTimeline(svg::Node parent, const Film& film, const svg::Box& box,
                  const std::vector<TimelineMark>& marks = {});

}  // namespace dadrl
