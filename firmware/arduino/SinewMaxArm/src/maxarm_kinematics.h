#pragma once

#include <Arduino.h>

#include "maxarm_result.h"

/// Kinematics of the MaxArm in float; mm and degrees.
///
/// Frame: z up from the table, the front of the arm is -y, +x to its right. Joints: base (120 is
/// the front), shoulder (90 is upright), forearm (0 is level, grows downwards). The nozzle never
/// tilts. A servo pulse is 0.24 degrees.
namespace sinew_maxarm {

constexpr float kDegPerPulse = 0.24F;
constexpr int16_t kPulseMin = 1;  ///< never 0: a servo that reads 0 ends the MicroPython program
constexpr int16_t kPulseMax = 1000;

/// Joint angles that put the nozzle at a point; limits are inclusive.
/// @error kNotANumber, kOutOfReach, kTooClose, kJointLimit: the joint that is farthest out
MaxArmResult inverse(const float* xyz_mm, float* joints_deg);

void forward(const float* joints_deg, float* xyz_mm);

/// Pulses, not rounded.
void pulses_of(const float* joints_deg, float* pulses);
void joints_of(const int16_t* pulses, float* joints_deg);

/// The nearest pulse that may be sent.
int16_t nearest_pulse(float pulse);

}  // namespace sinew_maxarm
