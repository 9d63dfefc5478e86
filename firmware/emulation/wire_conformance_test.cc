#include <gtest/gtest.h>

#include <functional>
#include <memory>
#include <vector>

#include "firmware/emulation/axis_bench.h"
#include "sinew/devices/axis/axis_device_spi.h"
#include "sinew/devices/axis/axis_machine.h"
#include "sinew/devices/axis_registers/axis_registers_wire.h"
#include "support/property.h"
#include "support/robots.h"

/// One table of exchanges, three runners: the simulated board, the board's program built for this
/// machine, and the image as it is flashed. And random bytes, which the last two must answer alike.
namespace sinew::emulation {
namespace {

using Bytes = std::vector<std::uint8_t>;
using axis_link::Mode;
using axis_link::Verdict;
namespace registers = axis_registers;

constexpr std::size_t kShoulder = 1;
constexpr Duration kPause = std::chrono::milliseconds(20);
constexpr std::uint32_t kClockHz = 500'000;

const RobotModel& model() {
  return test::robot("robot-arm-2");
}
double start_angle() {
  return model().joints[kShoulder].lower + from_deg(4);
}

/// A board at its chip select.
class Runner {
 public:
  virtual ~Runner() = default;
  /// A transfer, and the pause behind it.
  virtual Bytes exchange(const Bytes& mosi) = 0;
};

class Simulated : public Runner {
 public:
  explicit Simulated(sim::AxisWire wire)
      : arm_(model(), {.wire = wire, .start = start()}, Instant{}) {
    pass(std::chrono::milliseconds(100));
  }
  Bytes exchange(const Bytes& mosi) override {
    spi::Transfer transfer;
    transfer.select = 1U << kShoulder;
    transfer.clock_hz = kClockHz;
    transfer.setup = registers::kSelectSetup;
    for (const std::uint8_t byte : mosi) transfer.mosi.push_back(byte);
    const spi::Bytes miso = arm_.exchange(transfer, now_);
    pass(kPause);
    return {miso.begin(), miso.end()};
  }

 private:
  static JointVector start() {
    JointVector q;
    for (const Joint& joint : model().joints) q.push_back(joint.lower + from_deg(4));
    return q;
  }
  void pass(Duration time) {
    now_ += time;
    arm_.advance(now_);
  }
  sim::StepperArm arm_;
  Instant now_{};
};

/// What the image is made of, with the control cycle of its chip.
class HostBuild : public Runner {
 public:
  HostBuild() { pass(std::chrono::milliseconds(100)); }
  Bytes exchange(const Bytes& mosi) override {
    Bytes miso(mosi.size());
    slave_.next_answer(miso);
    slave_.transfer(mosi);
    pass(kPause);
    return miso;
  }

 private:
  static constexpr Duration kTick = std::chrono::milliseconds(4);
  void pass(Duration time) {
    for (const Instant end = now_ + time; now_ < end;) {
      now_ += kTick;
      plant_.advance(outputs_, to_seconds(kTick));
      AxisInputs inputs = plant_.inputs();
      inputs.has_meters = false;
      outputs_ = controller_.tick(inputs, now_);
      slave_.advance(now_);
    }
  }
  AxisSetup setup_ = axis_setup(model(), kShoulder);
  sim::AxisPlant plant_{sim::axis_plant_settings(model(), kShoulder, setup_.axis), start_angle(),
                        1};
  AxisController controller_{setup_.axis};
  AxisOutputs outputs_;
  AxisSpiSlave slave_{controller_, axis_link_node_settings(setup_, 2), setup_.registers};
  Instant now_{};
};

class Image : public Runner {
 public:
  explicit Image(Stm32Chip chip) : bench_(chip, model(), kShoulder, start_angle(), 1) {
    bench_.set_up();
    static_cast<void>(bench_.run(0.1));
  }
  Bytes exchange(const Bytes& mosi) override {
    const Bytes miso = bench_.chip.transfer(mosi, clock_hz, setup_s);
    EXPECT_TRUE(bench_.run(pause_s)) << bench_.broken.value_or("");
    return miso;
  }

  std::uint32_t clock_hz = kClockHz;
  double setup_s = to_seconds(registers::kSelectSetup);
  double pause_s = to_seconds(kPause);

 private:
  AxisBench bench_;
};

/// The runners by name, as a parameter; which wire matters to the simulated board only.
enum class Which : std::uint8_t { kSimulated, kHostBuild, kStm32f103, kStm32f401 };
std::unique_ptr<Runner> runner(Which which, sim::AxisWire wire) {
  switch (which) {
    case Which::kSimulated:
      return std::make_unique<Simulated>(wire);
    case Which::kHostBuild:
      return std::make_unique<HostBuild>();
    case Which::kStm32f103:
      return std::make_unique<Image>(Stm32Chip::kF103);
    case Which::kStm32f401:
      break;
  }
  return std::make_unique<Image>(Stm32Chip::kF401);
}

// --- the register protocol -----------------------------------------------------------------------

/// What is sent in one transfer, and what comes back where that is laid down.
struct Step {
  Bytes mosi;
  std::optional<Bytes> miso = {};
};
struct Script {
  std::string name;
  std::vector<Step> steps;
};

template <class Range>
Bytes to_bytes(const Range& range) {
  return Bytes(range.begin(), range.end());
}

std::vector<Step> opening(const Bytes& header, registers::Verdict verdict) {
  return {{{registers::kSyn}},
          {{registers::kDummy}, Bytes{registers::kSynAck}},
          {{registers::kAck}},
          {header},
          {{registers::kDummy}, Bytes{static_cast<std::uint8_t>(verdict)}}};
}

registers::HeaderBytes header(std::uint16_t id, registers::Operation operation,
                              std::uint16_t address, std::uint16_t size) {
  return registers::encode_header({.slave_id = 1,
                                   .frame_id = id,
                                   .operation = static_cast<std::uint8_t>(operation),
                                   .address = address,
                                   .size = size});
}

Script read(std::string name, std::uint16_t id, std::uint16_t address,
            const std::optional<Bytes>& value, std::uint16_t size) {
  Script script{std::move(name),
                opening(to_bytes(header(id, registers::Operation::kRead, address, size)),
                        registers::Verdict::kOk)};
  const auto sealed = value ? std::optional(to_bytes(registers::seal(*value))) : std::nullopt;
  script.steps.push_back({Bytes(size + registers::kCrcSize, registers::kFill), sealed});
  script.steps.push_back({to_bytes(registers::encode_commit(registers::Verdict::kOk))});
  return script;
}

Script write(std::string name, std::uint16_t id, std::uint16_t address, Bytes sealed,
             registers::Verdict commit = registers::Verdict::kOk) {
  const auto size = static_cast<std::uint16_t>(sealed.size() - registers::kCrcSize);
  Script script{std::move(name),
                opening(to_bytes(header(id, registers::Operation::kWrite, address, size)),
                        registers::Verdict::kOk)};
  script.steps.push_back({std::move(sealed)});
  script.steps.push_back({Bytes(registers::kCommitSize, registers::kFill),
                          to_bytes(registers::encode_commit(commit))});
  return script;
}

/// A header that is refused; nothing follows it.
Script refused(std::string name, registers::HeaderBytes bytes, std::size_t spoilt,
               std::uint8_t with, registers::Verdict verdict, bool resealed = true) {
  bytes[spoilt] = with;
  if (resealed) {
    const std::uint32_t crc = registers::crc32(std::span(bytes).subspan(1, 8));
    for (std::size_t i = 0; i < 4; ++i) {
      bytes[9 + i] = static_cast<std::uint8_t>(crc >> 8 * (3 - i));
    }
  }
  return {std::move(name), opening(to_bytes(bytes), verdict)};
}

/// Addresses of the document: 0 HOMING, 1 MOVE_ANGLE, 2 DIAG_CONTROL, 3 DIAG_STATUS, 4 E-STOP.
std::vector<Script> register_table() {
  using registers::Operation;
  using registers::Verdict;
  std::uint16_t id = 1;
  const auto good = [&] { return header(id++, Operation::kRead, 0, 1); };
  const auto sealed = [](const Bytes& data) { return to_bytes(registers::seal(data)); };
  std::vector<Script> table;
  table.push_back(read("HOMING of a board that rests", id++, 0, Bytes{0}, 1));
  table.push_back(write("the emergency stop latches", id++, 4, sealed({1})));
  table.push_back(read("and reads 1", id++, 4, Bytes{1}, 1));
  table.push_back(read("DIAG_STATUS", id++, 3, std::nullopt, 4));
  table.push_back(write("written 0 it is released", id++, 4, sealed({0})));
  table.push_back(read("and reads 0", id++, 4, Bytes{0}, 1));
  table.push_back(refused("start byte", good(), 0, 0x54, Verdict::kStartByte));
  table.push_back(refused("slave id", good(), 1, 2, Verdict::kSlaveId));
  table.push_back(refused("operation", good(), 4, 3, Verdict::kOperation));
  table.push_back(refused("register", good(), 6, 9, Verdict::kRegister));
  table.push_back(refused("size", good(), 8, 2, Verdict::kSize));
  table.push_back(refused("checksum", good(), 9, 0x5A, Verdict::kCrc, false));
  table.push_back(refused("end byte", good(), 13, 0xAB, Verdict::kEndByte, false));
  const std::uint16_t twice = id++;
  table.push_back(read("a frame id", twice, 0, Bytes{0}, 1));
  table.push_back({"the same one again",
                   opening(to_bytes(header(twice, Operation::kRead, 0, 1)), Verdict::kFrameId)});
  table.push_back(refused("a register that is written only", header(id++, Operation::kRead, 2, 1),
                          8, 1, Verdict::kOperation));
  Bytes damaged = sealed({1});
  damaged[0] ^= 1;
  table.push_back(write("damaged data", id++, 4, damaged, Verdict::kCrc));
  table.push_back(read("changes nothing", id++, 4, Bytes{0}, 1));
  Script broken = read("a header that breaks off is begun again", id++, 0, Bytes{0}, 1);
  const Bytes whole = broken.steps[3].mosi;
  broken.steps.insert(broken.steps.begin() + 3, {Bytes(whole.begin(), whole.begin() + 7)});
  table.push_back(broken);
  Script surplus = read("bytes beyond a transfer's end are ignored", id++, 0, Bytes{0}, 1);
  surplus.steps[0].mosi.insert(surplus.steps[0].mosi.end(), 20, 0x99);
  surplus.steps[3].mosi.insert(surplus.steps[3].mosi.end(), 20, 0x97);
  table.push_back(surplus);
  Script stray = read("stray bytes before SYN and ACK", id++, 0, Bytes{0}, 1);
  stray.steps.insert(stray.steps.begin() + 2, {Bytes{0x12}});
  stray.steps.insert(stray.steps.begin(), {Bytes{0x00}});
  table.push_back(stray);
  // A second host, which knows nothing of the first one's open transaction.
  Script half{"a transaction that its host leaves",
              opening(to_bytes(header(id++, Operation::kWrite, 4, 1)), Verdict::kOk)};
  table.push_back(half);
  Script resync{"a new host resynchronises", {}};
  for (int i = 0; i < registers::kResyncBursts; ++i) {
    resync.steps.push_back({Bytes(registers::kResyncSize, registers::kResyncByte)});
  }
  table.push_back(resync);
  table.push_back(read("and is served", id++, 4, Bytes{0}, 1));
  return table;
}

class Conformance : public ::testing::TestWithParam<Which> {};
std::string name_of(Which which) {
  constexpr const char* kNames[] = {"simulated", "host_build", "stm32f103", "stm32f401"};
  return kNames[static_cast<int>(which)];
}
INSTANTIATE_TEST_SUITE_P(, Conformance,
                         ::testing::Values(Which::kSimulated, Which::kHostBuild, Which::kStm32f103,
                                           Which::kStm32f401),
                         [](const auto& which) { return name_of(which.param); });

TEST_P(Conformance, register_protocol) {
  const auto board = runner(GetParam(), sim::AxisWire::kRegisters);
  for (const Script& script : register_table()) {
    for (std::size_t i = 0; i < script.steps.size(); ++i) {
      const Bytes miso = board->exchange(script.steps[i].mosi);
      if (!script.steps[i].miso) continue;
      EXPECT_EQ(miso, *script.steps[i].miso) << script.name << ", transfer " << i + 1;
    }
  }
}

// --- the axis link -------------------------------------------------------------------------------

/// What an axis says of a request in the next transfer.
struct Expected {
  bool session = true;             ///< one is open
  bool executed = true;            ///< the sequence is the request's
  std::optional<Verdict> verdict;  ///< of a State
  std::optional<bool> latched = {};
};
struct LinkRow {
  std::string name;
  axis_link::Request request;
  Expected expected;
  std::function<void(Bytes& frame)> spoil = [](Bytes&) {};
  bool other_host = false;  ///< with a session that is not its own
};

std::vector<LinkRow> link_table() {
  const auto axis = static_cast<std::uint8_t>(kShoulder);
  const AxisSetup setup = axis_setup(model(), kShoulder);
  const auto hash =
      axis_link::model_hash({axis, setup.axis.lower, setup.axis.upper, setup.axis.limits.velocity,
                             setup.axis.limits.acceleration, setup.axis.limits.jerk});
  const auto deadline = axis_link::kDeadlineMax;
  std::uint16_t sequence = 100;
  const auto request = [&](Mode mode, std::int32_t target = 0) {
    return axis_link::Request{.axis = axis, .mode = mode, .sequence = ++sequence, .target = target};
  };
  const auto move = [&] { return request(Mode::kMove, axis_link::to_units(0.1).value()); };
  constexpr Expected kNone{.session = false, .executed = false, .verdict = Verdict::kNoSession};
  return {
      {"no session: nothing is executed", move(), kNone},
      {"an emergency stop needs none",
       request(Mode::kEmergencyStop),
       {.session = false, .executed = false, .verdict = {}, .latched = true}},
      {"a hello for another model opens none",
       axis_link::hello(axis, ++sequence, hash ^ 1, deadline),
       {.session = false, .executed = false, .verdict = {}}},
      {"a hello opens one", axis_link::hello(axis, ++sequence, hash, deadline), {.verdict = {}}},
      {"the latch holds", move(), {.verdict = Verdict::kEmergencyStopped, .latched = true}},
      {"release", request(Mode::kRelease), {.verdict = Verdict::kAccepted, .latched = false}},
      {"a move before homing", move(), {.verdict = Verdict::kNotHomed, .latched = false}},
      {"a damaged frame",
       request(Mode::kEmergencyStop),
       {.executed = false, .verdict = {}, .latched = false},
       [](Bytes& frame) { frame[5] ^= 0x10; }},
      {"a frame that breaks off",
       request(Mode::kEmergencyStop),
       {.executed = false, .verdict = {}, .latched = false},
       [](Bytes& frame) { frame.resize(9); }},
      {"another host's session", move(), {.executed = false, .verdict = {}}, [](Bytes&) {}, true},
      {"another axis's frame",
       {.axis = 5, .mode = Mode::kEmergencyStop, .sequence = 7},
       {.executed = false, .verdict = {}, .latched = false}},
      {"a number of the past",
       {.axis = axis, .mode = Mode::kClearFaults, .sequence = 3},
       {.executed = false, .verdict = {}}},
      {"read", request(Mode::kRead), {.verdict = Verdict::kAccepted, .latched = false}},
      {"a stop to all",
       {.axis = axis, .to_all = true, .mode = Mode::kEmergencyStop, .sequence = ++sequence},
       {.executed = false, .verdict = {}, .latched = true}},
  };
}

TEST_P(Conformance, axis_link) {
  const auto board = runner(GetParam(), sim::AxisWire::kLink);
  std::uint8_t session = 0;
  const auto decoded = [&](const Bytes& miso) -> std::optional<axis_link::Reply> {
    if (miso.size() < axis_link::kFrameSize) return std::nullopt;
    const auto reply = axis_link::decode_reply(
        std::span<const std::uint8_t, axis_link::kFrameSize>(miso.data(), axis_link::kFrameSize));
    return reply ? std::optional(*reply) : std::nullopt;
  };
  for (const LinkRow& row : link_table()) {
    SCOPED_TRACE(row.name);
    axis_link::Request request = row.request;
    request.session = row.other_host ? static_cast<std::uint8_t>(session + 1) : session;
    Bytes frame = to_bytes(axis_link::encode(request));
    row.spoil(frame);
    board->exchange(frame);
    // Sixteen bytes that are no frame change nothing, and fetch the answer.
    const auto reply = decoded(board->exchange(Bytes(axis_link::kFrameSize, 0)));
    ASSERT_TRUE(reply);
    session = reply->session;
    EXPECT_EQ(reply->session != 0, row.expected.session);
    EXPECT_EQ(reply->sequence == request.sequence, row.expected.executed);
    const auto* state = std::get_if<axis_link::State>(&reply->body);
    if (state != nullptr && row.expected.verdict) {
      EXPECT_EQ(state->verdict, *row.expected.verdict);
    }
    if (row.expected.latched) {
      ASSERT_NE(state, nullptr);
      EXPECT_EQ(state->emergency_stopped, *row.expected.latched);
    }
  }
}

// --- the image against its own program -----------------------------------------------------------

class ImageAgainstHostBuild : public ::testing::TestWithParam<Stm32Chip> {};
INSTANTIATE_TEST_SUITE_P(, ImageAgainstHostBuild,
                         ::testing::Values(Stm32Chip::kF103, Stm32Chip::kF401),
                         [](const auto& chip) { return name_of(chip.param); });

/// A header that may be spoilt. HOMING is left out: a motion is another one on either side.
Bytes random_header(test::Random& random, std::uint16_t& id, registers::Operation operation) {
  const auto address = static_cast<std::uint16_t>(random.integer(2, 4));
  const bool long_one = address == 3 || random.chance(0.1);
  Bytes bytes = to_bytes(header(id, operation, address, long_one ? 4 : 1));
  if (random.chance(0.9)) ++id;
  if (random.chance(0.15)) bytes[static_cast<std::size_t>(random.integer(0, 13))] ^= 0x41;
  return bytes;
}

/// The transfers of a transaction: good, spoilt, left out, said twice, cut short, or too long.
std::vector<Bytes> random_transaction(test::Random& random, std::uint16_t& id) {
  const bool reads = random.chance(0.5);
  const auto operation = reads ? registers::Operation::kRead : registers::Operation::kWrite;
  std::vector<Bytes> good{{registers::kSyn},
                          {registers::kDummy},
                          {registers::kAck},
                          random_header(random, id, operation),
                          {registers::kDummy}};
  const Bytes value{static_cast<std::uint8_t>(random.integer(0, 2))};
  good.push_back(reads ? Bytes(8, registers::kFill) : to_bytes(registers::seal(value)));
  good.push_back(reads ? to_bytes(registers::encode_commit(registers::Verdict::kOk))
                       : Bytes(registers::kCommitSize, registers::kFill));
  std::vector<Bytes> transfers;
  for (Bytes& bytes : good) {
    if (random.chance(0.03)) continue;
    if (random.chance(0.03)) transfers.push_back(bytes);
    if (random.chance(0.03)) bytes.resize(static_cast<std::size_t>(random.integer(0, 31)), 0x97);
    if (random.chance(0.03) && !bytes.empty()) {
      bytes[random.bits() % bytes.size()] = static_cast<std::uint8_t>(random.bits());
    }
    transfers.push_back(bytes);
  }
  return transfers;
}

TEST_P(ImageAgainstHostBuild, answers_random_transfers_alike) {
  test::Random random(test::seed());
  HostBuild host;
  Image image(GetParam());
  // The first good header decides for this wire: the other one's answers have a position in them,
  // which is another noise on either side.
  for (const Step& step : read("HOMING", 1, 0, std::nullopt, 1).steps) {
    host.exchange(step.mosi);
    image.exchange(step.mosi);
  }
  std::uint16_t id = 2;
  int served = 0;
  for (int i = 0; i < 150; ++i) {
    for (const Bytes& mosi : random_transaction(random, id)) {
      const Bytes expected = host.exchange(mosi);
      // A host whose clock and pauses wander.
      image.clock_hz = static_cast<std::uint32_t>(random.integer(50'000, 4'000'000));
      image.setup_s = random.uniform(20e-6, 500e-6);
      image.pause_s = random.uniform(11e-3, 30e-3);
      ASSERT_EQ(image.exchange(mosi), expected)
          << "transaction " << i << ": " << testing::PrintToString(mosi);
      const bool commit = expected.size() == registers::kCommitSize && expected[1] == 0x9A;
      served += commit ? 1 : 0;
    }
  }
  EXPECT_GT(served, 10) << "writes that came to their end";
}

}  // namespace
}  // namespace sinew::emulation
