#include "sinew/cli/cells/demonstration_lines.h"

#include <fmt/format.h>

#include <cstdio>

#include "sinew/io/standard_streams.h"

namespace sinew::cli {
namespace {

using Part = server::Demonstration::Part;

/// What is slow on its own wire is shown quicker, and that is said.
std::string time_text(const Part& part) {
  if (part.time_scale == 1) return fmt::format("{:.0f} s", part.duration);
  return fmt::format("{:.0f} s of its own time, x{:g}", part.duration, part.time_scale);
}

}  // namespace

DemonstrationLines::DemonstrationLines(const server::Demonstration& shown)
    : shown_(shown), told_(shown.parts()), live_(io::stderr_is_terminal()) {}

DemonstrationLines::~DemonstrationLines() {
  if (dirty_) std::fputs("\r\033[K", stderr);
}

void DemonstrationLines::show(Instant now) {
  if (shown_.over()) {
    if (!told_end_) tell("the demonstration has ended: the robots are yours");
    told_end_ = true;
    dirty_ = false;
    return;
  }
  std::string line = "\r  shows";
  for (std::size_t i = 0; i < told_.size(); ++i) {
    const Part& part = shown_.parts()[i];
    const Part before = std::exchange(told_[i], part);
    if (part.rounds != before.rounds) {
      tell(fmt::format("{}: shown, {}", part.robot, time_text(part)));
    }
    if (!part.trouble.empty() && part.trouble != before.trouble) {
      tell(fmt::format("{}: {}", part.robot, part.trouble));
    }
    if (part.plays) line += fmt::format("  {} {:.0f} %", part.robot, 100 * part.progress);
  }
  if (!live_ || now < next_) return;
  next_ = now + std::chrono::milliseconds(200);
  dirty_ = true;
  std::fputs((line + "\033[K").c_str(), stderr);
}

void DemonstrationLines::tell(const std::string& line) {
  std::fputs(((dirty_ ? "\r\033[K  " : "  ") + line + "\n").c_str(), stderr);
}

}  // namespace sinew::cli
