#include "actor/render/player_script.h"

#include <fmt/format.h>

#include "actor/render/palette.h"

namespace dadrl {
namespace {

// Browsers give each inner <svg> a clock of its own.
constexpr const char* kScript = R"(
const root = document.documentElement;
const clocks = [root, ...document.querySelectorAll('svg svg')];
document.getElementById('keys').setAttribute('visibility', 'visible');
const pause = () => clocks.forEach((clock) => clock.pauseAnimations());
const play = () => clocks.forEach((clock) => clock.unpauseAnimations());
// A little beyond the end, where the last moment stays.
const end = duration + 0.001;
const wind = (to) => clocks.forEach((clock) => clock.setCurrentTime(Math.min(Math.max(to, 0), end)));
const toggle = () => {
  if (root.getCurrentTime() >= duration) { wind(0); play(); }
  else if (root.animationsPaused()) play();
  else pause();
};
const step = (by) => {
  pause();
  wind(Math.round(Math.min(root.getCurrentTime(), duration) * 10 + by) / 10 + 0.001);
};
root.addEventListener('click', toggle);
document.addEventListener('keydown', (event) => {
  if (event.key === ' ') { event.preventDefault(); toggle(); }
  if (event.key === 'ArrowLeft') step(-1);
  if (event.key === 'ArrowRight') step(1);
  if (event.key === 'Home') wind(0);
});
)";

}  // namespace

void AddPlayer(svg::Node root, double duration_s) {
  svg::AddText(root, {1264, 34},
               "click or space: pause, go on \u00b7 \u2190 \u2192: one step \u00b7 Home: from the start",
               {{"id", "keys"},
                {"class", "small"},
                {"text-anchor", "end"},
                {"fill", colour::kFaint},
                {"visibility", "hidden"}});
  svg::Add(root, "script")
      .text()
      .set(fmt::format("const duration = {};{}", svg::Number(duration_s), kScript).c_str());
}

}  // namespace dadrl
