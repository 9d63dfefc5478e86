#pragma once

#include <span>
#include <string_view>

namespace sinew {

/// A robot's file as it stood in robots/ when the program was built.
struct BuiltinRobot {
  std::string_view id;         ///< the file's name without its ending
  std::string_view file_name;  ///< as complaints show it: "robots/learm.toml"
  std::string_view text;       ///< for `read_robot`
  /// A program that shows what it can do, robots/ID/demonstration.sinew; empty: there is none.
  std::string_view demonstration;
};

/// The robots that every build carries, sorted by id.
std::span<const BuiltinRobot> builtin_robots();

}  // namespace sinew
