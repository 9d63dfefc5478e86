#include "sinew/config/read_collision.h"

#include <gtest/gtest.h>

#include <algorithm>

#include "sinew/config/builtin_robots.h"
#include "sinew/config/robot_file.h"
#include "sinew/core/units.h"
#include "sinew/model/collision_links.h"
#include "support/robots.h"

namespace sinew {
namespace {

using test::robot;

std::string builtin(std::string_view id) {
  return std::string(std::ranges::find(builtin_robots(), id, &BuiltinRobot::id)->text);
}

/// `text` with its first occurrence of `from` behind `after` turned into `to`.
std::string with(std::string text, std::string_view from, std::string_view to,
                 std::string_view after = "[collision]") {
  const std::size_t begin = text.find(after);
  EXPECT_NE(begin, std::string::npos) << after;
  const std::size_t at = text.find(from, begin);
  EXPECT_NE(at, std::string::npos) << from;
  if (at != std::string::npos) text.replace(at, from.size(), to);
  return text;
}

/// The only complaint about a text, without its place.
std::string complaint(const std::string& text) {
  const auto model = read_robot(text, "r");
  if (model) return "none";
  if (model.error().size() != 1) {
    std::string all = std::to_string(model.error().size()) + " complaints:";
    for (const Complaint& one : model.error()) all += "\n" + to_text(one);
    return all;
  }
  return model.error()[0].key + ": " + model.error()[0].message;
}

std::string complaint_about(std::string_view id, std::string_view from, std::string_view to,
                            std::string_view after = "[collision]") {
  return complaint(with(builtin(id), from, to, after));
}

TEST(Collision, shapes_arrive_in_si_in_the_order_of_the_file) {
  const RobotModel& model = robot("robot-arm-2");
  const Collision& collision = model.collision;
  ASSERT_EQ(collision.shapes.size(), 9U);
  EXPECT_DOUBLE_EQ(collision.margin, 0.010);
  EXPECT_EQ(collision.table_height, 0.0);
  EXPECT_EQ(collision.shapes[0].link, 0);
  const auto& disc = std::get<CollisionBox>(collision.shapes[0].form);
  EXPECT_DOUBLE_EQ(disc.half.x, 0.152);
  EXPECT_DOUBLE_EQ(disc.X_LX.p.z, 0.040);
  EXPECT_EQ(collision.shapes[3].link, 2);
  const auto& upper_arm = std::get<Capsule>(collision.shapes[3].form);
  EXPECT_DOUBLE_EQ(upper_arm.p_LA.x, -0.315);
  EXPECT_EQ(upper_arm.p_LB, Vec3{});
  EXPECT_DOUBLE_EQ(upper_arm.radius, 0.050);
  ASSERT_EQ(collision.ignored.size(), 1U);
  EXPECT_EQ(collision.ignored[0].first, 4);
  EXPECT_EQ(collision.ignored[0].second, 6);
  const auto turned =
      read_robot(with(builtin("robot-arm-2"), "rpy_deg = [0, 0, 0]", "rpy_deg = [0, 0, 90]"), "r");
  ASSERT_TRUE(turned.has_value());
  const auto& box = std::get<CollisionBox>(turned->collision.shapes[0].form);
  EXPECT_LE(norm(box.X_LX.R.x - Vec3{0, 1, 0}), 1e-15);
}

TEST(Collision, legs_and_tools_have_shapes_of_their_own) {
  const Collision& hexapod = robot("hexapod").collision;
  ASSERT_EQ(hexapod.shapes.size(), 8U);
  EXPECT_FALSE(hexapod.table_height.has_value());
  for (std::size_t leg = 1; leg <= kLegs; ++leg) {
    EXPECT_EQ(hexapod.shapes[leg].link, leg);
    EXPECT_DOUBLE_EQ(std::get<LegCapsule>(hexapod.shapes[leg].form).radius, 0.006);
  }
  EXPECT_EQ(hexapod.shapes[7].link, 7);
  EXPECT_EQ(robot("maxarm").collision.shapes.back().link, 4);
  EXPECT_EQ(robot("bigrobotarm").collision.shapes.back().link, 6);
}

TEST(Collision, links_are_known_by_the_names_that_the_file_uses) {
  for (const char* id : {"robot-arm-2", "maxarm", "hexapod"}) {
    const RobotModel& model = robot(id);
    ASSERT_EQ(link_count(model), model.joints.size() + 2);
    for (std::size_t link = 0; link < link_count(model); ++link) {
      EXPECT_EQ(link_named(model, link_name(model, link)), link) << id;
    }
    EXPECT_EQ(link_named(model, "table"), kTableLink);
    EXPECT_EQ(link_named(model, "no such link"), std::nullopt);
  }
  EXPECT_EQ(link_name(robot("maxarm"), 4), "tool");
  EXPECT_EQ(link_name(robot("hexapod"), 7), "platform");
}

TEST(Collision, robot_may_leave_it_out) {
  std::string text = builtin("learm");
  const std::size_t begin = text.find("[collision]");
  text.erase(begin, text.find("[device]") - begin);
  const auto model = read_robot(text, "r");
  ASSERT_TRUE(model.has_value()) << to_text(model.error().front());
  EXPECT_TRUE(model->collision.shapes.empty());
  EXPECT_FALSE(model->collision.table_height.has_value());
}

TEST(Collision, every_fault_is_told_with_its_remedy) {
  const struct {
    const char* id;
    const char* from;
    const char* to;
    const char* after;
    const char* complaint;
  } kCases[] = {
      {"maxarm", "margin_mm = 5", "margin = 5", "[collision]",
       "collision.margin: missing unit: write `margin_mm`, `margin_m` or `margin_in`"},
      {"maxarm", "margin_mm = 5", "margin_mm = -1", "[collision]",
       "collision.margin_mm: must be 0 to 500 mm, not -1"},
      {"maxarm", "[collision.table]", "[collision.tabel]", "[collision]",
       "collision.tabel: unknown key; did you mean `table`?"},
      {"maxarm", "height_mm = 0\n", "", "[collision.table]",
       "collision.table.height: missing: write `height_mm`, `height_m` or `height_in`"},
      {"maxarm", "\"forearm\"", "\"forarm\"", "[collision]",
       "collision.shape[4].link: must be `stand`, `base`, `shoulder`, `forearm` or `tool`, not "
       "`forarm`; did you mean `forearm`?"},
      {"maxarm", "\"tool\"", "\"table\"", "[collision]",
       "collision.shape[5].link: must be `stand`, `base`, `shoulder`, `forearm` or `tool`, not "
       "`table`"},
      {"maxarm", "\"capsule\"", "\"capsul\"", "[collision]",
       "collision.shape[2].form: must be `capsule`, `box`, `leg`, `finger` or `held`, not "
       "`capsul`; did you mean "
       "`capsule`?"},
      {"maxarm", "radius_mm = 30", "radius_mm = 0", "[collision]",
       "collision.shape[2].radius_mm: must be above 0 and at most 2000 mm, not 0"},
      {"maxarm", "half_mm = [55, 55, 20]", "half_mm = [55, 0, 20]", "[collision]",
       "collision.shape[1].half_mm[2]: must be above 0 and at most 2000 mm, not 0"},
      {"maxarm", "to_mm = [0, -138, 0]\n", "", "[collision]",
       "collision.shape[4].to: missing: write `to_mm`, `to_m` or `to_in`"},
      {"maxarm", "  source = \"estimated: base plate with the controller\"\n", "", "[collision]",
       "collision.shape[1].source: missing: write where these numbers come from, or \"assumed\""},
      {"hexapod", "form = \"leg\"", "form = \"capsule\"\n from_mm = [0,0,0]\n to_mm = [0,0,0]",
       "[collision]", "collision.shape[2].form: the legs of a hexapod must be `leg`"},
      {"hexapod", "link = \"leg2\"", "link = \"platform\"", "[collision]",
       "collision.shape[3].form: only the legs of a hexapod may be `leg`"},
      {"robot-arm-2", "second = \"flange_roll\"", "second = \"wrist_bend\"", "[collision]",
       "collision.ignore[1].second: these two are joined, or one, and never held against each "
       "other"},
      {"robot-arm-2", "second = \"flange_roll\"\n",
       "second = \"flange_roll\"\n[[collision.ignore]]\nfirst = \"flange_roll\"\n"
       "second = \"forearm_roll\"\n",
       "[collision]", "collision.ignore[2].second: these two are ignored already"},
      {"robot-arm-2", "second = \"flange_roll\"", "second = \"tabel\"", "[collision]",
       "collision.ignore[1].second: must be `stand`, `base`, `shoulder`, `elbow`, `forearm_roll`, "
       "`wrist_bend`, `flange_roll`, `tool` or `table`, not `tabel`; did you mean `table`?"},
      {"robot-arm-2", "first = \"forearm_roll\"", "fist = \"forearm_roll\"", "[collision]",
       "collision.ignore[1].fist: unknown key; did you mean `first`?"},
  };
  for (const auto& c : kCases) {
    const std::string told = complaint_about(c.id, c.from, c.to, c.after);
    EXPECT_TRUE(told.starts_with(c.complaint)) << told << "\ninstead of\n" << c.complaint;
  }
}

TEST(Collision, link_may_be_excused_from_the_table) {
  const auto model = read_robot(
      with(builtin("robot-arm-2"), "second = \"flange_roll\"", "second = \"table\""), "r");
  ASSERT_TRUE(model.has_value()) << to_text(model.error().front());
  EXPECT_EQ(model->collision.ignored[0].second, kTableLink);
}

TEST(Collision, joint_that_is_called_like_a_link_is_refused) {
  std::string text = builtin("maxarm");
  text = with(text, "name = \"forearm\"", "name = \"tool\"", "[[joint]]");
  text = with(text, "[device.joint.forearm]", "[device.joint.tool]", "[[joint]]");
  const auto model = read_robot(text, "r");
  ASSERT_FALSE(model.has_value());
  EXPECT_TRUE(std::ranges::any_of(model.error(), [](const Complaint& one) {
    return one.message == "a joint is called `tool`, which is the name of something else here";
  })) << to_text(model.error().front());
}

TEST(Collision, shapes_beyond_the_bound_are_refused_without_harm) {
  std::string shapes;
  for (int i = 0; i < 40; ++i) {
    shapes +=
        "[[collision.shape]]\nlink = \"tool\"\nform = \"capsule\"\nfrom_mm = [0, 0, 0]\n"
        "to_mm = [0, 0, 1]\nradius_mm = 1\nsource = \"s\"\n";
  }
  EXPECT_EQ(complaint_about("learm", "[device]", shapes + "[device]"),
            "collision.shape[25]: one shape too many: a robot has at most 24");
}

}  // namespace
}  // namespace sinew
