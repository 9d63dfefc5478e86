#pragma once

#include <cstdint>
#include <string_view>

#include "sinew/model/device_settings.h"
#include "sinew/model/robot_model.h"

namespace sinew {

/// An encoder node by itself, on a serial adapter.
struct EncoderNodeDevice final : SettingsOf<EncoderNodeDevice> {
  void identify(IdentityText& out) const override { out.add(std::string_view("encoder_node")); }
  StopFacts stop_facts() const override {
    return {true, "nothing: it moves nothing", "nothing: it moves nothing"};
  }
  bool has_magnets() const override { return true; }
};

/// Of our nodes; 8 data bits, no parity.
inline constexpr std::uint32_t kEncoderBaud = 115'200;

/// The node's shaft as a robot of one joint, for what takes a robot: faults, reports.
inline RobotModel encoder_shaft() {
  RobotModel model;
  model.id = "encoder";
  model.joints.push_back({.name = "shaft"});
  model.device.baud = kEncoderBaud;
  model.device.settings.emplace<EncoderNodeDevice>();
  return model;
}

}  // namespace sinew
