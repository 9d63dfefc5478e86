#include "bench/ratio_reporter.h"

#include <array>
#include <cstdio>
#include <string_view>

namespace sinew::bench {
namespace {

/// One row of the table; `goal` is a ratio to the yardstick, 0 where there is none.
struct Row {
  std::string_view name;
  std::string_view work;
  double goal = 0;
};

constexpr auto kRows = std::to_array<Row>({
    {kYardstick, "KDL: forward, 6R"},
    {"kdl/jacobian_6r", "KDL: Jacobian alone, 6R"},
    {"kdl/inverse_lma_near", "KDL: inverse LMA, near start"},
    {"kdl/inverse_lma_far", "KDL: inverse LMA, far start"},
    {"kdl/trapezoid_6_axes", "KDL: trapezoid of 6 axes (no jerk)"},
    {"forward_6r", "forward, 6R", 0.11},
    {"forward_6r_portable", "forward, 6R, without wide vectors", 0.23},
    {"forward_and_jacobian_6r", "forward and Jacobian, 6R", 0.34},
    {"inverse_6r_all_branches", "inverse, 6R, all 8 branches", 0.38},
    {"inverse_6r_portable", "inverse, 6R, without wide vectors", 1.07},
    {"inverse_5r_pitch", "inverse, 5R with pitch, all branches"},
    {"inverse_5r_roll", "inverse, 5R with rolling forearm, all branches"},
    {"inverse_numeric_near", "inverse, numeric, near start", 2.8},
    {"inverse_numeric_far", "inverse, numeric, far start", 11},
    {"inverse_palletizer", "inverse, palletizer"},
    {"hexapod_inverse", "hexapod inverse", 0.06},
    {"hexapod_forward_warm", "hexapod forward, warm start", 0.94},
    {"hexapod_forward_cold", "hexapod forward, cold start", 1.5},
    {"rest_to_rest_6_axes", "rest to rest, 6 axes together", 0.94},
    {"state_to_state_6_axes", "state to state, 6 joints with v and a", 7.5},
    {"state_to_state_6_axes_p99", "state to state, 99 of 100 inputs", 15},
    {"state_to_state_6_axes_worst", "state to state, worst of 4096 inputs", 38},
    {"velocity_retarget_6_axes", "velocity retarget, 6 joints"},
    {"sample_state_to_state_6_axes", "sampling state to state, 6 joints"},
    {"sample_6_axes", "sampling q, qd, qdd of 6 axes", 0.05},
    {"steps_compressed", "steps of moves, compressed and checked, a step", 0.023},
    {"steps_compressed_spline", "steps of a 10 ms spline, likewise, a step", 0.023},
    {"steps_timed", "steps timed to a tick by the axis' integers, a step"},
    {"collision_distance_6r", "collision: least distance, 6R, 29 pairs"},
    {"collision_line_6r", "collision: line of 300 mm checked, 6R"},
    {"collision_jog_6r", "collision: speed left to a jog, 6R"},
    {"collision_distance_hexapod", "collision: least distance at given legs, hexapod"},
    {"path_timing_100_pieces", "path timing with jerk, 6 joints, 100 pieces", 113},
    {"path_timing_changeable_100_pieces", "the same, of a law that can be changed on the way", 113},
    {"planned_line_300mm_6r", "line of 300 mm, 6R: made, contact checked, timed", 3760},
    {"path_replan_100_pieces", "that from a moving state, another feed"},
    {"trajectory_sample_6_joints", "sampling a timed path of 6 joints"},
    {"jog_retarget_tool_6r", "jog: a cycle with a new command, tool of a 6R", 9.4},
    {"jog_retarget_tool_6r_with_contact", "the same, kept from touching itself and its table"},
    {"jog_retarget_joints_6r", "the same, by joints"},
    {"detect_cubes_720p", "cubes in a picture of 1280 x 720 px"},
    {"detect_cubes_10_megapixels", "cubes in a picture of 10 megapixels"},
    {"axis_link_encode", "axis link: encode a frame"},
    {"axis_link_decode", "axis link: decode a frame"},
    {"axis_link_cycle_6_axes", "axis link: one cycle of 6 axes, host"},
});

}  // namespace

bool RatioReporter::ReportContext(const Context&) {
  return true;
}

void RatioReporter::ReportRuns(const std::vector<Run>& runs) {
  for (const Run& run : runs) {
    if (run.error_occurred) {
      std::fprintf(stderr, "%s: %s\n", run.benchmark_name().c_str(), run.error_message.c_str());
    } else if (run.aggregate_name == "median") {
      // A benchmark that measures by itself says so in a counter.
      const auto own = run.counters.find("ns");
      median_ns_[run.run_name.function_name] =
          own != run.counters.end() ? own->second.value : run.GetAdjustedCPUTime();
    }
  }
}

void RatioReporter::Finalize() {
  const auto yardstick = median_ns_.find(kYardstick);
  if (yardstick == median_ns_.end()) return;
  std::printf("%-48s %12s %10s %8s\n", "work", "median ns", "x KDL fwd", "goal");
  for (const auto& [name, work, goal] : kRows) {
    const auto median = median_ns_.find(std::string(name));
    if (median == median_ns_.end()) continue;
    const double ratio = median->second / yardstick->second;
    std::printf("%-48.*s %12.1f %10.3f ", static_cast<int>(work.size()), work.data(),
                median->second, ratio);
    if (goal > 0) {
      std::printf("%8.2f  %s\n", goal, ratio <= goal ? "met" : "NOT MET");
    } else {
      std::printf("%8s\n", "-");
    }
  }
}

}  // namespace sinew::bench
