#include "sinew/program/language/program_part.h"

#include <algorithm>
#include <cmath>

namespace sinew::program {
namespace {

/// Slower than this no motion is planned.
constexpr double kShareLeast = 1e-3;
constexpr double kSpeedLeast = 1e-6;  // m/s

/// The first step of a row of the program's own file; a call's are those of what it calls.
std::optional<std::size_t> place_of(const Program& program, int line) {
  for (std::size_t place = 0; place < program.steps.size(); ++place) {
    const Step& step = program.steps[place];
    if (step.file == 0 && step.line == line) return place;
  }
  const auto call = std::ranges::find(program.calls, line, &CallRow::line);
  return call != program.calls.end() ? std::optional(call->first) : std::nullopt;
}

/// The loop or if around a place, the outermost one.
const Step* around(const Program& program, std::size_t place) {
  for (std::size_t begin = 0; begin < place; ++begin) {
    const auto& what = program.steps[begin].what;
    const auto* loop = std::get_if<LoopStep>(&what);
    const auto* branch = std::get_if<IfStep>(&what);
    const std::size_t end = loop != nullptr ? loop->end : branch != nullptr ? branch->end : begin;
    if (end >= place && end != begin) return &program.steps[begin];
  }
  return nullptr;
}

MotionOptions* options_of(Step& step) {
  if (auto* pick = std::get_if<PickCubeStep>(&step.what)) return &pick->how;
  if (auto* place = std::get_if<PlaceCubeStep>(&step.what)) {
    return std::visit([](auto& there) { return &there.how; }, place->there);
  }
  if (auto* joint = std::get_if<JointStep>(&step.what)) return &joint->how;
  if (auto* tool = std::get_if<ToolMoveStep>(&step.what)) return &tool->how;
  auto* spline = std::get_if<SplineStep>(&step.what);
  return spline != nullptr ? &spline->how : nullptr;
}

}  // namespace

std::expected<Program, std::string> from_line(const Program& program, int line) {
  const std::string name = "line " + std::to_string(line);
  const auto place = place_of(program, line);
  if (!place) return std::unexpected(name + " has no row that does something");
  if (const Step* block = around(program, *place)) {
    const bool loop = std::holds_alternative<LoopStep>(block->what);
    return std::unexpected(name + " is inside the " + (loop ? "loop" : "if") + " of line " +
                           std::to_string(block->line) + ": begin there, or behind its end");
  }
  Program part;
  part.files = program.files;
  part.table = program.table;
  part.steps.assign(program.steps.begin() + static_cast<std::ptrdiff_t>(*place),
                    program.steps.end());
  for (Step& step : part.steps) {
    if (auto* loop = std::get_if<LoopStep>(&step.what)) loop->end -= *place;
    if (auto* end = std::get_if<EndStep>(&step.what)) end->loop -= *place;
    if (auto* other = std::get_if<ElseStep>(&step.what)) other->begin -= *place;
    if (auto* branch = std::get_if<IfStep>(&step.what)) {
      branch->otherwise -= *place;
      branch->end -= *place;
    }
  }
  for (const CallRow& call : program.calls) {
    if (call.first >= *place) part.calls.push_back({call.line, call.first - *place});
  }
  return part;
}

Program slowed(const Program& program, double share) {
  Program out = program;
  for (Step& step : out.steps) {
    MotionOptions* how = options_of(step);
    if (how == nullptr) continue;
    if (how->time > 0) {
      how->time /= share;
      continue;
    }
    how->joint_share = std::max(kShareLeast, how->joint_share * share);
    if (std::isfinite(how->tool_speed)) {
      how->tool_speed = std::max(kSpeedLeast, how->tool_speed * share);
    }
  }
  return out;
}

}  // namespace sinew::program
