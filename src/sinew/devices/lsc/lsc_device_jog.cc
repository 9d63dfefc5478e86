#include "sinew/devices/lsc/lsc_device_jog.h"

#include <cmath>

#include "sinew/core/units.h"

namespace sinew {
namespace {

constexpr double kCentre = 1500;               // us
constexpr double kUnitsPerRad = 2000 / kPi;    // us: 180 degrees from 500 to 2500
constexpr JogPulses kSigns{1, 1, -1, -1};      // how each servo is mounted
constexpr double kReachable = kPi / 2 + 1e-9;  // rad either side
constexpr int kPitchSteps = 180;               // of a degree

struct Tips {
  double x, y, z;  // mm
  double pitch;    // rad from straight up
};

Tips tips_at(const JogPulses& pulses) {
  JogPulses q{};
  for (std::size_t i = 0; i < q.size(); ++i)
    q[i] = kSigns[i] * (pulses[i] - kCentre) / kUnitsPerRad;
  const double fore = q[1] + q[2];
  const double pitch = fore + q[3];
  const double r = Esp32Links::kUpper * std::sin(q[1]) + Esp32Links::kFore * std::sin(fore) +
                   Esp32Links::kHand * std::sin(pitch);
  const double z = Esp32Links::kBase + Esp32Links::kUpper * std::cos(q[1]) +
                   Esp32Links::kFore * std::cos(fore) + Esp32Links::kHand * std::cos(pitch);
  return {r * std::cos(q[0]), r * std::sin(q[0]), z, pitch};
}

/// With the elbow to that side (+1 bends it forward).
std::optional<JogPulses> pulses_for(const Tips& tips, double side) {
  const double r = std::hypot(tips.x, tips.y) - Esp32Links::kHand * std::sin(tips.pitch);
  const double z = tips.z - Esp32Links::kBase - Esp32Links::kHand * std::cos(tips.pitch);
  const double a = Esp32Links::kUpper;
  const double b = Esp32Links::kFore;
  const double cosine = (r * r + z * z - a * a - b * b) / (2 * a * b);
  if (!(std::abs(cosine) <= 1)) return std::nullopt;
  JogPulses q{};
  q[0] = std::atan2(tips.y, tips.x);
  q[2] = side * std::acos(cosine);
  q[1] = std::atan2(r, z) - std::atan2(b * std::sin(q[2]), a + b * cosine);
  q[3] = tips.pitch - q[1] - q[2];
  for (std::size_t i = 0; i < q.size(); ++i) {
    if (std::abs(q[i]) > kReachable) return std::nullopt;
    q[i] = kCentre + kSigns[i] * kUnitsPerRad * q[i];
  }
  return q;
}

}  // namespace

std::optional<JogPulses> jogged(const JogPulses& now, const lsc::Jog& by) {
  const Tips start = tips_at(now);
  const double side = now[2] <= kCentre ? 1 : -1;
  for (int step = 0; step <= kPitchSteps; ++step) {
    for (const int way : {1, -1}) {
      const double pitch = start.pitch + way * step * kPi / 180;
      const Tips tips{start.x + by.dx_mm, start.y + by.dy_mm, start.z + by.dz_mm, pitch};
      for (const double bend : {side, -side}) {
        if (const auto pulses = pulses_for(tips, bend)) return pulses;
      }
      if (step == 0) break;
    }
  }
  return std::nullopt;
}

}  // namespace sinew
