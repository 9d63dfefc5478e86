#pragma once

#include <array>
#include <optional>
#include <span>

#include "sinew/core/error.h"
#include "sinew/devices/grbl/grbl_settings.h"
#include "sinew/devices/grbl/grbl_wire.h"
#include "sinew/model/robot_model.h"

namespace sinew {

/// A board's own settings (`$$`), held against what motions are planned with. @rt
class GrblSettingsCheck {
 public:
  GrblSettingsCheck(const GrblDevice& device, std::span<const Joint> joints);

  /// Nothing has been listed.
  void begin() { *this = GrblSettingsCheck(device_, {joints_.data(), joints_.size()}); }
  void take(const grbl::Setting& setting);
  /// Whether all was listed that is needed. FluidNC has no number for `$1`.
  bool complete(grbl::Firmware firmware) const;
  /// The first setting that does not fit; kModelMismatch where not all was listed.
  std::optional<Error> misfit(grbl::Firmware firmware) const;
  /// Units of a reported position: 25.4 where the board reports inches ($13).
  double report_scale() const { return reports_inches_ ? 25.4 : 1; }

 private:
  struct Axis {
    std::optional<double> steps, rate, acceleration;  ///< per unit; rad/s, rad/s^2 (m)
  };

  GrblDevice device_;
  FixedVector<Joint, grbl::kAxesMax> joints_;
  std::array<Axis, grbl::kAxesMax> axes_;
  std::optional<double> idle_;
  bool reports_inches_ = false;
};

}  // namespace sinew
