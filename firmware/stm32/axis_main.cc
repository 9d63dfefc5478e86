#include <array>
#include <optional>
#include <utility>

#include "firmware/stm32/i2c_master.h"
#include "firmware/stm32/own_image.h"
#include "firmware/stm32/pins.h"
#include "firmware/stm32/quadrature_counter.h"
#include "firmware/stm32/serial_line.h"
#include "firmware/stm32/setup_flash.h"
#include "firmware/stm32/spi_slave.h"
#include "firmware/stm32/steps.h"
#include "sinew/devices/axis/axis_device_controller.h"
#include "sinew/devices/axis/axis_device_joint_node.h"
#include "sinew/devices/axis/axis_device_lamp.h"
#include "sinew/devices/axis/axis_device_setup.h"
#include "sinew/devices/axis/axis_device_spi.h"
#include "sinew/devices/axis/axis_device_unset.h"
#include "sinew/devices/encoder/encoder_device_chip.h"
#include "sinew/mcu/blink_code.h"

// The axis controller of robot-arm-2 on a board: what the simulator runs, with pins instead of
// physics. One loop owns controller and protocol; interrupts only own pins, timers and transfers.

namespace sinew::stm32 {
namespace {

constexpr std::uint32_t kSupplyEvent = 1U << 16;  // of EXTI
/// A sag counts as low for longer than the supervision waits until it is a fault (20 ms).
constexpr int kSupplyLowTicks = 8;

struct Hardware {
  Steps steps;
  SpiSlave spi;
  I2cMaster motor_sensor{
      kI2c1, {board::kMotorClock, chip::kI2cFunction}, {board::kMotorData, chip::kI2cFunction}};
  I2cMaster joint_sensor{kI2c2,
                         {board::kJointClock, chip::kI2cFunction},
                         {{chip::kJointDataPort, chip::kJointDataPin}, chip::kJointDataFunction}};
  QuadratureCounter quadrature;
  SerialLine node_line;  ///< to the joint's sensor, where that has a node
  EncoderReader node;
  std::int64_t ticks = 0;  ///< since power came on, by the interrupt of TIM4
  bool tick_due = false;
  bool stop_seen = false;  ///< the stop line was low since the last tick
  bool current = false;    ///< in the windings
  int supply_low_for = 0;  ///< ticks in which the supply counts as low
};
Hardware hardware;

/// Starts since power came on, this one included.
std::uint16_t count_start() {
  Register& count = chip::backup(0);
  count = (count + 1) & 0xFFFF;
  return static_cast<std::uint16_t>(count);
}

/// A latched stop outlives a reset by the watchdog: it was not released.
void remember_latch(bool latched) {
  chip::backup(1) = latched ? 1 : 0;
}
bool was_latched() {
  return chip::backup(1) == 1;
}

bool stop_line() {
  return !level(board::kStopLine);
}

void start_pins() {
  chip::start_pins();
  set_output(board::kEnable, true);
  set_output(board::kStep, false);
  set_output(board::kLed, true);
  for (const board::Place pin : {board::kEndStop, board::kStopLine, board::kDriverFault}) {
    chip::set_pin(pin.port, pin.pin, chip::Pin::kInputPullUp);
  }
}

void start_stop_line() {
  chip::choose_interrupt(board::kStopLine.pin, board::kStopLine.port);
  chip::exti().ftsr |= 1U << board::kStopLine.pin;
  chip::exti().imr |= 1U << board::kStopLine.pin;
  enable(Line::kExti15To10, 1);
}

Instant now() {
  const InterruptsOff off;
  return Instant{} + hardware.ticks * Steps::kTick;
}

/// The last tick's request has its reply, and the next one leaves.
void read_node(AxisInputs& inputs) {
  std::array<std::uint8_t, 16> bytes{};
  const std::size_t size = hardware.node_line.take(bytes);
  hardware.node.receive({bytes.data(), size}, now());
  read_joint_node(hardware.node, inputs, now());
  if (const auto request = hardware.node.poll(now())) hardware.node_line.send(*request);
}

/// The chip's own supply below 2.9 V (PVD, the highest of its thresholds) is an interrupt: the
/// power stage and the sensors fail soon after.
void start_supply_watch() {
  power().cr |= 0b111U << 5 | 1U << 4;
  chip::exti().rtsr |= kSupplyEvent;
  chip::exti().imr |= kSupplyEvent;
  enable(Line::kSupply, 1);
}
bool supply_is_low() {
  return (power().csr & 1U << 2) != 0;
}

AxisInputs read_inputs(const AxisEncoderSettings& encoders) {
  AxisInputs inputs;
  inputs.has_meters = false;
  if (hardware.supply_low_for > 0 || supply_is_low()) inputs.supply_volts = 0;
  if (encoders.joint == JointEncoder::kQuadrature) {
    inputs.joint_counts = hardware.quadrature.counts();
  } else if (encoders.joint_node) {
    read_node(inputs);
  } else if (encoders.joint == JointEncoder::kAs5600) {
    const auto reading = read_as5600(hardware.joint_sensor);
    inputs.joint_magnet = reading ? reading->magnet : Magnet::kNoReply;
    inputs.joint_encoder_ok = is_detected(inputs.joint_magnet);
    if (inputs.joint_encoder_ok) inputs.joint_counts = reading->position;
  }
  // The motor's last: what is controlled shall be as fresh as can be.
  const auto reading = read_as5600(hardware.motor_sensor);
  inputs.motor_magnet = reading ? reading->magnet : Magnet::kNoReply;
  inputs.motor_encoder_ok = is_detected(inputs.motor_magnet);
  if (inputs.motor_encoder_ok) inputs.motor_counts = reading->position;
  inputs.end_stop = !level(board::kEndStop);
  inputs.driver_fault = !level(board::kDriverFault);
  inputs.steps = hardware.steps.made();
  const InterruptsOff off;
  if (hardware.supply_low_for > 0) --hardware.supply_low_for;
  inputs.stop_line = stop_line() || hardware.stop_seen;
  hardware.stop_seen = false;
  return inputs;
}

void tick(AxisController& controller) {
  const AxisInputs inputs = read_inputs(controller.settings().encoders);
  const AxisOutputs outputs = controller.tick(inputs, now());
  // The stop line, or a sag of the supply, may have come since the inputs were read.
  const InterruptsOff off;
  const bool sags = hardware.supply_low_for > 0 || supply_is_low();
  hardware.current = outputs.enabled && !sags;
  set_level(board::kEnable, !hardware.current);
  if (outputs.frozen || sags || hardware.stop_seen || stop_line()) {
    hardware.steps.stop();
  } else {
    hardware.steps.go_to(outputs.steps);
  }
}

/// Lit while there is current in the windings, dark while there is none, and flashes for what is
/// wrong.
void show(const AxisStatus& status, bool set_up) {
  const std::uint8_t flashes = flashes_of(status, set_up);
  const auto ms = static_cast<std::uint32_t>((now() - Instant{}) / std::chrono::milliseconds(1));
  const bool lit = flashes > 0 ? mcu::is_lit(ms, flashes) : hardware.current;
  set_level(board::kLed, !lit);
}

[[noreturn]] void run() {
  static SetupFlash flash(hardware.steps);
  static SetupStore store(flash);
  static UnsetAxis unset;
  static std::optional<AxisController> controller;
  const std::optional<AxisSetup>& setup = store.setup();
  if (setup) controller.emplace(setup->axis);
  if (controller && was_latched()) controller->emergency_stop();
  if (setup && setup->axis.encoders.joint == JointEncoder::kAs5600) {
    setup->axis.encoders.joint_node ? hardware.node_line.start() : hardware.joint_sensor.start();
  }
  Axis& axis = controller ? static_cast<Axis&>(*controller) : unset;
  AxisLinkNodeSettings link = axis_link_node_settings(setup, count_start());
  link.image = own_image();
  static AxisSpiSlave slave(axis, link, setup ? setup->registers : AxisRegisterSlaveSettings{},
                            &store);
  for (;;) {
    bool tick_due = false;
    {
      const InterruptsOff off;
      // An interrupt that comes between the question and the waiting ends the waiting all the same.
      if (!hardware.tick_due && hardware.spi.received().empty()) asm volatile("wfi");
      tick_due = std::exchange(hardware.tick_due, false);
    }
    if (tick_due) {
      if (controller) tick(*controller);
      remember_latch(axis.status().emergency_stopped);
      show(axis.status(), setup.has_value());
      slave.advance(now());
      if (slave.restart_due()) restart();
      feed_watchdog();
    }
    // A host that is quicker than this loop does not keep it from its ticks.
    while (!hardware.tick_due && !hardware.spi.received().empty()) {
      slave.transfer(hardware.spi.received());
      hardware.spi.taken();
      if (axis.status().emergency_stopped) hardware.steps.stop();
    }
    std::array<std::uint8_t, SpiSlave::kTransferMax> answer{};
    slave.next_answer(answer);
    hardware.spi.offer(answer);
  }
}

}  // namespace
}  // namespace sinew::stm32

using namespace sinew::stm32;

extern "C" {

/// Pulses and current end at once: what a motor does while its supply sags is not known.
void supply_low() {
  chip::exti().pr = kSupplyEvent;
  hardware.steps.stop();
  set_level(board::kEnable, true);
  hardware.supply_low_for = kSupplyLowTicks;
}

void timer_4() {
  ++hardware.ticks;
  hardware.steps.on_tick();
  hardware.tick_due = true;
}

void usart_2() {
  hardware.node_line.on_interrupt();
}

void external_interrupt_4() {
  hardware.spi.on_deselect();
}

void external_interrupts_15_to_10() {
  chip::exti().pr = 1U << board::kStopLine.pin;
  hardware.steps.stop();
  hardware.stop_seen = true;
}

int main() {
  start_pins();
  start_watchdog();
  chip::start_clocks();
  start_stop_line();
  start_supply_watch();
  hardware.motor_sensor.start();
  hardware.quadrature.start();
  hardware.spi.start();
  hardware.steps.start();
  run();
}

}  // extern "C"
