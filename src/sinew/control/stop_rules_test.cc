#include "sinew/control/stop_rules.h"

#include <gtest/gtest.h>

#include <fstream>
#include <set>
#include <string>

#include "sinew/core/error_code.h"
#include "support/robots.h"

namespace sinew::control {
namespace {

TEST(StopRules, every_cause_has_its_row_and_its_name) {
  std::set<std::string_view> names;
  for (std::size_t i = 0; i < kStopCauses; ++i) {
    const auto cause = static_cast<StopCause>(i);
    EXPECT_EQ(stop_rule(cause).cause, cause);
    EXPECT_TRUE(names.insert(stop_rule(cause).name).second) << stop_rule(cause).name;
  }
}

TEST(StopRules, what_can_go_on_was_braked_on_its_path) {
  for (std::size_t i = 0; i < kStopCauses; ++i) {
    const StopRule& rule = stop_rule(static_cast<StopCause>(i));
    EXPECT_TRUE(rule.after != StopAfter::kHeld || rule.manner == StopManner::kOnPath) << rule.name;
  }
}

TEST(StopRules, a_devices_own_fault_has_the_category_of_its_error) {
  EXPECT_EQ(stop_category(StopCause::kClient, Error{ErrorCode::kEmergencyStop}),
            StopCategory::kStopAndHold);
  for (const ErrorInfo& row : error_table()) {
    EXPECT_EQ(stop_category(StopCause::kDevice, Error{row.code}), row.stop) << row.name;
  }
  EXPECT_EQ(stop_category(StopCause::kDevice, {}), StopCategory::kNone);
}

TEST(StopRules, only_the_bigrobotarm_finishes_its_move) {
  for (const char* id : {"robot-arm-2", "learm", "bigrobotarm", "maxarm", "hexapod"}) {
    const StopFacts facts = test::robot(id).device.settings->stop_facts();
    EXPECT_EQ(facts.ends_motion, std::string_view(id) != "bigrobotarm") << id;
    EXPECT_FALSE(facts.standstill.empty() || facts.falls.empty()) << id;
  }
}

TEST(StopRules, table_of_the_documentation_is_the_one_in_the_code) {
  std::ifstream file(SINEW_DOCS_DIR "/control.md");
  ASSERT_TRUE(file);
  std::set<std::string> documented;
  for (std::string line; std::getline(file, line);) {
    if (line.starts_with("| *")) documented.insert(line);
  }
  std::set<std::string> coded;
  for (std::size_t i = 0; i < kStopCauses; ++i) {
    const StopRule& rule = stop_rule(static_cast<StopCause>(i));
    const char* then = rule.after == StopAfter::kReady  ? "ready"
                       : rule.after == StopAfter::kHeld ? "held"
                                                        : "fault";
    const char* how = rule.manner == StopManner::kOnPath ? "on the path" : "device";
    coded.insert("| *" + std::string(rule.name) + "* | " + how + " | " + then + " |");
  }
  EXPECT_EQ(documented, coded);
}

}  // namespace
}  // namespace sinew::control
