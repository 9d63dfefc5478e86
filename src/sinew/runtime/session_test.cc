#include <gtest/gtest.h>

#include <atomic>
#include <optional>
#include <sstream>
#include <thread>

#include "sinew/io/scratch_folder_test_support.h"
#include "sinew/runtime/machine_server.h"
#include "sinew/runtime/sequence_session.h"
#include "sinew/sim/bigrobotarm_machine.h"
#include "support/robots.h"

/// Device server and session, each over its end of a real pseudo-terminal, time fifty times faster.
namespace sinew::runtime {
namespace {

using namespace std::chrono_literals;
using Bytes = std::vector<std::uint8_t>;
using Phase = sequence::Run::Phase;

constexpr double kScale = 50;

RobotModel arm(BigRobotArmWire wire) {
  RobotModel model = test::robot("bigrobotarm");
  std::get<BigRobotArmDevice>(model.device.settings).wire = wire;
  return model;
}
const BigRobotArmDevice& device_of(const RobotModel& model) {
  return std::get<BigRobotArmDevice>(model.device.settings);
}

/// Delays of this machine do not shrink with the scale.
BigRobotArmTiming patient() {
  BigRobotArmTiming timing;
  timing.reply_timeout = 100s;
  timing.move_margin = 200s;
  return timing;
}

/// The simulated arm in a thread of its own.
class Arm {
 public:
  Arm(const RobotModel& model, const io::Clock& clock, const std::string& log_path = "")
      : machine_(model, BigRobotArmProfile::kDocument, BigRobotArmDialect::k2021, 1, clock.now()) {
    auto port = io::Port::open_pseudo_terminal();
    if (!port) throw std::runtime_error(port.error().sentence);
    path_ = port->path();
    if (!log_path.empty()) log_ = std::move(*ByteLog::create(log_path));
    thread_ = std::thread([this, clock, port = std::move(*port)]() mutable {
      const auto served =
          serve_machine(machine_, port, clock, {.baud = 250'000, .faults = {}}, log_,
                        {.stop = [this] { return stop_.load(); }, .look = {}});
      if (!served) sentence_ = served.error().sentence;
    });
  }
  ~Arm() { end(); }
  Arm(const Arm&) = delete;
  Arm& operator=(const Arm&) = delete;

  /// Stops serving, closes its side of the port; why it ended by itself, if it did.
  std::string end() {
    stop_ = true;
    if (thread_.joinable()) thread_.join();
    return sentence_;
  }
  const std::string& path() const { return path_; }
  /// After end() only.
  sim::Truth truth() const { return machine_.truth(); }

 private:
  sim::BigRobotArmMachine machine_;
  ByteLog log_;
  std::string path_;
  std::string sentence_;
  std::atomic<bool> stop_ = false;
  std::thread thread_;
};

/// Exactly there as the device believes; in truth up to two full steps of a motor beside it.
void expect_stands_at(const sim::Truth& truth, const BigRobotArmDevice& device,
                      const std::array<double, 5>& steps) {
  for (std::size_t i = 0; i < steps.size(); ++i) {
    const double steps_per_rad = device.joints[i].steps_per_rad;
    EXPECT_NEAR(truth.joints[i].believed, steps[i] / steps_per_rad, 1e-9) << i;
    const double full_step = device.joints[i].steps_per_motor_rev / 200 / std::abs(steps_per_rad);
    EXPECT_NEAR(truth.joints[i].q, steps[i] / steps_per_rad, 2.5 * full_step) << i;
  }
}

/// What a test sees of a session that is over.
struct Result {
  SessionEnd end;
  Phase phase{};
  std::vector<sequence::Record> records;
  std::optional<sequence::PlanRefusal> failure;
  double predicted = 0;
};

class Session {
 public:
  Session(std::string_view text, const RobotModel& model, const io::Clock& clock)
      : model_(model),
        clock_(clock),
        program_(*sequence::parse(text, "f", device_of(model))),
        driver_(device_of(model), patient()),
        run_(program_, model_, driver_, 300s) {}

  Result over(const std::string& path, const SessionHooks& hooks = {},
              const std::string& log_path = "") {
    auto port = io::Port::open_serial(path, 250'000);
    if (!port) throw std::runtime_error(port.error().sentence);
    ByteLog log;
    if (!log_path.empty()) log = std::move(*ByteLog::create(log_path));
    Result result;
    result.end = run_sequence(run_, driver_, *port, clock_, log, hooks);
    result.phase = run_.phase();
    result.records.assign(run_.records().begin(), run_.records().end());
    result.failure = run_.failure();
    result.predicted = run_.plan().duration;
    return result;
  }

 private:
  const RobotModel& model_;
  const io::Clock& clock_;
  sequence::Program program_;
  BigRobotArmDriver driver_;
  sequence::Run run_;
};

constexpr std::string_view kTwoMoves = "G0 B100 S200 E300 WR400 W300\nG0 B0 S50 E2000 WR700 W0\n";

class EitherWire : public ::testing::TestWithParam<BigRobotArmWire> {};
INSTANTIATE_TEST_SUITE_P(Wires, EitherWire,
                         ::testing::Values(BigRobotArmWire::kByte, BigRobotArmWire::kText),
                         [](const auto& parameter) {
                           return parameter.param == BigRobotArmWire::kByte ? "byte" : "text";
                         });

TEST_P(EitherWire, program_runs_to_its_end_and_the_arm_stands_where_it_was_sent) {
  const RobotModel model = arm(GetParam());
  const io::Clock clock(kScale);
  Arm device(model, clock);
  const Result result = Session(kTwoMoves, model, clock).over(device.path());
  EXPECT_EQ(device.end(), "");
  ASSERT_EQ(result.phase, Phase::kDone);
  EXPECT_FALSE(result.end.port_failure);
  EXPECT_FALSE(result.end.left_at_once);
  ASSERT_EQ(result.records.size(), 2U);
  EXPECT_EQ(device.truth().bytes_lost, 0U);
  expect_stands_at(device.truth(), device_of(model), {0, 50, 2000, 700, 0});
  const double took = to_seconds(result.records[1].done - result.records[0].asked);
  EXPECT_GE(took, result.predicted - 1e-6);
  // Threads that hand over late are late by milliseconds, which count fifty-fold here.
  EXPECT_LT(took, result.predicted + 500);
}

TEST(Session, bytes_are_counted_by_order_and_in_total) {
  const RobotModel model = arm(BigRobotArmWire::kByte);
  const io::Clock clock(kScale);
  const Arm device(model, clock);
  const Result result = Session("G0 B100\nG1 E1 P40\nG92\n", model, clock).over(device.path());
  ASSERT_EQ(result.phase, Phase::kDone);
  ASSERT_EQ(result.end.bytes.size(), 3U);
  EXPECT_EQ(result.end.bytes[0].to_device, 22U);
  EXPECT_EQ(result.end.bytes[0].to_host, 28U);
  EXPECT_EQ(result.end.bytes[1].to_device, 4U);
  EXPECT_EQ(result.end.bytes[1].to_host, 10U);
  EXPECT_EQ(result.end.bytes[2].to_device, 2U);
  EXPECT_EQ(result.end.bytes[2].to_host, 28U);
  // The status, which belongs to no order, comes first.
  EXPECT_EQ(result.end.total.to_device, 2U + 22 + 4 + 2);
  EXPECT_EQ(result.end.total.to_host, 71U + 28 + 10 + 28);
}

struct LogRow {
  double seconds = 0;
  bool to_device = false;
  std::string hex;  ///< "47 31 "
  std::string text;
};

/// "    0.004512  host -> device  47 31  G1"; a failure where it looks different.
LogRow row_of(const std::string& line) {
  constexpr std::string_view kOut = "  host -> device  ";
  constexpr std::string_view kIn = "  device -> host  ";
  LogRow row;
  row.to_device = line.find(kOut) == 12;
  EXPECT_TRUE(row.to_device || line.find(kIn) == 12) << line;
  row.seconds = std::stod(line.substr(0, 12));
  const std::size_t begin = 12 + kOut.size();
  const std::size_t end = line.find("  ", begin);
  EXPECT_NE(end, std::string::npos) << line;
  row.hex = line.substr(begin, end + 1 - begin);
  row.text = line.substr(end + 2);
  EXPECT_EQ(row.hex.find_first_not_of("0123456789abcdef "), std::string::npos) << line;
  EXPECT_EQ(row.hex.size(), 3 * row.text.size()) << line;
  return row;
}

TEST(Session, both_logs_hold_every_byte_with_time_direction_and_text) {
  const test::ScratchFolder folder;
  const RobotModel model = arm(BigRobotArmWire::kText);
  const io::Clock clock(kScale);
  Arm device(model, clock, folder.at("device"));
  const Result result =
      Session("G1 E1 P40\n", model, clock).over(device.path(), {}, folder.at("host"));
  ASSERT_EQ(result.phase, Phase::kDone);
  device.end();
  std::array<std::array<std::string, 2>, 2> said;
  for (const std::size_t side : {0U, 1U}) {
    std::stringstream lines(test::text_of(folder.at(side == 0 ? "host" : "device")));
    std::string line;
    std::getline(lines, line);
    EXPECT_EQ(line, "# seconds  direction  bytes (hex)  text");
    double last = 0;
    while (std::getline(lines, line)) {
      const LogRow row = row_of(line);
      EXPECT_GE(row.seconds, last) << line;
      last = row.seconds;
      said[side][row.to_device ? 0 : 1] += row.hex;
    }
  }
  EXPECT_EQ(said[0], said[1]);
  EXPECT_EQ(said[0][0].size(), 3 * result.end.total.to_device);
  EXPECT_EQ(said[0][1].size(), 3 * result.end.total.to_host);
  EXPECT_NE(said[0][0].find("47 31 20 45 31 20 50 34 30 0d"), std::string::npos);
}

TEST(Session, log_without_room_says_so_and_the_run_goes_on) {
  const RobotModel model = arm(BigRobotArmWire::kByte);
  const io::Clock clock(kScale);
  const Arm device(model, clock);
  auto log = ByteLog::create("/dev/full");
  ASSERT_TRUE(log);
  ASSERT_TRUE(log->failure());
  EXPECT_EQ(log->failure()->sentence, "/dev/full: no space left on device");
  EXPECT_FALSE(ByteLog().failure());
  const Result result = Session("G0 B10\n", model, clock).over(device.path(), {}, "/dev/full");
  EXPECT_EQ(result.phase, Phase::kDone);
}

TEST(Session, first_interrupt_finishes_the_motion_under_way) {
  const RobotModel model = arm(BigRobotArmWire::kByte);
  const io::Clock clock(kScale);
  Arm device(model, clock);
  bool moving = false;
  const SessionHooks hooks{.progress =
                               [&](const SessionView& view) {
                                 const auto record = view.run.under_way();
                                 moving = moving || (record && record->started != record->asked);
                               },
                           .interrupts = [&] { return moving ? 1 : 0; }};
  const Result result = Session(kTwoMoves, model, clock).over(device.path(), hooks);
  device.end();
  EXPECT_EQ(result.phase, Phase::kStopped);
  EXPECT_FALSE(result.end.left_at_once);
  ASSERT_EQ(result.records.size(), 1U);
  EXPECT_EQ(result.end.bytes.size(), 1U);
  expect_stands_at(device.truth(), device_of(model), {100, 200, 300, 400, 300});
}

TEST(Session, second_interrupt_leaves_at_once) {
  const RobotModel model = arm(BigRobotArmWire::kByte);
  const io::Clock clock;
  const Arm device(model, clock);
  bool moving = false;
  int asked = 0;
  const SessionHooks hooks{.progress =
                               [&](const SessionView& view) {
                                 const auto record = view.run.under_way();
                                 moving = moving || (record && record->order->line == 2);
                               },
                           .interrupts = [&] { return moving ? ++asked : 0; }};
  const auto start = std::chrono::steady_clock::now();
  // Three minutes of motion: leaving must not wait for its end.
  const Result result = Session("M203 B1\nG0 B6000\n", model, clock).over(device.path(), hooks);
  EXPECT_TRUE(result.end.left_at_once);
  EXPECT_EQ(result.phase, Phase::kStopping);
  EXPECT_EQ(result.records.size(), 1U);
  EXPECT_LT(std::chrono::steady_clock::now() - start, 2s);
}

TEST(Session, port_that_closes_in_a_motion_leaves_the_records_that_there_are) {
  const RobotModel model = arm(BigRobotArmWire::kByte);
  const io::Clock clock(kScale);
  std::optional<Arm> device(std::in_place, model, clock);
  const std::string path = device->path();
  const SessionHooks hooks{.progress =
                               [&](const SessionView& view) {
                                 const auto record = view.run.under_way();
                                 if (record && record->order->line == 2) device.reset();
                               },
                           .interrupts = {}};
  const Result result = Session(kTwoMoves, model, clock).over(path, hooks);
  EXPECT_EQ(result.phase, Phase::kFailed);
  ASSERT_TRUE(result.end.port_failure);
  EXPECT_EQ(result.end.port_failure->sentence, path + ": the other side closed the port");
  ASSERT_TRUE(result.failure);
  EXPECT_EQ(result.failure->error.code, ErrorCode::kPortClosed);
  EXPECT_EQ(result.failure->line, 2);
  EXPECT_EQ(result.records.size(), 1U);
  EXPECT_EQ(result.end.bytes.size(), 1U);
}

TEST(Session, port_that_closes_before_the_device_answered_ends_it_at_once) {
  const RobotModel model = arm(BigRobotArmWire::kByte);
  const io::Clock clock;
  std::optional<Arm> device(std::in_place, model, clock);
  const std::string path = device->path();
  const SessionHooks hooks{.progress = [&](const SessionView&) { device.reset(); },
                           .interrupts = {}};
  const auto start = std::chrono::steady_clock::now();
  const Result result = Session(kTwoMoves, model, clock).over(path, hooks);
  EXPECT_EQ(result.phase, Phase::kFailed);
  EXPECT_TRUE(result.end.port_failure);
  EXPECT_LT(std::chrono::steady_clock::now() - start, 2s);
}

TEST(Session, device_that_is_silent_is_told_with_the_time_it_was_given) {
  const RobotModel model = arm(BigRobotArmWire::kByte);
  const io::Clock clock(kScale);
  auto nobody = io::Port::open_pseudo_terminal();
  ASSERT_TRUE(nobody);
  const auto program = sequence::parse(kTwoMoves, "f", device_of(model));
  BigRobotArmDriver driver(device_of(model));
  sequence::Run run(*program, model, driver);
  auto port = io::Port::open_serial(nobody->path(), 250'000);
  ByteLog log;
  const SessionEnd end = run_sequence(run, driver, *port, clock, log, {});
  EXPECT_EQ(run.phase(), Phase::kFailed);
  EXPECT_FALSE(end.port_failure);
  EXPECT_EQ(run.failure()->error.code, ErrorCode::kDeviceSilent);
  EXPECT_EQ(run.failure()->error.limit, 6);
  EXPECT_EQ(end.total.to_host, 0U);
  EXPECT_GT(end.total.to_device, 2U);  // it asked more than once
}

/// A host of its own, without our driver.
Bytes exchange(io::Port& port, const Bytes& request, std::size_t reply) {
  EXPECT_TRUE(port.write(request));
  Bytes bytes;
  std::array<std::uint8_t, 256> buffer{};
  while (bytes.size() < reply) {
    const auto size = port.read(buffer, 2s);
    if (!size || *size == 0) break;
    bytes.insert(bytes.end(), buffer.begin(), buffer.begin() + static_cast<long>(*size));
  }
  return bytes;
}

TEST(DeviceServer, device_is_deaf_in_its_motion_and_answers_after_it) {
  const RobotModel model = arm(BigRobotArmWire::kByte);
  const io::Clock clock(kScale);
  const Arm device(model, clock);
  auto port = io::Port::open_serial(device.path(), 250'000);
  ASSERT_TRUE(port);
  const Bytes go{1, 0x88, 0x13, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 13};
  const Bytes started = exchange(*port, go, 3);
  ASSERT_GE(started.size(), 3U);
  EXPECT_EQ(Bytes(started.begin(), started.begin() + 3), (Bytes{1, 13, 10}));
  Bytes rest = exchange(*port, {8, 13}, 28 + 71 - started.size());
  rest.insert(rest.begin(), started.begin(), started.end());
  ASSERT_EQ(rest.size(), 28U + 71);
  EXPECT_EQ(rest[3], 0x88);
  EXPECT_EQ(rest[28], 0xCA);
}

TEST(DeviceServer, host_that_asks_and_never_reads_does_not_hold_the_device_up) {
  const RobotModel model = arm(BigRobotArmWire::kByte);
  const io::Clock clock(kScale);
  Arm device(model, clock);
  {
    auto rude = io::Port::open_serial(device.path(), 250'000);
    ASSERT_TRUE(rude);
    for (int i = 0; i < 400; ++i) {
      ASSERT_TRUE(rude->write(Bytes{8, 13}));
    }
  }
  auto port = io::Port::open_serial(device.path(), 250'000);
  ASSERT_TRUE(port);
  // What was still on its way comes first; then the device answers as ever.
  std::array<std::uint8_t, 4096> buffer{};
  while (*port->read(buffer, 300ms) > 0) {
  }
  const Bytes status = exchange(*port, {8, 13}, 71);
  ASSERT_EQ(status.size(), 71U);
  EXPECT_EQ(status[0], 0xCA);
  EXPECT_EQ(device.end(), "");
}

TEST(DeviceServer, hosts_come_and_go) {
  const RobotModel model = arm(BigRobotArmWire::kByte);
  const io::Clock clock(kScale);
  Arm device(model, clock);
  for (int i = 0; i < 30; ++i) {
    auto port = io::Port::open_serial(device.path(), 250'000);
    ASSERT_TRUE(port) << port.error().sentence;
    EXPECT_EQ(exchange(*port, {8, 13}, 71).size(), 71U);
  }
  EXPECT_EQ(device.end(), "");
}

}  // namespace
}  // namespace sinew::runtime
