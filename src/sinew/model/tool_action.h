#pragma once

#include <cstdint>
#include <optional>
#include <variant>

#include "sinew/core/instant.h"

namespace sinew {

/// What the tool is asked to do. A robot without that tool answers kToolNotFitted.
struct JawsTo {
  double width = 0;                 ///< m between the jaws
  std::optional<double> held = {};  ///< m: width of what they hold then, where anything
};
struct GripperTo {
  bool enabled = true;
  std::optional<double> angle;  ///< rad of its servo; nothing: where it was told to be last
};
struct Suction {
  enum class State : std::uint8_t { kOn, kRelease, kOff } state = State::kOff;
};
struct NozzleTo {
  double angle = 0;  ///< rad, 0 to pi on the servo's own scale; pi/2 is its centre
  Duration duration{};
};
using ToolAction = std::variant<JawsTo, GripperTo, Suction, NozzleTo>;

}  // namespace sinew
