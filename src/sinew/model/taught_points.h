#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <variant>
#include <vector>

#include "sinew/model/robot_model.h"

namespace sinew {

/// A place of the tool. What is absent stays as it is when the tool goes there.
struct ToolPlace {
  Vec3 p_BT;  ///< m
  std::optional<Rotation> R_BT;
  std::optional<double> pitch;  ///< rad, of arms with five joints; with `roll`, never with R_BT
  std::optional<double> roll;   ///< rad
};

/// A place that has a name, for the programs of one robot.
struct TaughtPoint {
  std::string name;   ///< letters, digits, - and _, a letter first
  std::string robot;  ///< its id
  std::variant<JointVector, ToolPlace> place;
  std::uint8_t lengths = 0;  ///< joints, a bit each, whose values are lengths, m
  std::string source;        ///< where it comes from; may be empty
  std::string taught_at;     ///< when; may be empty
  /// Why it cannot be used; empty where it can. Without a name: why the whole file cannot be read.
  std::string wrong{};
};
using TaughtPoints = std::vector<TaughtPoint>;

}  // namespace sinew
