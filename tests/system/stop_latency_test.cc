#include <gtest/gtest.h>

#include <algorithm>
#include <cstdint>
#include <cstdio>
#include <iostream>
#include <optional>
#include <string>
#include <vector>

#include "sinew/control/stop_rules.h"
#include "sinew/core/units.h"
#include "sinew/runtime/links/robot_variant.h"
#include "support/how_many.h"
#include "support/robots.h"
#include "system/stop_range.h"

namespace sinew::test {
namespace {

using namespace std::chrono_literals;

/// How a wire stops.
enum class Manner {
  kFrame,        ///< a frame that stops, behind the one in transmission
  kTransaction,  ///< the same; its frame is a transaction of several exchanges
  kAsks,         ///< the same behind a question: where it is first
  kSilence,      ///< no further step
  kNone,         ///< the device finishes its move
};

struct StopWire {
  const char* robot;
  const char* profile;  ///< null: its default
  const char* wire;     ///< the same
  Manner manner;
  Duration first_byte_max;  ///< from the request
  Duration standstill_max;  ///< the same
};

constexpr StopWire kWires[] = {
    {"robot-arm-2", nullptr, "registers", Manner::kTransaction, 120ms, 300ms},
    {"robot-arm-2", nullptr, "link", Manner::kFrame, 6ms, 4100ms},
    {"learm", "lsc6", nullptr, Manner::kFrame, 32ms, 400ms},
    {"learm", "bus", nullptr, Manner::kFrame, 32ms, 400ms},
    {"learm", "esp32", nullptr, Manner::kFrame, 32ms, 400ms},
    {"bigrobotarm", "document", "byte", Manner::kNone, 0ms, 0ms},
    {"bigrobotarm", "document", "text", Manner::kNone, 0ms, 0ms},
    {"bigrobotarm", "sinew", "framed", Manner::kFrame, 6ms, 1200ms},
    {"maxarm", "arduino", nullptr, Manner::kAsks, 600ms, 900ms},
    {"maxarm", "micropython", nullptr, Manner::kAsks, 600ms, 900ms},
    {"hexapod", nullptr, nullptr, Manner::kSilence, 0ms, 20ms},
};
/// The bound of every wire: two control cycles behind the frame in transmission.
constexpr Duration kBehindMax = 2 * StopRange::kCycle;
/// What the boards of the register wire need between two transactions.
constexpr Duration kTransactionPause = 10ms;

void PrintTo(const StopWire& wire, std::ostream* out) {
  *out << wire.robot;
}

std::string title(const StopWire& wire) {
  std::string text = wire.robot;
  if (wire.wire != nullptr) text += std::string("_") + wire.wire;
  if (wire.profile != nullptr) text += std::string("_") + wire.profile;
  std::ranges::replace(text, '-', '_');
  return text;
}

class StopLatency : public testing::TestWithParam<StopWire> {};

double ms(Duration duration) {
  return to_seconds(duration) * 1e3;
}

/// "1.2 / 3.4"
std::string median_and_worst(std::vector<Duration> all) {
  if (all.empty()) return "-";
  std::ranges::sort(all);
  char text[64];
  std::snprintf(text, sizeof text, "%.1f / %.1f", ms(all[all.size() / 2]), ms(all.back()));
  return text;
}

/// What one stop has to be on this wire.
void judge(const StopShot& shot, const StopWire& wire, const StopFacts& facts) {
  EXPECT_EQ(shot.moved_on, 0);
  const bool says_so = wire.manner != Manner::kSilence && wire.manner != Manner::kNone;
  ASSERT_EQ(shot.first_byte.has_value(), says_so);
  if (says_so) {
    EXPECT_LE(*shot.first_byte, wire.first_byte_max) << ms(*shot.first_byte);
  }
  if (wire.manner == Manner::kFrame) {
    EXPECT_LE(shot.behind_wire, kBehindMax);
  } else if (wire.manner == Manner::kTransaction) {
    EXPECT_LE(shot.behind_last, kTransactionPause + kBehindMax);
  }
  EXPECT_EQ(facts.ends_motion, wire.manner != Manner::kNone);
  if (facts.ends_motion) {
    EXPECT_LE(shot.standstill, wire.standstill_max) << ms(shot.standstill);
    // What the driver says is a bound of what the machine does.
    if (shot.goes_on) {
      EXPECT_LE(shot.standstill, *shot.goes_on) << ms(*shot.goes_on);
    }
  } else {
    EXPECT_LE(shot.short_of_target, from_deg(1)) << "it did not finish its move";
  }
}

std::uint64_t shots_of(const RobotModel& robot) {
  // Six axes at 1 kHz take a hundred times as long as a board of servos.
  const bool boards = !boards_of(robot.device).empty();
  return how_many("SINEW_STOPS", boards ? 40 : 300, boards ? 3 : 30);
}

TEST_P(StopLatency, a_stop_leaves_behind_the_frame_in_transmission) {
  const StopWire& wire = GetParam();
  const auto name_or_none = [](const char* name) {
    return name == nullptr ? std::optional<std::string>() : std::optional<std::string>(name);
  };
  auto robot = runtime::variant_of(test::robot(wire.robot), name_or_none(wire.profile),
                                   name_or_none(wire.wire));
  ASSERT_TRUE(robot) << robot.error();
  // Where homing leaves an arm few ways are free; what it may hit is no matter of stopping.
  robot->collision = {};
  const StopFacts facts = robot->device.settings->stop_facts();
  StopRange range(*robot, name_or_none(wire.profile), seed());
  range.prepare();
  std::vector<Duration> first_bytes;
  std::vector<Duration> behind;
  std::vector<Duration> standstills;
  for (std::uint64_t k = 0; k < shots_of(*robot) && !HasFailure(); ++k) {
    const StopShot shot = range.shoot();
    if (HasFailure()) return;
    judge(shot, wire, facts);
    standstills.push_back(shot.standstill);
    if (!shot.first_byte) continue;
    first_bytes.push_back(*shot.first_byte);
    behind.push_back(wire.manner == Manner::kTransaction ? shot.behind_last : shot.behind_wire);
  }
  if (standstills.empty()) return;
  std::cout << "  " << title(wire) << ", " << standstills.size()
            << " stops, median / worst: first byte " << median_and_worst(first_bytes)
            << ", behind the wire " << median_and_worst(behind) << ", standstill "
            << median_and_worst(standstills) << " ms\n";
  RecordProperty("cases", std::to_string(standstills.size()));
}

INSTANTIATE_TEST_SUITE_P(EachWire, StopLatency, testing::ValuesIn(kWires),
                         [](const auto& wire) { return title(wire.param); });

}  // namespace
}  // namespace sinew::test
