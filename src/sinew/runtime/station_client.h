#pragma once

#include <vector>

#include "sinew/control/machine.h"
#include "sinew/runtime/station.h"

namespace sinew::runtime {

/// A client of a station in another thread. What it says is as old as the last refresh(). Whoever
/// it acts for has to be alive for its lease to be renewed: none is without keep_lease().
class StationClient final : public control::Machine {
 public:
  /// Commands that wait until the lease has come.
  static constexpr std::size_t kWaitingMax = 64;

  /// @param station  outlives this
  /// @error kBusy: as many as a station serves are there
  static Expected<std::unique_ptr<StationClient>> make(Station& station, control::ClientId client);
  ~StationClient() override;
  StationClient(const StationClient&) = delete;
  StationClient& operator=(const StationClient&) = delete;

  /// What the last cycle left, and what waited for the lease goes out.
  void refresh();
  const StationView& view() const { return view_; }
  Station& station() const { return station_; }

  const RobotModel& robot() const override { return station_.robot(); }
  control::MachineState state() const override { return view_.state; }
  std::span<const JointPosition> positions() const override {
    return {view_.positions.data(), view_.positions.size()};
  }
  std::optional<JointVector> reference() const override { return view_.reference; }
  ToolState tool() const override { return view_.tool; }
  const control::LeaseToken& lease() const override { return lease_; }
  const std::optional<control::Latched>& latched() const override { return view_.latched; }
  std::optional<Instant> goes_on_until() const override { return view_.goes_on_until; }
  std::optional<std::size_t> homing_joint() const override { return view_.homing_joint; }
  std::uint32_t give(const control::CommandWhat& what) override;
  std::optional<control::ControlEvent> take_event() override;

  /// Renews the lease, where it has one and a tenth of a second has passed.
  void keep_lease(Instant now);
  /// From now on in the name of another client, under its lease where it has one.
  void act_for(control::ClientId client);

  /// A motion that was given to the controller may still be looked at by it.
  bool motion_in_use() const { return motion_ != 0; }

 private:
  StationClient(Station& station, control::ClientId client, std::uint8_t slot);
  void send(const control::Command& command);
  void look_at(const control::ControlEvent& event);

  Station& station_;
  std::uint8_t slot_;
  control::LeaseToken lease_;
  StationView view_;
  std::optional<Instant> renewed_;
  std::uint32_t taking_ = 0;  ///< the command that asks for the lease
  std::uint32_t motion_ = 0;  ///< the command that has a motion
  std::vector<control::Command> waiting_;
  std::vector<control::ControlEvent> refused_;  ///< that did not get as far as the station
};

}  // namespace sinew::runtime
