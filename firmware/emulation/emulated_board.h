#pragma once

#include <algorithm>
#include <array>
#include <filesystem>
#include <string>
#include <vector>

#include "firmware/emulation/stm32.h"
#include "sinew/core/assert.h"
#include "sinew/devices/axis/axis_device_setup_model.h"
#include "sinew/devices/axis/axis_machine.h"
#include "sinew/devices/encoder/encoder_machine.h"

namespace sinew::emulation {

/// As tests are named by it.
inline std::string name_of(Stm32Chip chip) {
  return chip == Stm32Chip::kF103 ? "stm32f103" : "stm32f401";
}

/// An AS5600, as its I2C bus sees it.
class AngleChip : public I2cChip {
 public:
  bool acknowledges(std::uint8_t address) override { return plugged_in && address == 0x36; }
  void begin_write() override { pointer_next_ = true; }
  void put(std::uint8_t byte) override {
    if (pointer_next_) pointer_ = byte;
    pointer_next_ = false;
  }
  std::uint8_t get() override {
    switch (pointer_++) {
      case 0x0B:
        return magnet ? 0x20 : 0;
      case 0x0C:
        return static_cast<std::uint8_t>(counts >> 8);
      case 0x0D:
        return static_cast<std::uint8_t>(counts & 0xFF);
      default:
        return 0;
    }
  }

  std::uint16_t counts = 0;
  bool magnet = true;
  bool plugged_in = true;

 private:
  std::uint8_t pointer_ = 0;
  bool pointer_next_ = false;
};

/// The places for the setup in the flash of an emulated chip, as another program writes them.
class ChipMemory : public SetupMemory {
 public:
  ChipMemory(CortexM& core, Stm32Chip which) : core_(core) {
    const bool f1 = which == Stm32Chip::kF103;
    addresses_ = {f1 ? 0x0800'F800U : 0x0801'0000U, f1 ? 0x0800'FC00U : 0x0802'0000U};
    for (int i : {0, 1}) {
      for (std::uint32_t k = 0; k < kSize; ++k) {
        copies_[i].push_back(core_.load_byte(addresses_[i] + k));
      }
    }
  }
  std::span<const std::uint8_t> place(int which) const override { return copies_[which]; }
  bool erase(int which) override {
    copies_[which].assign(kSize, 0xFF);
    return true;
  }
  bool append(int which, std::span<const std::uint8_t> bytes) override {
    std::ranges::copy(bytes, copies_[which].begin());
    for (std::uint32_t k = 0; k < kSize; ++k) {
      core_.store_byte(addresses_[which] + k, copies_[which][k]);
    }
    return true;
  }

 private:
  static constexpr std::size_t kSize = 1024;
  CortexM& core_;
  std::array<std::uint32_t, 2> addresses_{};
  std::array<std::vector<std::uint8_t>, 2> copies_;
};

/// An axis controller's image on its emulated chip, wired to the simulated axis: pulses of the step
/// pin turn the motor; encoders, end stop and supply come back.
class EmulatedBoard {
 public:
  /// @param q  rad, where the joint stands
  EmulatedBoard(Stm32Chip which, const RobotModel& model, std::size_t joint, double q,
                std::uint64_t seed)
      : kind(which),
        setup(axis_setup(model, joint)),
        chip(which, read_image(image(which))),
        plant(sim::axis_plant_settings(model, joint, setup.axis), q, seed) {
    plant.set_load(0, 0.05);
    chip.i2c1().chip = &motor_sensor;
    chip.i2c2().chip = &joint_sensor;
    if (setup.axis.encoders.joint_node) connect_node();
    chip.timers().on_pulse = [this](Cycles at, bool high) {
      if (!high) return;
      steps += chip.output('B', 12) ? -1 : 1;
      ++pulses;
      last_pulse = at;
    };
  }
  EmulatedBoard(const EmulatedBoard&) = delete;
  EmulatedBoard& operator=(const EmulatedBoard&) = delete;

  static std::filesystem::path image(Stm32Chip which) {
    return std::filesystem::path(SINEW_IMAGES) / ("axis-" + name_of(which) + ".bin");
  }

  /// Another program has written its setup.
  void set_up() {
    ChipMemory memory(chip.core(), kind);
    SINEW_ASSERT(SetupStore(memory).keep(setup));
    chip.power_cycle();
  }
  /// The mechanics of the last `dt` (s), and what the board senses from now on.
  void advance_plant(double dt) {
    AxisOutputs outputs;
    outputs.enabled = !chip.output('B', 13);
    outputs.steps = steps;
    plant.advance(outputs, dt);
    const AxisInputs inputs = plant.inputs();
    motor_sensor.counts = inputs.motor_counts;
    motor_sensor.magnet = inputs.motor_encoder_ok;
    if (node) {
      node->advance(now());
    } else if (setup.axis.encoders.joint == JointEncoder::kAs5600) {
      joint_sensor.counts = static_cast<std::uint16_t>(inputs.joint_counts);
      joint_sensor.magnet = inputs.joint_encoder_ok;
    } else {
      chip.timers().turn_encoder(inputs.joint_counts);
    }
    chip.set_input('B', 14, !inputs.end_stop);
  }

  Stm32Chip kind;
  AxisSetup setup;
  Stm32 chip;
  sim::AxisPlant plant;
  AngleChip motor_sensor;
  AngleChip joint_sensor;

  /// Of a joint sensor that is read over RS-485.
  sim::As5600Bus node_bus{plant.joint_sensor()};
  std::optional<sim::EncoderBoard> node;
  bool node_plugged_in = true;
  int undriven_bytes = 0;  ///< that left while the transceiver was not driving

  std::int64_t steps = 0;  ///< by the step pin, signed by the direction pin
  std::int64_t pulses = 0;
  Cycles last_pulse = 0;

 private:
  Instant now() const { return Instant{} + from_seconds(chip.seconds()); }
  /// The node at the other end of USART2, with the transceiver's enable on PB1.
  void connect_node() {
    node.emplace(node_bus, Instant{});
    chip.usart2().on_byte = [this](Cycles, std::uint8_t byte) {
      if (!chip.output('B', 1)) ++undriven_bytes;
      if (!node_plugged_in) return;
      node->receive(std::array{byte}, now());
      std::array<std::uint8_t, encoder_link::kReplySize> reply{};
      const std::size_t size = node->take_output(reply);
      for (std::size_t i = 0; i < size; ++i) chip.usart2().arrive(reply[i]);
    };
  }
};

}  // namespace sinew::emulation
