#pragma once

#include <optional>
#include <string>
#include <vector>

#include "sinew/cli/output/outcome.h"
#include "sinew/cli/output/verb.h"

namespace sinew::cli {

/// What the user wrote after `sinew plan`; numbers still as text.
struct PlanRequest {
  std::string subject;                       ///< a robot, or a program NAME.sinew
  std::optional<std::string> robot;          ///< of a program
  std::optional<std::string> profile, wire;  ///< of the device it is planned for; as in its file
  std::vector<std::string> without;          ///< joints that are left out
  /// One a move, in order: "x,y,z" or "x,y,z,rx,ry,rz" for a straight line of the tool,
  /// "joints=a,b,..." for a joint move.
  std::vector<std::string> to;
  std::optional<std::string> from;  ///< joints; home where left out
  std::optional<std::string> speed;
  std::optional<std::string> blend;
  std::optional<std::string> plot;
  std::optional<std::string> cell;  ///< a cell's file: dry_run.h
};

/// `sinew plan`: the motion along a way, checked and timed over its whole length, and what limits
/// it. Nothing moves.
Outcome plan(const PlanRequest& request);

void add_plan(CLI::App& app, ChosenVerb& call);

}  // namespace sinew::cli
