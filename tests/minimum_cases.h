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
// fails the full run.

inline constexpr std::array kMinimumTests = std::to_array<MinimumTests>({
    {"cli_test", 57},
    {"config_test", 62},
    {"core_test", 16},
    {"device_test", 16},
    {"driver_test", 29},
    {"house_test", 33},
    {"io_test", 38},
    {"kinematics_test", 114},
    {"motion_test", 12},
    {"program_test", 59},
    {"runtime_test", 13},
    {"wire_test", 18},
});

inline constexpr std::array kMinimumCases = std::to_array<MinimumCases>({
    {"config_test", "BigRobotArm.dh_table_is_the_chain_of_its_axes", 2'000},
    {"config_test", "BigRobotArm.zero_pose_is_568_mm_tall_and_planar_formulas_hold", 500},
    {"config_test", "Learm.dh_table_is_the_chain_of_its_words", 2'000},
    {"config_test", "SpoiledRobotFile.whatever_is_accepted_keeps_the_promises_of_the_model", 5'000},
    {"core_test", "Pose.inverse_undoes_and_product_reads_from_left_to_right", 10'000},
    {"core_test", "Rotation.every_way_of_writing_it_gives_it_back", 100'000},
    {"core_test", "Trig.arc_tangent_agrees_with_the_c_library", 1'000'000},
    {"core_test", "Trig.sine_and_cosine_agree_with_the_c_library", 1'000'000},
    {"device_test", "BigRobotArmFirmware.any_bytes_are_survived_without_an_allocation", 2'000},
    {"driver_test", "BigRobotArmDriver.any_noise_on_the_line_ends_in_a_driver_that_works", 2'000},
    {"driver_test", "BigRobotArmMultipliers.no_other_whole_numbers_would_arrive_much_nearer", 60},
    {"driver_test", "BigRobotArmMultipliers.ordinary_moves_arrive_within_three_percent", 5'000},
    {"kinematics_test", "FiveRPitch.chosen_pitch_is_the_smallest_tilt_that_the_limits_allow",
     2'000},
    {"kinematics_test", "FiveRPitch.lateral_offset_is_left_to_the_numeric_solver", 200},
    {"kinematics_test", "FiveRRoll.approach_out_of_the_plane_is_met_by_rolling_the_forearm",
     100'000},
    {"kinematics_test", "Hexapod.check_finds_each_leg_that_is_too_long_too_bent_or_too_tilted",
     100'000},
    {"kinematics_test", "Hexapod.condition_number_has_no_unit", 10'000},
    {"kinematics_test", "Hexapod.inverse_is_the_distance_between_the_anchors", 100'000},
    {"kinematics_test", "Hexapod.jacobian_is_the_slope_of_inverse", 100'000},
    {"kinematics_test", "Hexapod.moving_both_frames_with_their_anchors_changes_no_leg", 10'000},
    {"kinematics_test", "HexapodForward.agrees_with_a_multi_start_solver_in_quaternions", 4'000},
    {"kinematics_test", "HexapodForward.every_answer_has_the_legs_and_is_near_the_last_pose",
     100'000},
    {"kinematics_test", "HexapodForward.is_exact_up_to_a_condition_number_of_100", 20'000},
    {"kinematics_test", "HexapodForward.mirrored_platform_below_the_base_is_ambiguous", 20'000},
    {"kinematics_test",
     "HexapodForward.near_a_singularity_the_legs_are_met_and_the_pose_is_flagged", 20'000},
    {"kinematics_test", "HexapodForward.of_inverse_gives_every_pose_of_the_workspace_back",
     100'000},
    {"kinematics_test", "HexapodForward.of_random_legs_has_these_legs", 100'000},
    {"kinematics_test", "LegBlocks.agrees_with_the_pivoted_solver_where_both_blocks_are_regular",
     100'000},
    {"kinematics_test", "LegLu.singular_matrix_is_refused", 10'000},
    {"kinematics_test", "LegLu.solves_what_can_be_solved", 100'000},
    {"kinematics_test", "NumericIk.straight_chain_is_in_reach_of_its_own_links", 2'000},
    {"kinematics_test", "Palletizer.forward_of_inverse_gives_every_point_back_or_says_why_not",
     200'000},
    {"kinematics_test", "Palletizer.inverse_of_forward_gives_the_joints_back", 100'000},
    {"kinematics_test", "Palletizer.jacobian_is_the_slope_of_forward", 100'000},
    {"kinematics_test", "Palletizer.point_behind_the_shoulder_leans_the_arm_back", 100'000},
    {"kinematics_test", "Palletizer.straight_and_folded_arm_keep_their_position_to_a_nanometre",
     100'000},
    {"kinematics_test", "Palletizer.tool_stays_level_and_turns_with_the_base", 100'000},
    {"kinematics_test", "Robots/SerialChains.forward_and_jacobian_agree_with_kdl/bigrobotarm",
     100'000},
    {"kinematics_test", "Robots/SerialChains.forward_and_jacobian_agree_with_kdl/learm", 100'000},
    {"kinematics_test", "Robots/SerialChains.forward_and_jacobian_agree_with_kdl/puma560", 100'000},
    {"kinematics_test", "Robots/SerialChains.forward_and_jacobian_agree_with_kdl/robot_arm_2",
     100'000},
    {"kinematics_test", "Robots/SerialChains.jacobian_is_the_derivative_of_forward/bigrobotarm",
     100'000},
    {"kinematics_test", "Robots/SerialChains.jacobian_is_the_derivative_of_forward/learm", 100'000},
    {"kinematics_test", "Robots/SerialChains.jacobian_is_the_derivative_of_forward/puma560",
     100'000},
    {"kinematics_test", "Robots/SerialChains.jacobian_is_the_derivative_of_forward/robot_arm_2",
     100'000},
    {"kinematics_test", "Robots/SerialChains.product_of_links_is_forward/bigrobotarm", 1'000},
    {"kinematics_test", "Robots/SerialChains.product_of_links_is_forward/learm", 1'000},
    {"kinematics_test", "Robots/SerialChains.product_of_links_is_forward/puma560", 1'000},
    {"kinematics_test", "Robots/SerialChains.product_of_links_is_forward/robot_arm_2", 1'000},
    {"kinematics_test", "Robots/SerialInverse.finds_the_branch_that_made_the_pose/bigrobotarm",
     100'000},
    {"kinematics_test", "Robots/SerialInverse.finds_the_branch_that_made_the_pose/learm", 100'000},
    {"kinematics_test", "Robots/SerialInverse.finds_the_branch_that_made_the_pose/puma560",
     100'000},
    {"kinematics_test", "Robots/SerialInverse.finds_the_branch_that_made_the_pose/robot_arm_2",
     100'000},
    {"kinematics_test",
     "Robots/SerialInverse.near_singular_poses_are_flagged_and_still_exact/bigrobotarm", 100'000},
    {"kinematics_test",
     "Robots/SerialInverse.near_singular_poses_are_flagged_and_still_exact/learm", 100'000},
    {"kinematics_test",
     "Robots/SerialInverse.near_singular_poses_are_flagged_and_still_exact/puma560", 100'000},
    {"kinematics_test",
     "Robots/SerialInverse.near_singular_poses_are_flagged_and_still_exact/robot_arm_2", 100'000},
    {"kinematics_test",
     "Robots/SerialInverse.numeric_solver_agrees_with_the_closed_form/bigrobotarm", 20'000},
    {"kinematics_test", "Robots/SerialInverse.numeric_solver_agrees_with_the_closed_form/learm",
     20'000},
    {"kinematics_test", "Robots/SerialInverse.numeric_solver_agrees_with_the_closed_form/puma560",
     20'000},
    {"kinematics_test",
     "Robots/SerialInverse.numeric_solver_agrees_with_the_closed_form/robot_arm_2", 20'000},
    {"kinematics_test", "Robots/SerialInverse.turns_of_the_joints_follow_the_reference/bigrobotarm",
     10'000},
    {"kinematics_test", "Robots/SerialInverse.turns_of_the_joints_follow_the_reference/learm",
     10'000},
    {"kinematics_test", "Robots/SerialInverse.turns_of_the_joints_follow_the_reference/puma560",
     10'000},
    {"kinematics_test", "Robots/SerialInverse.turns_of_the_joints_follow_the_reference/robot_arm_2",
     10'000},
    {"kinematics_test",
     "Robots/WideVectors.forward_and_jacobian_are_those_of_the_portable_version/bigrobotarm",
     100'000},
    {"kinematics_test",
     "Robots/WideVectors.forward_and_jacobian_are_those_of_the_portable_version/learm", 100'000},
    {"kinematics_test",
     "Robots/WideVectors.forward_and_jacobian_are_those_of_the_portable_version/puma560", 100'000},
    {"kinematics_test",
     "Robots/WideVectors.forward_and_jacobian_are_those_of_the_portable_version/robot_arm_2",
     100'000},
    {"kinematics_test", "SingularRange.agrees_with_eigen", 20'000},
    {"kinematics_test", "SingularRange.keeps_a_value_that_squaring_would_lose", 10'000},
    {"kinematics_test", "SixR.any_offsets_and_signs_of_the_structure_are_solved", 100'000},
    {"kinematics_test", "SixRWideVectors.every_branch_is_that_of_the_portable_version", 100'000},
    {"motion_test", "RestToRest.duration_is_that_of_the_slowest_axis", 100'000},
    {"motion_test", "RestToRest.one_axis_is_as_quick_as_a_search_over_all_peak_speeds", 20'000},
    {"motion_test", "RestToRest.stays_inside_every_limit_and_arrives_together", 100'000},
    {"motion_test", "RestToRest.velocity_and_acceleration_are_the_derivatives", 100'000},
    {"motion_test", "RestToRest.wide_vectors_sample_what_the_portable_version_does", 20'000},
    {"motion_test", "Trapezoid.any_profile_keeps_its_limits_and_joins_without_a_jump", 100'000},
    {"program_test", "SequenceFile.any_program_is_written_and_read_back_unchanged", 20'000},
    {"program_test", "SequencePlan.any_plan_is_without_gaps_inside_its_limits_and_sendable", 5'000},
    {"program_test", "SequenceRun.any_noise_in_any_motion_ends_in_a_run_that_is_over", 500},
    {"wire_test", "BigRobotArmByte.any_noise_is_survived_and_a_reset_ends_it", 100'000},
    {"wire_test", "BigRobotArmByte.random_messages_come_back_as_they_were_sent", 100'000},
    {"wire_test", "BigRobotArmText.random_lines_come_back_as_they_were_sent", 100'000},
});

}  // namespace sinew::house
