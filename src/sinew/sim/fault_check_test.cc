#include <gtest/gtest.h>

#include <string>

#include "sinew/sim/link_fault.h"
#include "support/robots.h"

namespace sinew::sim {
namespace {

std::string refusal(const char* robot, const std::string& text) {
  const auto plan = parse_faults(text);
  if (!plan) return "not read: " + plan.error();
  const auto fine = check_faults(*plan, test::robot(robot));
  return fine ? "" : fine.error();
}

TEST(FaultCheck, units_that_do_not_fit_the_joint_are_refused_with_what_would_be_right) {
  EXPECT_EQ(refusal("robot-arm-2", "block=J2@20mm@1s"),
            "block=J2: shoulder is a joint that turns; its place is an angle, as 20deg");
  EXPECT_EQ(refusal("robot-arm-2", "load=J2:2N@1s"),
            "load=J2: shoulder is a joint that turns; its load is a torque, as 0.5Nm");
  EXPECT_EQ(refusal("hexapod", "drop=0.1,block=J2@20deg@1s"),
            "block=J2: leg2 is a leg; its place is a length, as 12mm");
  EXPECT_EQ(refusal("hexapod", "load=J6:2Nm@1s"),
            "load=J6: leg6 is a leg; its load is a force, as 2N");
}

TEST(FaultCheck, magnets_fall_off_only_where_there_are_some) {
  for (const char* robot : {"learm", "bigrobotarm", "hexapod"}) {
    EXPECT_EQ(refusal(robot, "magnet=J3:off@1s"),
              "magnet=J3: " + std::string(robot) +
                  " has no magnet that could fall off: no sensor looks at its joints");
  }
  EXPECT_EQ(refusal("robot-arm-2", "magnet=J3:off@1s,magnet=J3:on@2s"), "");
  EXPECT_EQ(refusal("maxarm", "magnet=J3:off@1s"), "");
}

TEST(FaultCheck, couplings_slip_only_where_a_joint_has_an_encoder_of_its_own) {
  for (const char* robot : {"learm", "bigrobotarm", "hexapod", "maxarm"}) {
    EXPECT_EQ(refusal(robot, "coupling=J3:slips@1s"),
              "coupling=J3: " + std::string(robot) +
                  " has no encoder of its own on that joint that could come loose");
  }
  EXPECT_EQ(refusal("robot-arm-2", "coupling=J3:slips@1s,coupling=J3:holds@2s"), "");
  EXPECT_EQ(refusal("robot-arm-2", "lead=J3:loose@1s"),
            "lead=J3: robot-arm-2 has no module that watches the leads of its motors");
  EXPECT_EQ(refusal("hexapod", "lead=J3:loose@1s,lead=J3:fast@2s"), "");
  EXPECT_EQ(refusal("hexapod", "lead=J3:fast@2s"),
            "lead=J3:fast: it is fast; it goes with lead=J3:loose@4s");
  EXPECT_EQ(refusal("robot-arm-2", "coupling=J3:holds@2s"),
            "coupling=J3:holds: it holds; it goes with coupling=J3:slips@4s");
}

TEST(FaultCheck, joints_that_are_not_there_are_refused) {
  EXPECT_EQ(refusal("maxarm", "unblock=J4@1s"), "the robot has no J4; its joints are J1 to J3");
  EXPECT_EQ(refusal("learm", "load=J6:1Nm@1s"), "the robot has no J6; its joints are J1 to J5");
}

TEST(FaultCheck, joints_are_counted_as_the_robot_has_them) {
  const auto plan = parse_faults("block=J9@2mm@1s", 6);
  ASSERT_FALSE(plan);
  EXPECT_EQ(plan.error(), "fault \"block=J9@2mm@1s\": \"J9\" is no joint; they are J1 to J6");
}

TEST(FaultCheck, what_is_undone_must_have_been_done) {
  EXPECT_EQ(refusal("learm", "unblock=J2@5s"),
            "unblock=J2: nothing blocks J2 before; it goes with block=J2@20deg@4s");
  EXPECT_EQ(refusal("learm", "unblock=J2@5s,block=J2@1deg@6s,block=J1@1deg@1s"),
            "unblock=J2: nothing blocks J2 before; it goes with block=J2@20deg@4s");
  EXPECT_EQ(refusal("maxarm", "magnet=J1:on@5s"),
            "magnet=J1:on: it is on; it goes with magnet=J1:off@4s");
  EXPECT_EQ(refusal("maxarm", "magnet=J1:on@5s,magnet=J1:off@4s"), "") << "in any order of items";
}

TEST(FaultCheck, what_fits_is_let_through) {
  EXPECT_EQ(refusal("robot-arm-2", "block=J2@20deg@1s,load=J1:0.5Nm@1s,supply=9V@2s"), "");
  EXPECT_EQ(refusal("hexapod", "block=J6@12mm@1s,unblock=J6@2s,load=J1:2N@1s,payload=1kg@0s"), "");
}

TEST(FaultCheck, only_a_device_that_has_the_input_has_a_probe) {
  EXPECT_EQ(refusal("learm", "probe=J2@20deg@1s"),
            "probe=J2: the device of learm has no probe input");
}

TEST(FaultCheck, the_unit_survives_being_printed) {
  const auto plan = parse_faults("block=J6@12mm@1s,probe=J2@12mm@1s,load=J1:2N@1s,load=J2:2Nm@1s");
  ASSERT_TRUE(plan);
  EXPECT_EQ(to_text(*plan), "block=J6@0.012m@1s,probe=J2@0.012m@1s,load=J1:2N@1s,load=J2:2Nm@1s");
}

}  // namespace
}  // namespace sinew::sim
