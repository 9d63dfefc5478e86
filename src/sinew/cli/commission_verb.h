#pragma once

#include <cstdint>
#include <expected>
#include <optional>
#include <string>

#include "sinew/cli/outcome.h"
#include "sinew/model/robot_model.h"

namespace sinew::cli {

/// A procedure on a robot that nobody else steers: commissioning, homing, recovery.
struct CommissionRequest {
  std::string robot;
  std::optional<std::string> port;  ///< a simulated device where left out, or "simulated"
  std::optional<std::string> wire;
  std::optional<std::string> profile;
  std::string procedure = "commission";
  std::optional<std::string> answers;  ///< a file; else somebody types
  std::optional<std::string> save;     ///< where its results go; the state folder where left out
  std::optional<std::string> journal;
  bool anew = false;  ///< without what was answered before
  std::int64_t seed = 1;
  double time_scale = 1;
  bool json = false;
};

/// Puts what commissioning found on top of the robot's file.
/// @param settings  a file or "none"; where left out that of the state folder, if it is there
/// @param real      the robot is a real one; else only a file that was named counts
/// @return  the file that counts; empty where none does
/// @error   a file that was named, or is there, cannot be used
std::expected<std::string, Outcome> use_commissioning(RobotModel& robot,
                                                      const std::optional<std::string>& settings,
                                                      bool real);

Outcome commission(const CommissionRequest& request);

}  // namespace sinew::cli
