#include "sinew/devices/grbl/grbl_driver_settings.h"

#include <cmath>

#include "sinew/core/error_code.h"
#include "sinew/core/units.h"

namespace sinew {
namespace {

/// What a board's decimals leave open.
constexpr double kNearEnough = 0.999;
constexpr double kStepsDiffer = 1e-3;  // of the file's
constexpr double kMotorsStayOn = 255;

}  // namespace

GrblSettingsCheck::GrblSettingsCheck(const GrblDevice& device, std::span<const Joint> joints)
    : device_(device), joints_(joints) {}

void GrblSettingsCheck::take(const grbl::Setting& setting) {
  if (setting.number == grbl::kIdleSetting) idle_ = setting.value;
  if (setting.number == grbl::kInchSetting) reports_inches_ = setting.value != 0;
  for (std::size_t i = 0; i < joints_.size(); ++i) {
    if (setting.number == grbl::kStepsSetting + i) axes_[i].steps = setting.value;
    if (setting.number == grbl::kRateSetting + i)
      axes_[i].rate = device_.from_units(i, setting.value) / 60;
    if (setting.number == grbl::kAccelerationSetting + i) {
      axes_[i].acceleration = device_.from_units(i, setting.value);
    }
  }
}

bool GrblSettingsCheck::complete(grbl::Firmware firmware) const {
  for (std::size_t i = 0; i < joints_.size(); ++i) {
    if (!axes_[i].steps || !axes_[i].rate || !axes_[i].acceleration) return false;
  }
  return idle_ || firmware == grbl::Firmware::kFluidNc;
}

std::optional<Error> GrblSettingsCheck::misfit(grbl::Firmware firmware) const {
  if (!complete(firmware)) return Error{ErrorCode::kModelMismatch};
  if (idle_ && *idle_ < kMotorsStayOn) return Error{ErrorCode::kBoardRests};
  for (std::size_t i = 0; i < joints_.size(); ++i) {
    const auto error = [&](ErrorCode code, double is, double needed) {
      return Error{code, static_cast<std::int8_t>(i), is, needed};
    };
    const Joint& joint = joints_[i];
    const double steps = device_.steps_per_unit(i);
    if (std::abs(*axes_[i].steps - steps) > kStepsDiffer * steps) {
      return error(ErrorCode::kBoardSteps, *axes_[i].steps, steps);
    }
    if (*axes_[i].rate < kNearEnough * joint.velocity_max) {
      return error(ErrorCode::kBoardVelocity, *axes_[i].rate, joint.velocity_max);
    }
    if (*axes_[i].acceleration < kNearEnough * joint.acceleration_max) {
      return error(ErrorCode::kBoardAcceleration, *axes_[i].acceleration, joint.acceleration_max);
    }
  }
  return std::nullopt;
}

}  // namespace sinew
