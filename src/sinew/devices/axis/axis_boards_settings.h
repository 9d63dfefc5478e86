#pragma once

#include <span>
#include <string_view>

#include "sinew/model/device_settings.h"

namespace sinew {

/// Microsteps a second that a board makes at most: docs/firmware/axis_controller.md.
inline constexpr int kStepRateMost = 40'000;

/// What both wires of axis boards have in common.
/// @tparam Kind  derives from this
template <class Kind>
struct AxisBoardsOf : SettingsOf<Kind> {
  /// Of StopFacts.
  static constexpr std::string_view kFalls =
      "steppers hold; without power the arm drops: its gears do not hold it";

  AxisBoards boards;

  void identify(IdentityText& out) const override {
    for (const AxisBoard& board : boards) out.add(board.zero);
  }
  std::span<const AxisBoard> axis_boards() const override { return {boards.data(), boards.size()}; }
  AxisBoards* own_boards() override { return &boards; }
  double resolution(std::size_t /*joint*/) const override { return 0; }
  bool has_magnets() const override { return true; }
};

}  // namespace sinew
