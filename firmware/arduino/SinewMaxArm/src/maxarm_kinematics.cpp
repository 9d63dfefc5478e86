#include "maxarm_kinematics.h"

#include <math.h>

namespace sinew_maxarm {
namespace {

// mm; the lengths that the maker's firmware was compiled with.
constexpr float kBaseHeight = 84.4F;
constexpr float kShoulderOffset = 8.14F;
constexpr float kUpperArm = 128.4F;
constexpr float kForearm = 138.0F;
constexpr float kToolOffset = 16.8F;
constexpr float kRadiusMin = 50.0F;  // the firmware ignores nearer points

constexpr float kFrontDeg = 120.0F;
constexpr float kDegPerRad = 57.2957795F;
constexpr float kShoulderAtPulse0 = 210.0F;
constexpr float kForearmAtPulse0 = -120.0F;
constexpr float kJointMaxDeg[3] = {240.0F, 210.0F, 120.0F};

// Rounding errors of float below: a point on a limit is accepted.
constexpr float kToleranceDeg = 0.01F;
constexpr float kToleranceMm = 0.001F;

float square(float x) {
  return x * x;
}

/// kJointLimit for the joint that is farthest outside, and others clamped to their limits.
MaxArmResult check_limits(float* joints_deg) {
  MaxArmResult result;
  float worst = kToleranceDeg;
  for (uint8_t i = 0; i < 3; ++i) {
    const float angle = joints_deg[i];
    const bool low = angle < 0;
    const float limit = low ? 0 : kJointMaxDeg[i];
    const float excess = low ? -angle : angle - limit;
    if (excess > 0 && excess <= kToleranceDeg) joints_deg[i] = limit;
    if (excess <= worst) continue;
    worst = excess;
    result = MaxArmResult(MaxArmError::kJointLimit, angle, limit, static_cast<uint8_t>(i + 1));
  }
  return result;
}

}  // namespace

MaxArmResult inverse(const float* xyz_mm, float* joints_deg) {
  const float x = xyz_mm[0];
  const float y = xyz_mm[1];
  if (!isfinite(x) || !isfinite(y) || !isfinite(xyz_mm[2])) {
    return MaxArmResult(MaxArmError::kNotANumber);
  }
  const float radius = sqrtf(square(x) + square(y));
  const float r = radius - kShoulderOffset - kToolOffset;
  const float h = xyz_mm[2] - kBaseHeight;
  const float d2 = square(r) + square(h);
  const float d = sqrtf(d2);
  constexpr float kReach = kUpperArm + kForearm;
  if (!(d <= kReach + kToleranceMm)) return MaxArmResult(MaxArmError::kOutOfReach, d, kReach);
  if (radius < kRadiusMin) return MaxArmResult(MaxArmError::kTooClose, radius, kRadiusMin);

  // Law of cosines at the elbow. From 50 mm on, the cosine cannot exceed 1.
  const float cos_elbow =
      (square(kUpperArm) + square(kForearm) - d2) / (2.0F * kUpperArm * kForearm);
  const float elbow = acosf(cos_elbow < -1.0F ? -1.0F : cos_elbow);
  const float lift =
      atan2f(h, r) + atan2f(kForearm * sinf(elbow), kUpperArm - kForearm * cosf(elbow));
  joints_deg[0] = kFrontDeg - atan2f(x, -y) * kDegPerRad;
  joints_deg[1] = 180.0F - lift * kDegPerRad;
  joints_deg[2] = 180.0F - (lift + elbow) * kDegPerRad;
  return check_limits(joints_deg);
}

void forward(const float* joints_deg, float* xyz_mm) {
  const float turn = (kFrontDeg - joints_deg[0]) / kDegPerRad;
  const float shoulder = joints_deg[1] / kDegPerRad;
  const float forearm = joints_deg[2] / kDegPerRad;
  const float r =
      kShoulderOffset - kUpperArm * cosf(shoulder) + kForearm * cosf(forearm) + kToolOffset;
  xyz_mm[0] = r * sinf(turn);
  xyz_mm[1] = -r * cosf(turn);
  xyz_mm[2] = kBaseHeight + kUpperArm * sinf(shoulder) - kForearm * sinf(forearm);
}

void pulses_of(const float* joints_deg, float* pulses) {
  pulses[0] = joints_deg[0] / kDegPerPulse;
  pulses[1] = (kShoulderAtPulse0 - joints_deg[1]) / kDegPerPulse;
  pulses[2] = (joints_deg[2] - kForearmAtPulse0) / kDegPerPulse;
}

void joints_of(const int16_t* pulses, float* joints_deg) {
  joints_deg[0] = pulses[0] * kDegPerPulse;
  joints_deg[1] = kShoulderAtPulse0 - pulses[1] * kDegPerPulse;
  joints_deg[2] = pulses[2] * kDegPerPulse + kForearmAtPulse0;
}

int16_t nearest_pulse(float pulse) {
  const float rounded = floorf(pulse + 0.5F);
  if (!(rounded > kPulseMin)) return kPulseMin;
  return rounded < kPulseMax ? static_cast<int16_t>(rounded) : kPulseMax;
}

}  // namespace sinew_maxarm
