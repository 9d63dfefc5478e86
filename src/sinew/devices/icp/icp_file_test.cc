#include <gtest/gtest.h>

#include <algorithm>
#include <string>

#include "sinew/config/builtin_robots.h"
#include "sinew/config/robot_file.h"
#include "sinew/devices/icp/icp_settings.h"

namespace sinew {
namespace {

using namespace std::chrono_literals;

constexpr std::string_view kSimulated = R"(
  [device.simulated]
  knows_wake = "no"
  checks_selector = "yes"
  bit_one_is_plus = "yes"
  minus_one = "FFFE"
  silent_without_motor = "yes"
  ack_without_module = "yes"
  processing_ms = 7
  boot_ms = 1500
  idle_shutdown_s = 600
  source = "s"
)";

/// The built-in platform with these lines in its [device].
std::string with(std::string_view lines) {
  std::string text(std::ranges::find(builtin_robots(), "hexapod", &BuiltinRobot::id)->text);
  text.insert(text.find("  [device.joint.leg1]"), lines);
  return text;
}

std::string complaint(std::string_view from, std::string_view to) {
  std::string lines(kSimulated);
  lines.replace(lines.find(from), from.size(), to);
  const auto model = read_robot(with(lines), "r.toml");
  if (model) return "none";
  return model.error().size() == 1 ? to_text(model.error()[0]) : "several";
}

TEST(ReadIcp, what_the_simulated_controller_makes_of_the_document_is_read) {
  const auto model = read_robot(with(kSimulated), "r.toml");
  ASSERT_TRUE(model) << to_text(model.error()[0]);
  const IcpFirmware expected{.knows_wake = false,
                             .checks_selector = true,
                             .bit_one_is_plus = true,
                             .minus_one_is_fffe = true,
                             .silent_without_motor = true,
                             .ack_without_module = true,
                             .processing = 7ms,
                             .boot = 1500ms,
                             .idle_shutdown = 10min};
  EXPECT_EQ(model->device.settings.get<IcpDevice>().firmware, expected);
}

TEST(ReadIcp, without_its_table_it_is_what_a_host_expects) {
  const auto model = read_robot(with(""), "r.toml");
  ASSERT_TRUE(model);
  EXPECT_EQ(model->device.settings.get<IcpDevice>().firmware, IcpFirmware{});
}

TEST(ReadIcp, its_table_is_as_strict_as_all_others) {
  const auto has = [](const std::string& text, std::string_view words) {
    return text.find(words) != std::string::npos;
  };
  EXPECT_TRUE(has(complaint("boot_ms = 1500\n", ""), "boot_ms")) << "missing";
  EXPECT_TRUE(has(complaint("boot_ms = 1500", "boot_s = 2"), "boot_s")) << "unknown";
  EXPECT_TRUE(has(complaint("processing_ms = 7", "processing_ms = -1"), "processing_ms"));
  EXPECT_TRUE(has(complaint("processing_ms = 7", "processing_ms = 1001"), "processing_ms"));
  EXPECT_TRUE(has(complaint("\"FFFE\"", "\"FFFD\""), "must be `FFFF` or `FFFE`"));
  EXPECT_TRUE(has(complaint("knows_wake = \"no\"", "knows_wake = false"), "knows_wake"));
  EXPECT_TRUE(has(complaint("  source = \"s\"\n", ""), "source"));
}

TEST(ReadIcp, how_far_a_leg_is_moved_blindly_is_bounded) {
  const auto& platform = std::ranges::find(builtin_robots(), "hexapod", &BuiltinRobot::id)->text;
  const auto changed = [&](std::string_view to) {
    constexpr std::string_view kFrom = "nudge_mm_max = 0.5 ";
    std::string text(platform);
    const std::size_t at = text.find(kFrom);
    EXPECT_NE(at, std::string::npos);
    text.replace(at, kFrom.size(), to);
    return read_robot(text, "r.toml");
  };
  EXPECT_DOUBLE_EQ(changed("nudge_mm_max = 0.5 ")->device.capability.nudge_max, 0.5e-3);
  for (const char* wrong : {"", "nudge_mm_max = 1.1", "nudge_mm_max = 0", "nudge_mm_max = -0.1",
                            "nudge_mm_max = nan", "nudge_deg_max = 1"}) {
    EXPECT_FALSE(changed(wrong)) << wrong;
  }
}

}  // namespace
}  // namespace sinew
