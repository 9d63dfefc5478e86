#pragma once

#include <optional>
#include <string>

#include "sinew/cli/output/outcome.h"
#include "sinew/cli/output/verb.h"

namespace sinew::cli {

struct TeachRequest {
  std::optional<std::string> socket;
  std::string robot;  ///< its name in the cell
  std::string point;  ///< what the place shall be called; empty where a way is recorded
  std::optional<std::string> way;  ///< the program that the way until Ctrl-C becomes
  bool quiet = false;              ///< no progress on stderr
  std::string file = "points.toml";
  bool replace = false;  ///< a point of that name that is there, or the program
};

/// `sinew teach`: where a robot of a running cell stands, as a point for programs; or the way on
/// which somebody leads it (a jog, a hand), as a program.
Outcome teach(const TeachRequest& request);

struct PointsRequest {
  std::string file = "points.toml";
};

/// `sinew points`: the points of a file.
Outcome show_points(const PointsRequest& request);

void add_teach(CLI::App& app, ChosenVerb& call);
void add_points(CLI::App& app, ChosenVerb& call);

}  // namespace sinew::cli
