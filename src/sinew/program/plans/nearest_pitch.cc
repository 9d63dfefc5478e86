#include "sinew/program/plans/nearest_pitch.h"

#include <limits>

#include "sinew/core/error_code.h"

namespace sinew::program {

std::optional<double> nearest_pitch(const kinematics::SerialArm& arm, const Vec3& p_BT) {
  constexpr int kSteps = 720;
  std::optional<double> best;
  double least = std::numeric_limits<double>::infinity();
  for (int k = 0; k < kSteps; ++k) {
    const double pitch = 2 * kPi * k / kSteps;
    const auto answer = arm.inverse_at_pitch(p_BT, pitch);
    if (answer || answer.error().code != ErrorCode::kOutOfReach) continue;
    if (const double missing = excess(answer.error()); missing < least) {
      least = missing;
      best = pitch;
    }
  }
  return best;
}

}  // namespace sinew::program
