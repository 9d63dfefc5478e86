#pragma once

#include <cstdint>
#include <optional>

#include "sinew/core/error.h"
#include "sinew/core/instant.h"
#include "sinew/devices/axis_registers/axis_registers_wire.h"
#include "sinew/driver/send_range.h"
#include "sinew/model/device.h"
#include "sinew/model/robot_model.h"

/// What the register wire says of angles and faults, in the model's words. All @rt.
namespace sinew::axis_registers {

/// An angle as a board is told it.
struct ToldAngle {
  AngleBytes bytes{};
  double q = 0;          ///< rad, what the bytes mean
  double half_unit = 0;  ///< rad: half the distance to the next angle that can be said
};

/// The angle in `range` that the wire can say nearest to `q`.
/// @param zero  rad: the joint angle that AngleEncoding::kDegU32 calls 0.
/// @error kJointLimit (also where q is not a number), without an index
Expected<ToldAngle> tell_angle(AngleEncoding encoding, double zero, const SendRange& range,
                               double q);

/// What MOVE_ANGLE reads. Nothing: not four bytes, or no number.
std::optional<ToldAngle> read_angle(AngleEncoding encoding, double zero, const Data& data);

/// Angles nearer than this are the same target: half a unit, or a microstep and a half.
double same_target_tolerance(const ToldAngle& told);

/// s from rest to rest over `distance` (rad), the quickest inside the joint's limits.
/// Source: L. Biagiotti, C. Melchiorri, Trajectory Planning for Automatic Machines and Robots,
/// 2008, section 3.4.
double quickest_time(const Joint& joint, double distance);

/// What DIAG_STATUS says in its bits 8..15; nothing for 0.
std::optional<Error> fault_of(std::uint8_t number);

}  // namespace sinew::axis_registers
