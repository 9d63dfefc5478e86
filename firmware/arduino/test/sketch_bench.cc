#include "sketch_bench.h"

#include <sstream>

#include "sinew/core/units.h"
#include "sinew/devices/maxarm/maxarm_test_model.h"
#include "sinew/kinematics/palletizer.h"

namespace sinew::arduino {

using emulation::AvrBoard;
using emulation::AvrChip;
namespace {

using namespace std::chrono_literals;

constexpr Duration kSinceBoot = 20s;
constexpr std::uint64_t kTick = AvrBoard::kHertz / 1000;

bool is_mega(const std::string& sketch) {
  return sketch.ends_with("-mega");
}

std::unique_ptr<ArmCable> cable_of(AvrBoard& board, const std::string& sketch) {
  if (is_mega(sketch)) return std::make_unique<UartCable>(board, '1');
  // Arduino's pins 6 and 7 of an Uno are the chip's PD6 and PD7.
  return std::make_unique<PinCable>(board, 'D', 6, 7);
}

}  // namespace

SketchBench::SketchBench(const std::string& sketch, MaxArmVariant variant, MaxArmChecksum checksum)
    : board(is_mega(sketch) ? AvrChip::kAtmega2560 : AvrChip::kAtmega328p,
            std::string(SINEW_SKETCHES) + "/" + sketch + ".bin"),
      machine(test::maxarm_model(), checksum, variant, 3, Instant{}),
      cable(cable_of(board, sketch)) {
  machine.advance(arm_now());
  cable->received = [this](std::uint8_t byte) {
    sent.push_back(byte);
    if (connected) machine.receive({&byte, 1}, arm_now());
  };
  board.at_cycle(kTick, [this] { return tick(); });
}

Instant SketchBench::arm_now() const {
  return Instant{} + kSinceBoot + board.now();
}

std::optional<std::uint64_t> SketchBench::tick() {
  machine.advance(arm_now());
  std::array<std::uint8_t, 64> bytes{};
  const std::size_t count = machine.take_output(bytes);
  for (std::size_t i = 0; i < count; ++i) cable->send(bytes[i]);
  return board.cycle() + kTick;
}

bool SketchBench::run_until_printed(const std::string& text, Duration limit) {
  const Duration end = board.now() + limit;
  while (board.now() < end) {
    if (board.printed().find(text) != std::string::npos) return true;
    run_for(10ms);
  }
  return false;
}

std::vector<std::string> SketchBench::lines() const {
  std::vector<std::string> lines;
  std::stringstream text(board.printed());
  for (std::string line; std::getline(text, line);) {
    if (line.ends_with('\r')) line.pop_back();
    lines.push_back(line);
  }
  return lines;
}

std::vector<double> SketchBench::numbers_behind(const std::string& name) const {
  std::vector<double> numbers;
  for (const std::string& line : lines()) {
    if (!line.starts_with(name)) continue;
    std::stringstream text(line.substr(name.size()));
    for (double number = 0; text >> number;) numbers.push_back(number);
    break;
  }
  return numbers;
}

double SketchBench::pulse(std::size_t servo) const {
  static const RobotModel model = test::maxarm_model();
  const MaxArmServo& drive = model.device.settings.get<MaxArmDevice>().servos[servo];
  return drive.offset + drive.pulses_per_rad * machine.truth().joints[servo].q;
}

std::array<double, 3> SketchBench::point_mm() const {
  static const RobotModel model = test::maxarm_model();
  const auto truth = machine.truth();
  const std::array<double, 3> q{truth.joints[0].q, truth.joints[1].q, truth.joints[2].q};
  const auto pose = kinematics::forward(std::get<PalletizerGeometry>(model.geometry), q);
  return {to_mm(pose.p.x), to_mm(pose.p.y), to_mm(pose.p.z)};
}

}  // namespace sinew::arduino
