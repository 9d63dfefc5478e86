#include "sinew/devices/arm_link/arm_link_device.h"

#include <gtest/gtest.h>

#include <array>
#include <string>

#include "sinew/devices/bigrobotarm/bigrobotarm_device.h"
#include "sinew/devices/bigrobotarm/bigrobotarm_test_robot.h"
#include "support/board_under_test.h"
#include "support/property.h"

// Our own firmware beside the maker's: what old clients send, and what they get for it.

namespace sinew {
namespace {

using namespace std::chrono_literals;
using Bytes = mcu::Bytes;

/// Both get the same bytes at the same time.
struct SideBySide {
  explicit SideBySide(BigRobotArmWire wire)
      : maker(settings(wire), now, BigRobotArmProfile::kDocument) {}
  static BigRobotArmDevice settings(BigRobotArmWire wire) {
    return test::big_robot_arm(wire, BigRobotArmDialect::k2026)
        .device.settings.get<BigRobotArmDevice>();
  }
  void run(int ms) {
    for (; ms > 0; --ms) {
      now += 1ms;
      maker.advance(now);
      std::array<std::uint8_t, 1024> out{};
      const std::size_t size = maker.take_output(out);
      theirs.insert(theirs.end(), out.begin(), out.begin() + static_cast<std::ptrdiff_t>(size));
    }
  }
  /// Replies of both to a request, until both are silent for long.
  std::pair<std::string, std::string> ask(const Bytes& request, int ms) {
    theirs.clear();
    maker.receive(request, now);
    run(ms);
    Bytes mine = ours.ask(request, ms);
    return {std::string(theirs.begin(), theirs.end()), std::string(mine.begin(), mine.end())};
  }

  Instant now{};
  BigRobotArmFirmware maker;
  mcu::HostBoard ours;
  Bytes theirs;
};

std::string without_free_memory(std::string text) {
  for (std::size_t at = 0; (at = text.find("Free mem: ", at)) != std::string::npos;) {
    text.erase(at, text.find('\n', at) + 1 - at);
  }
  return text;
}

Bytes words(std::uint8_t id, test::Random& random, std::int64_t low, std::int64_t high) {
  Bytes bytes{id};
  for (int i = 0; i < 5; ++i) {
    const auto word = static_cast<std::uint32_t>(random.integer(low, high));
    for (int shift = 0; shift < 32; shift += 8) {
      bytes.push_back(static_cast<std::uint8_t>(word >> shift));
    }
  }
  bytes.push_back(0x0D);
  return bytes;
}

TEST(ArmLinkBoard, replies_to_bytes_as_the_document_has_it) {
  test::for_random_cases(60, [](test::Random& random) {
    SideBySide both(BigRobotArmWire::kByte);
    for (int k = 0; k < 8; ++k) {
      Bytes request;
      int ms = 60;
      switch (random.integer(0, 8)) {
        case 0:
          request = words(1, random, -150, 150);
          ms = 2500;
          break;
        case 1:
          request = {2, 0x0D};
          ms = 2500;
          break;
        case 2:
          request = {3, 0x0D};
          break;
        case 3:
          request = words(4, random, 50, 300);
          break;
        case 4:
          request = words(5, random, 50, 300);
          break;
        case 5:
          request = {6, static_cast<std::uint8_t>(random.integer(0, 1)),
                     static_cast<std::uint8_t>(random.integer(0, 180)), 0x0D};
          break;
        case 6:
          request = {7, static_cast<std::uint8_t>(random.integer(0, 2)), 0x0D};
          break;
        case 7:
          request = {static_cast<std::uint8_t>(random.integer(14, 64)), 7, 0x0D};
          break;
        default:
          request = {8, 0x0D};
          break;
      }
      const auto [theirs, mine] = both.ask(request, ms);
      ASSERT_FALSE(theirs.empty());
      ASSERT_EQ(theirs, mine) << "request " << int{request[0]};
    }
  });
}

TEST(ArmLinkBoard, replies_to_text_as_the_firmware_of_2026_does) {
  test::for_random_cases(60, [](test::Random& random) {
    SideBySide both(BigRobotArmWire::kText);
    const auto number = [&](std::int64_t low, std::int64_t high) {
      return std::to_string(random.integer(low, high));
    };
    for (int k = 0; k < 8; ++k) {
      std::string line;
      int ms = 60;
      switch (random.integer(0, 10)) {
        case 0:
          line = "G0 B" + number(-99, 99) + " S" + number(-50, 50) + " E" + number(-99, 99);
          ms = 2500;
          break;
        case 1:
          line = "G28";
          ms = 2500;
          break;
        case 2:
          line = "G92";
          break;
        case 3:
          line = "M203 B" + number(20, 600) + " S" + number(50, 300);
          break;
        case 4:
          line = "M201 B100 S100 E" + number(50, 600) + "  WR" + number(50, 90) + " W77 G40";
          break;
        case 5:
          line = "G1 E" + number(0, 1) + " P" + number(0, 180);
          break;
        case 6:
          line = "S" + number(0, 1);
          break;
        case 7:
          line = random.chance(0.5) ? "END" : "QCLEAR now";
          break;
        case 8:
          line = random.chance(0.5) ? "QFLUSH" : "G00";
          ms = 500;
          break;
        case 9:
          line = random.chance(0.5) ? "hello" : "";
          break;
        default:
          line = "M503";
          break;
      }
      // An empty first line does not say which wire it is.
      if (k == 0 && line.empty()) line = "M503";
      line += '\r';
      const auto [theirs, mine] = both.ask(mcu::bytes_of(line), ms);
      ASSERT_FALSE(theirs.empty()) << line;
      ASSERT_EQ(without_free_memory(theirs), without_free_memory(mine)) << line;
    }
  });
}

TEST(ArmLinkBoard, a_goto_takes_as_long_as_the_documents_trapezoids) {
  SideBySide both(BigRobotArmWire::kByte);
  test::Random random(3);
  for (int k = 0; k < 6; ++k) {
    const Bytes request = words(1, random, -900, 900);
    both.theirs.clear();
    both.maker.receive(request, both.now);
    int theirs = 0;
    for (; both.theirs.size() < 28 && theirs < 20'000; ++theirs) both.run(1);
    Bytes mine;
    both.ours.take_output();
    both.ours.send(request);
    int ours = 0;
    for (; mine.size() < 28 && ours < 20'000; ++ours) {
      both.ours.run_ms(1);
      const Bytes more = both.ours.take_output();
      mine.insert(mine.end(), more.begin(), more.end());
    }
    EXPECT_NEAR(ours, theirs, 5 + theirs / 100) << k;
    EXPECT_EQ(mine, both.theirs);
  }
}

}  // namespace
}  // namespace sinew
