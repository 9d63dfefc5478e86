#pragma once

#include <optional>
#include <string_view>
#include <vector>

#include "sinew/core/error.h"
#include "sinew/grasping/cube.h"

namespace sinew::program {

/// An object on the table that is no cube: an obstacle, never picked.
struct OtherThing {
  grasping::Body body;
  bool is_likely = true;  ///< as high as a cube; else it may be flat, and never causes a refusal
};

/// What one picture shows of the table in front of a robot.
struct Sighting {
  std::vector<grasping::Cube> cubes;  ///< in base B; `color` is a vision::ColorName
  std::vector<OtherThing> others{};
  std::vector<grasping::Cube> in_baskets{};  ///< done with
};

/// Calibrated cameras, for the rows that look. Looking takes its time, so it is asked for and
/// fetched without waiting.
class Eyes {
 public:
  virtual ~Eyes() = default;
  /// Asks for a picture that is taken from now on. One that was asked for before is forgotten.
  /// @param camera  its name; empty: the first
  virtual void look(std::string_view camera) = 0;
  /// What it shows, once; nothing while it is still looked at.
  /// @error kCameraLost, kCameraBlind, kCameraFrozen, kCameraChanged
  virtual std::optional<Expected<Sighting>> seen() = 0;
  /// Whether it looks for what comes into view beside the robots, from now on.
  /// @param anew  things are as they are seen next; else as they were when it was watched before
  virtual void watch(bool on, bool anew) = 0;
  /// Why the arm has to pause, since it was switched on: kViewDisturbed, or the fault of a camera
  /// that sees no more.
  virtual std::optional<Error> disturbed() const = 0;
};

}  // namespace sinew::program
