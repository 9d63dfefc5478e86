// What would happen, and that nothing does.

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <string>
#include <vector>

#include "sinew/core/vec3.h"
#include "sinew/server/api/api_test_cell.h"

namespace sinew::server {
namespace {

using test::ApiCell;
using test::ApiClient;
using test::place;

std::vector<double> joints_of(ApiClient& client, const std::string& robot) {
  std::vector<double> q;
  const Json status = client.status(robot);
  for (const Json& joint : status["joints"]) q.push_back(joint["commanded_rad"].get<double>());
  return q;
}

TEST(Preview, says_how_long_and_where_and_moves_nothing) {
  ApiCell cell({place("left", "learm", "bus")});
  ApiClient client(cell);
  ASSERT_EQ(client.run("left", test::kStand)["phase"], "done");
  const std::vector<double> before = joints_of(client, "left");
  const Json answer =
      client.call("robot.preview",
                  {{"robot", "left"}, {"joints", {0.5, 0.35, 0.7, 0.7, 0.1}}, {"samples", 50}});
  ASSERT_TRUE(answer.contains("result")) << answer.dump();
  const Json& seen = answer["result"];
  EXPECT_GT(seen["duration_s"].get<double>(), 0.1);
  const Json& samples = seen["samples"];
  const std::size_t count = samples["t_s"].size();
  EXPECT_GE(count, 10U);
  EXPECT_LE(count, 52U);
  for (const char* key :
       {"position_rad", "velocity_rad_s", "acceleration_rad_s2", "jerk_rad_s3", "tool"}) {
    EXPECT_EQ(samples[key].size(), count) << key;
  }
  EXPECT_NEAR(samples["position_rad"].back()[0].get<double>(), 0.5, 1e-5);
  EXPECT_NEAR(samples["velocity_rad_s"].back()[0].get<double>(), 0, 1e-5);
  EXPECT_EQ(seen["to"]["tool"], samples["tool"].back());
  EXPECT_EQ(seen["limited"]["joint"].is_string(), true) << seen["limited"].dump();
  EXPECT_EQ(joints_of(client, "left"), before);
  // What it says is what a program of its text does.
  const Json job = client.run("left", seen["text"]);
  EXPECT_EQ(job["phase"], "done");
  EXPECT_NEAR(job["predicted_s"].get<double>(), seen["duration_s"].get<double>(), 1e-3);
}

TEST(Preview, a_joint_beyond_its_limit_is_named_with_how_much_is_missing) {
  ApiCell cell({place("left", "learm", "bus")});
  ApiClient client(cell);
  client.run("left", test::kStand);
  const Json answer =
      client.call("robot.preview", {{"robot", "left"}, {"joints", {0, 0.35, 3.0, 0.7, 0}}});
  ASSERT_TRUE(answer.contains("error")) << answer.dump();
  const Json& why = answer["error"]["data"];
  EXPECT_EQ(why["code"], "joint_limit");
  EXPECT_EQ(why["joint"], "elbow");
  EXPECT_NEAR(why["measured_rad"].get<double>(), 3.0, 1e-6);
  EXPECT_LT(why["limit_rad"].get<double>(), 3.0);
}

TEST(Preview, a_tool_out_of_reach_says_what_would_be_near_it) {
  ApiCell cell({place("left", "learm", "bus")});
  ApiClient client(cell);
  client.run("left", test::kStand);
  const Json far = client.call("robot.preview", {{"robot", "left"}, {"tool", {0.9, 0, 0.2}}});
  ASSERT_TRUE(far.contains("error")) << far.dump();
  const Json offer = far["error"]["data"]["would_work"];
  ASSERT_TRUE(offer.is_object()) << far.dump();
  const Json there =
      client.call("robot.preview", {{"robot", "left"}, {"joints", offer["positions"]}});
  EXPECT_TRUE(there.contains("result")) << there.dump();
}

TEST(Preview, a_line_goes_straight) {
  ApiCell cell({place("left", "learm", "bus")});
  ApiClient client(cell);
  client.run("left", test::kStand);
  const Json tool = client.status("left")["tool"];
  const double x = tool["x_m"].get<double>(), z = tool["z_m"].get<double>();
  const Json answer = client.call(
      "robot.preview",
      {{"robot", "left"}, {"tool", {x, tool["y_m"], z - 0.02}}, {"line", true}, {"speed", 0.5}});
  ASSERT_TRUE(answer.contains("result")) << answer.dump();
  const Json& way = answer["result"]["samples"]["tool"];
  const auto point = [](const Json& at) { return Vec3{at[0], at[1], at[2]}; };
  const Vec3 begin = point(way.front()), along = normalized(point(way.back()) - begin);
  EXPECT_GT(norm(point(way.back()) - begin), 0.01);
  for (const Json& at : way) {
    EXPECT_LT(norm(cross(along, point(at) - begin)), 5e-5);
  }
  EXPECT_NE(answer["result"]["text"].get<std::string>().find("speed=50%"), std::string::npos);
}

TEST(Preview, what_stands_in_the_cell_counts) {
  CellObject box{.name = "box", .X_WX = {}, .half = {0.05, 0.3, 0.3}};
  box.X_WX.p = {0.0, 0.35, 0.2};
  CellRobot left = place("left", "learm", "bus");
  left.X_WB.p.x = 0.001;  // somebody has placed it
  ApiCell cell({left, place("other", "learm", "bus")}, 20, {}, {box});
  ApiClient client(cell);
  ASSERT_EQ(client.run("left", test::kStand)["phase"], "done");
  const Json answer =
      client.call("robot.preview", {{"robot", "left"}, {"joints", {1.5, 0.35, 0.7, 0.7, 0}}});
  ASSERT_TRUE(answer.contains("error")) << answer.dump();
  EXPECT_EQ(answer["error"]["data"]["code"], "cell_contact");
  EXPECT_EQ(answer["error"]["data"]["other"], "box");
}

TEST(Preview, of_those_that_wait_only_the_latest_is_made) {
  ApiCell cell({place("left", "learm", "bus")});
  ApiClient client(cell);
  client.run("left", test::kStand);
  constexpr int kAsked = 30;
  for (int i = 0; i < kAsked; ++i) {
    client.send("robot.preview", {{"robot", "left"}, {"joints", {0.01 * i, 0.35, 0.7, 0.7, 0}}});
  }
  int made = 0, overtaken = 0;
  double last = -1;
  ASSERT_TRUE(cell.until([&] {
    while (const auto text = cell.api().take_output(client.id())) {
      const Json message = Json::parse(*text);
      if (message.contains("error")) {
        ++overtaken;
        EXPECT_EQ(message["error"]["data"]["code"], "overtaken");
      } else {
        ++made;
        last = message["result"]["to"]["positions"][0].get<double>();
      }
    }
    return made + overtaken == kAsked;
  }));
  EXPECT_GE(overtaken, 1);
  EXPECT_NEAR(last, 0.01 * (kAsked - 1), 1e-6);
}

TEST(Preview, wants_one_target_of_the_right_shape) {
  ApiCell cell({place("left", "learm", "bus")});
  ApiClient client(cell);
  const auto why = [&](const Json& params) { return client.sentence("robot.preview", params); };
  EXPECT_NE(why({{"robot", "left"}}).find("one of joints, tool and text"), std::string::npos);
  EXPECT_NE(why({{"robot", "left"}, {"joints", {0, 1}}}).find("5 joints, not 2"),
            std::string::npos);
  EXPECT_NE(why({{"robot", "left"}, {"tool", {0, 1}}}).find("three numbers"), std::string::npos);
  EXPECT_NE(why({{"robot", "left"}, {"tool", {0, 0, 0, 1, 1, 0, 0}}}).find("length 1"),
            std::string::npos);
  EXPECT_NE(why({{"robot", "left"}, {"text", "jump"}}).find("preview:1:1"), std::string::npos);
  EXPECT_NE(why({{"robot", "left"}, {"tool", {0, 0, 1}}, {"speed", 2}}).find("0.01 to 1"),
            std::string::npos);
}

TEST(Preview, a_viewer_may_look) {
  ApiCell cell({place("six", "hexapod")});
  ApiClient client(cell, Role::kViewer);
  const Json home = client.call("robot.model", {{"robot", "six"}})["result"];
  std::vector<double> legs;
  for (const Json& joint : home["joints"]) legs.push_back(joint["home_m"].get<double>() + 0.002);
  const Json answer = client.call("robot.preview", {{"robot", "six"}, {"joints", legs}});
  ASSERT_TRUE(answer.contains("result")) << answer.dump();
  EXPECT_EQ(answer["result"]["samples"]["tool"][0].size(), 7U);
}

TEST(Model, tells_what_robots_are_drawn_from) {
  ApiCell cell(
      {place("arm", "robot-arm-2", {}, "link"), place("max", "maxarm"), place("six", "hexapod")});
  ApiClient client(cell);
  const Json arm = client.call("robot.model", {{"robot", "arm"}})["result"];
  for (const char* key : {"xyz_m", "quaternion_wxyz"}) {
    EXPECT_TRUE(arm["links"][1]["home"].contains(key)) << arm["links"][1].dump();
  }
  EXPECT_EQ(arm["kind"], "serial");
  EXPECT_EQ(arm["geometry"]["dh"].size(), 6U);
  EXPECT_EQ(arm["links"].size(), 8U);
  EXPECT_EQ(arm["links"].back()["name"], "tool");
  EXPECT_EQ(arm["jog"]["joint"], 6);
  EXPECT_EQ(arm["jog"]["tool"], 6);
  EXPECT_FALSE(arm["jog"].contains("platform"));
  const Json max = client.call("robot.model", {{"robot", "max"}})["result"];
  EXPECT_EQ(max["kind"], "palletizer");
  EXPECT_TRUE(max["jog"].empty());
  const Json six = client.call("robot.model", {{"robot", "six"}})["result"];
  EXPECT_EQ(six["geometry"]["base_anchors_m"].size(), 6U);
  EXPECT_TRUE(six["jog"].contains("platform"));
  for (const Json& shape : six["shapes"]) EXPECT_GE(shape["link"], 0);
}

}  // namespace
}  // namespace sinew::server
