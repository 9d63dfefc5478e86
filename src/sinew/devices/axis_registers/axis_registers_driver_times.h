#pragma once

#include <cstddef>
#include <span>

#include "sinew/devices/axis_registers/axis_registers_settings.h"
#include "sinew/model/robot_model.h"

namespace sinew {

/// AxisRegistersDriver's own order of frames, one after the other, each board at its own pace once
/// it was commanded.
class AxisRegisterTimes final : public SeparateMoves {
 public:
  /// @param joints  of the robot; one a board
  AxisRegisterTimes(const AxisRegistersDevice& device, std::span<const Joint> joints)
      : device_(device), joints_(joints) {}

  /// The document's registers have whole degrees.
  double target(std::size_t joint, double q) const override;
  Move next(std::span<const double> own) override;

 private:
  const AxisRegistersDevice& device_;
  std::span<const Joint> joints_;
  std::size_t cursor_ = 0;  ///< of the driver's round
};

}  // namespace sinew
