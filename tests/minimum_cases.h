#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <string_view>

namespace sinew::house {

/// A GoogleTest program and the number of tests that it must at least run.
struct MinimumTests {
  std::string_view program;
  std::size_t tests = 0;
};

/// A property test and the number of random cases that it must at least run.
struct MinimumCases {
  std::string_view program;
  std::string_view test;  ///< Suite.name
  std::uint64_t cases = 0;
};

// A test that quietly stops running is worse than one that fails. `build/release/case_counts
// --table` prints what ran in the form of these rows; a new program or property without a row
// fails the full run. The rows of the properties stand in minimum_cases.inc.

inline constexpr std::array kMinimumTests = std::to_array<MinimumTests>({
    {"axis_link_test", 87},
    {"axis_registers_test", 94},
    {"axis_test", 169},
    {"bigrobotarm_test", 219},
    {"calibration_test", 49},
    {"cli_test", 255},
    {"config_test", 76},
    {"control_test", 132},
    {"core_test", 27},
    {"crash_test", 12},
    {"cubes_test", 4},
    {"devices_test", 12},
    {"documents_test", 30},
    {"driver_test", 5},
    {"encoder_test", 49},
    {"faults_test", 49},
    {"grasping_test", 5},
    {"feetech_test", 65},
    {"grbl_test", 95},
    {"house_test", 40},
    {"icp_test", 132},
    {"ideal_test", 41},
    {"io_test", 99},
    {"kinematics_test", 181},
    {"lsc_test", 101},
    {"maxarm_test", 57},
    {"motion_test", 110},
    {"outside_test", 18},
    {"planning_test", 406},
    {"program_test", 244},
    {"render_test", 19},
    {"runtime_test", 192},
    {"sequences_test", 15},
    {"server_test", 127},
    {"sim_test", 117},
    {"step_allocations_test", 7},
    {"stop_latency_test", 11},
    {"supply_test", 3},
    {"system_test", 4},
    {"toml_test", 24},
    {"vision_test", 81},
    {"web_test", 11},
    {"wire_test", 14},
    {"firmware_test", 46},
    {"mcu_test", 43},
    {"mega_test", 32},
    {"arduino_test", 53},
    {"arduino_sketch_test", 10},
    {"arm_link_test", 32},
    {"mega_run_test", 5},
    {"encoder_image_test", 12},
    {"stm32_run_test", 1},
});

inline constexpr std::array kMinimumCases = std::to_array<MinimumCases>({
#include "minimum_cases.inc"
});

}  // namespace sinew::house
