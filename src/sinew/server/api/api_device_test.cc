#include <gtest/gtest.h>

#include <algorithm>

#include "sinew/devices/icp/icp_test_cell.h"
#include "sinew/devices/kinds.h"
#include "sinew/runtime/links/machine_thread.h"
#include "sinew/server/api/api_test_cell.h"
#include "sinew/server/json/device_json.h"
#include "sinew/sim/link_fault.h"

namespace sinew::server {
namespace {

using test::ApiCell;
using test::ApiClient;
using test::place;

bool warns(const Json& device, const std::string& name, const std::string& joint = {}) {
  return std::ranges::any_of(device["warnings"], [&](const Json& one) {
    return one["name"] == name && (joint.empty() || one.value("joint", "") == joint);
  });
}

Json device_of(ApiClient& client, const std::string& robot) {
  const Json answer = client.call("device.status", {{"robot", robot}});
  EXPECT_TRUE(answer.contains("result")) << answer.dump();
  return answer["result"];
}

void make_ready(ApiClient& client, const std::string& robot) {
  EXPECT_EQ(client.sentence("lease.take", {{"robot", robot}}), "");
  EXPECT_EQ(client.sentence("robot.enable", {{"robot", robot}}), "");
}

/// Of this name, the last one that has passed.
Json last_frame(ApiClient& client, const std::string& robot, const std::string& name) {
  const Json read = client.call("wire.read", {{"robot", robot}, {"limit", 2000}})["result"];
  Json last;
  for (const Json& frame : read["frames"]) {
    if (frame["name"] == name) last = frame;
  }
  return last;
}

TEST(ApiDevice, boards_that_can_test_themselves_do_and_others_say_that_they_cannot) {
  ApiCell cell({place("arm", "robot-arm-2"), place("small", "learm")});
  ApiClient client(cell);
  EXPECT_NE(client.sentence("robot.self_test", {{"robot", "arm"}}), "") << "without the lease";
  make_ready(client, "arm");
  EXPECT_EQ(client.sentence("robot.self_test", {{"robot", "arm"}}), "");
  make_ready(client, "small");
  EXPECT_EQ(client.sentence("robot.self_test", {{"robot", "small"}}),
            "this device has no command for that");
}

TEST(ApiDevice, looking_on_needs_no_lease_and_sends_nothing) {
  ApiCell cell({place("six", "hexapod")});
  ApiClient viewer(cell, Role::kViewer);
  const Json before = viewer.status("six")["health"];
  const Json device = device_of(viewer, "six");
  EXPECT_EQ(device["robot"], "six");
  EXPECT_EQ(device["wire"], "icp");
  EXPECT_EQ(device["legs"].size(), 6U);
  EXPECT_FALSE(device["legs"][0].contains("bytes")) << "it was not asked yet";
  EXPECT_TRUE(viewer.call("wire.read", {{"robot", "six"}})["result"]["frames"].empty());
  EXPECT_EQ(viewer.status("six")["health"], before);
  EXPECT_NE(viewer.sentence("wire.read", {{"robot", "six"}, {"limit", 0}}), "");
  EXPECT_NE(viewer.sentence("device.status", {{"robot", "seven"}}), "");
}

TEST(ApiDevice, hexapod_tells_its_twelve_bytes_as_they_came_over_the_wire) {
  ApiCell cell({place("six", "hexapod")});
  ApiClient client(cell);
  make_ready(client, "six");
  const Json device = device_of(client, "six");
  for (const Json& leg : device["legs"]) {
    EXPECT_EQ(leg["flags"], Json::array());
    EXPECT_EQ(leg["motion"], "at_target");
    EXPECT_EQ(leg["temperature"], "normal");
    EXPECT_NEAR(leg["run_current_ma"], 566, 1e-9);
    EXPECT_EQ(leg["microsteps"], 16);
    EXPECT_GE(leg["age_s"], 0.0);
  }
  EXPECT_TRUE(device["warnings"].empty());
  // The last status on the wire is of the last leg: its acknowledgement and the same 12 bytes.
  const Json frame = last_frame(client, "six", "status");
  EXPECT_EQ(frame["hex"], "00 " + std::string(device["legs"][5]["bytes"]));
  EXPECT_EQ(frame["to"], "host");
  EXPECT_EQ(frame["fields"][0], (Json{"motor", 6}));
}

/// In virtual time, so that the supply gives way while a motor really turns.
TEST(ApiDevice, hexapod_step_loss_is_told_with_its_bytes_and_kept) {
  using namespace std::chrono_literals;
  sinew::test::IcpCell cell;
  cell.begin();
  ASSERT_TRUE(cell.go({40, 40, 40, 40, 40, 40}));
  cell.run_until([&] { return cell.machine.truth().moving; });
  ASSERT_TRUE(cell.machine.truth().moving);
  bool lost = false;
  for (int i = 0; i < 200 && !lost; ++i) {
    cell.run_for(300us);
    cell.machine.disturb({sim::Disturbance::Kind::kSupply, -1, 7.4});
    cell.machine.disturb({sim::Disturbance::Kind::kSupply, -1, 12});
    cell.settle();
    const Json now = device_json(cell.driver.facts(), cell.robot, cell.now);
    lost = warns(now, "step_loss");
    if (lost) break;
    ASSERT_TRUE(cell.driver.clear_fault(cell.now));
    cell.settle();
    cell.driver.declare_positions(sinew::test::IcpCell::at_home());
    ASSERT_TRUE(cell.go({40, 40, 40, 40, 40, 40}));
    cell.run_for(Duration{i * 137us});
  }
  const Json device = device_json(cell.driver.facts(), cell.robot, cell.now);
  ASSERT_TRUE(lost) << device.dump();
  EXPECT_TRUE(warns(device, "under_voltage"));
  const auto slipped = std::ranges::find_if(device["legs"], [](const Json& leg) {
    return leg.contains("last_trouble") &&
           std::ranges::count(leg["last_trouble"]["flags"], Json("step_loss")) > 0;
  });
  ASSERT_NE(slipped, device["legs"].end());
  // Bit 6 of the fifth byte.
  const std::string bytes = (*slipped)["last_trouble"]["bytes"];
  EXPECT_EQ(std::stoi(bytes.substr(12, 2), nullptr, 16) & 0x40, 0x40) << bytes;
}

/// A machine on a port of its own, whose supply gives way.
TEST(ApiDevice, what_a_failing_supply_does_to_the_hexapod_is_seen) {
  const RobotModel& robot = sinew::test::robot("hexapod");
  io::Clock clock;
  auto machine = make_machine(robot, {}, clock.now());
  ASSERT_TRUE(machine);
  const auto faults = sim::parse_faults("supply=7.4V@1.5s,supply=12V@2.5s", 6);
  ASSERT_TRUE(faults) << faults.error();
  auto thread = runtime::MachineThread::start(std::move(machine->byte), clock,
                                              {.baud = robot.device.baud, .faults = *faults});
  ASSERT_TRUE(thread);
  CellRobot six = place("six", "hexapod");
  six.port = (*thread)->path();
  ApiCell cell({six}, 1);
  ApiClient client(cell);
  make_ready(client, "six");
  ASSERT_TRUE(cell.until([&] {
    // Each acknowledgement asks all six modules.
    client.call("robot.acknowledge", {{"robot", "six"}});
    client.call("robot.disable", {{"robot", "six"}});
    client.call("robot.enable", {{"robot", "six"}});
    return warns(device_of(client, "six"), "under_voltage");
  })) << device_of(client, "six").dump();
}

TEST(ApiDevice, learm_tells_its_battery_and_its_servos) {
  ApiCell cell({place("left", "learm", "bus")});
  ApiClient client(cell);
  make_ready(client, "left");
  Json device;
  ASSERT_TRUE(cell.until([&] {
    client.call("lease.renew");
    device = device_of(client, "left");
    return device.contains("battery") && device.contains("positions");
  })) << device.dump();
  EXPECT_EQ(device["board"], "bus");
  EXPECT_NEAR(device["battery"]["volts"], 7.4, 1.5);
  EXPECT_TRUE(device["positions"]["measured"]);
  const Json status = client.status("left");
  for (const Json& servo : device["positions"]["servos"]) {
    if (!servo.contains("joint")) continue;
    const auto joint = std::ranges::find_if(
        status["joints"], [&](const Json& one) { return one["name"] == servo["joint"]; });
    EXPECT_NEAR(servo["position_rad"], (*joint)["position_rad"], 0.05) << servo.dump();
  }
  const Json frame = last_frame(client, "left", "battery");
  EXPECT_EQ(frame["hex"].get<std::string>().substr(0, 11), "55 55 04 0F");
}

TEST(ApiDevice, maxarm_tells_its_answers_and_what_their_sum_covers) {
  ApiCell cell({place("arm", "maxarm")});
  ApiClient client(cell);
  make_ready(client, "arm");
  const Json device = device_of(client, "arm");
  EXPECT_EQ(device["board"], "arduino");
  EXPECT_EQ(device["checksum"], "spec");
  ASSERT_EQ(device["angles"]["servos"].size(), 3U);
  const Json status = client.status("arm");
  for (std::size_t j = 0; j < 3; ++j) {
    EXPECT_NEAR(device["angles"]["servos"][j]["position_rad"], status["joints"][j]["position_rad"],
                0.02);
  }
  EXPECT_EQ(last_frame(client, "arm", "angles")["hex"], device["angles"]["bytes"]);
  EXPECT_EQ(last_frame(client, "arm", "xyz")["hex"], device["position"]["bytes"]);
}

TEST(ApiDevice, bigrobotarm_tells_its_counters_and_that_it_knows_no_place) {
  ApiCell cell({place("big", "bigrobotarm")});
  ApiClient client(cell);
  make_ready(client, "big");
  const Json device = device_of(client, "big");
  ASSERT_TRUE(device.contains("status")) << device.dump() << client.status("big").dump();
  EXPECT_EQ(device["status"]["joints"].size(), 5U);
  EXPECT_EQ(device["status"]["sync"], false);
  EXPECT_TRUE(device["spoken"].is_string());
  EXPECT_FALSE(last_frame(client, "big", "ask_status").is_null());
}

TEST(ApiDevice, bigrobotarm_with_our_firmware_tells_its_queue_and_its_statistics) {
  ApiCell cell({place("big", "bigrobotarm", {}, "framed")});
  ApiClient client(cell);
  make_ready(client, "big");
  Json device;
  ASSERT_TRUE(cell.until([&] {
    device = device_of(client, "big");
    return device.contains("statistics") && device["arm"]["reference"] == "set";
  }));
  EXPECT_EQ(device["wire"], "arm_link");
  EXPECT_EQ(device["arm"]["joints"].size(), 5U);
  EXPECT_EQ(device["arm"]["fault"], "none");
  EXPECT_EQ(device["statistics"]["starts"], 1);
  EXPECT_FALSE(last_frame(client, "big", "statistics").is_null());
}

TEST(ApiDevice, axis_boards_tell_their_registers) {
  ApiCell cell({place("arm", "robot-arm-2", {}, "registers")});
  ApiClient client(cell);
  make_ready(client, "arm");
  Json device = device_of(client, "arm");
  ASSERT_EQ(device["axes"].size(), 6U);
  for (const Json& axis : device["axes"]) {
    EXPECT_TRUE(axis["answers"]) << axis.dump();
    EXPECT_TRUE(axis["flags"]["motor_ok"]);
    EXPECT_FALSE(axis["flags"]["homed"]);
    EXPECT_EQ(axis["registers"][0]["register"], "diag_status");
  }
  EXPECT_TRUE(warns(device, "not_homed", "base")) << device["warnings"].dump();
  EXPECT_FALSE(last_frame(client, "arm", "syn_ack").is_null());
  const Json data = last_frame(client, "arm", "data");
  EXPECT_EQ(data["fields"][0], (Json{"register", "diag_status"}));
  EXPECT_EQ(data["axes"].size(), 1U);
}

TEST(ApiDevice, axes_on_the_link_tell_what_they_follow) {
  ApiCell cell({place("arm", "robot-arm-2", {}, "link")}, 5);
  ApiClient client(cell);
  make_ready(client, "arm");
  const Json device = device_of(client, "arm");
  ASSERT_EQ(device["axes"].size(), 6U);
  for (const Json& axis : device["axes"]) {
    EXPECT_TRUE(axis["answers"]) << axis.dump();
    EXPECT_LT(axis["age_s"], 1.0);
    EXPECT_TRUE(axis["flags"]["sensor_ok"]);
    EXPECT_TRUE(axis["identity"]["model_hash"].is_number());
  }
  EXPECT_GT(device["round_s"], 0.0);
  EXPECT_FALSE(last_frame(client, "arm", "state").is_null());
}

TEST(ApiDevice, wire_is_read_on_from_where_a_client_was) {
  ApiCell cell({place("arm", "maxarm")});
  ApiClient client(cell);
  make_ready(client, "arm");
  Json read = client.call("wire.read", {{"robot", "arm"}})["result"];
  ASSERT_FALSE(read["frames"].empty());
  std::uint64_t last = read["last"];
  EXPECT_EQ(read["frames"].back()["sequence"], last);
  ASSERT_TRUE(cell.until([&] {
    client.call("lease.renew");
    read = client.call("wire.read", {{"robot", "arm"}, {"since", last}})["result"];
    return !read["frames"].empty();
  }));
  EXPECT_EQ(read["frames"][0]["sequence"], last + 1);
  EXPECT_EQ(read["lost"], 0);
}

}  // namespace
}  // namespace sinew::server
