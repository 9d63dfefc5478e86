#pragma once

#include <array>
#include <optional>

#include "sinew/core/error.h"
#include "sinew/core/fixed_vector.h"
#include "sinew/devices/axis_registers/axis_registers_wire.h"
#include "sinew/driver/device_facts.h"
#include "sinew/model/joint_count.h"

namespace sinew {

/// What a register holds.
struct AxisRegisterValue {
  axis_registers::Data data;
  bool written = false;  ///< by the host, and taken; else it was read
};

/// The boards of the register wire.
struct AxisRegistersFacts {
  /// By place in axis_registers::kDocumentRegisters.
  static constexpr std::size_t kRegisters = axis_registers::kDocumentRegisters.size();
  struct Axis {
    bool answers = false;
    std::optional<Error> fault;
    std::array<LastHeard<AxisRegisterValue>, kRegisters> registers;
  };
  FixedVector<Axis, kMaxJoints> axes;
};

}  // namespace sinew
