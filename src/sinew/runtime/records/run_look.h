#pragma once

#include <memory>
#include <string>
#include <variant>

#include "sinew/program/runs/program_run.h"
#include "sinew/runtime/cameras/camera.h"

namespace sinew::runtime {

/// A picture that a program looked at, with what was seen in it.
struct RunPicture {
  Instant at{};
  std::string camera;
  std::shared_ptr<const Camera::Shot> shot;
};

/// What a program decided by it.
struct RunDecision {
  Instant at{};
  program::Decision decision;
};

/// What a record has of a program that looks.
using RunLook = std::variant<RunPicture, RunDecision>;

}  // namespace sinew::runtime
