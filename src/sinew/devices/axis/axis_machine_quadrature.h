#pragma once

#include <cmath>
#include <cstdint>

#include "sinew/core/units.h"

namespace sinew::sim {

/// An incremental encoder and the timer that counts its edges: 600 pulses a turn, four edges each.
/// It knows no angle, only how far it has come since its counter was switched on. @rt
class Quadrature {
 public:
  static constexpr double kTurn = 600 * 4;  ///< counts; robot-arm-2's encoders on axes 1 to 3

  /// Switched on with the shaft at `angle`, rad.
  explicit Quadrature(double angle) : start_(edges(angle)) {}

  /// Edges passed since; a shaft that trembles on an edge counts it up and down and loses nothing.
  std::int32_t counts(double angle) const {
    return static_cast<std::int32_t>(edges(angle) - start_);
  }

 private:
  static double edges(double angle) { return std::floor(angle / (2 * kPi) * kTurn); }

  double start_;
};

}  // namespace sinew::sim
