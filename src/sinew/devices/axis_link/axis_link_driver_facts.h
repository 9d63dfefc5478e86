#pragma once

#include <cstdint>
#include <optional>

#include "sinew/core/error.h"
#include "sinew/core/fixed_vector.h"
#include "sinew/devices/axis_link/axis_link_wire.h"
#include "sinew/driver/device_facts.h"
#include "sinew/model/joint_count.h"

namespace sinew {

/// The axes of Sinew's own link.
struct AxisLinkFacts {
  struct Axis {
    bool up = false;
    std::optional<Error> fault;  ///< why it is out
    LastHeard<axis_link::State> state;
    LastHeard<axis_link::Identity> identity;
    LastHeard<axis_link::Health> health;
    std::optional<double> setpoint;    ///< rad, what its last frame asked for
    std::optional<double> zero_shift;  ///< rad
    std::uint64_t failed_frames = 0;
    std::uint64_t late_frames = 0;  ///< good ones, to an earlier frame than the last
  };
  FixedVector<Axis, kMaxJoints> axes;
  Duration round{};  ///< from one frame of an axis to its next
};

}  // namespace sinew
