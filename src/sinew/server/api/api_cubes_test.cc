// Cubes that can be had, where they could be, and baskets: over the API, in real threads.

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "sinew/server/api/api_test_cell.h"
#include "support/scratch_folder.h"

namespace sinew::server {
namespace {

using test::ApiCell;
using test::ApiClient;

constexpr const char* kAside = "joint base=-60deg shoulder=20deg elbow=40deg wrist=40deg roll=0deg";
constexpr std::string_view kSort = "repeat while seen\n  pick\n  place tray\nend\n";

CellCube cube(int color, double x, double y) {
  return {.color = color, .p_W = {x, y, 0}, .turn = 0.4};
}

/// A LeArm under a simulated camera: three cubes, one of them out of reach, and a basket.
Cell table() {
  Cell cell;
  cell.cameras.emplace_back();
  cell.cameras[0].name = "eye";
  cell.cameras[0].device = kSimulatedCamera;
  cell.cameras[0].X_WT.p = {0.15, 0.04, 0};
  CellBasket tray;
  tray.name = "tray";
  tray.X_WK.p = {0.06, 0.18, 0};
  tray.size = {0.11, 0.11, 0.05};
  cell.baskets = {tray};
  cell.cubes = {cube(0, 0.17, -0.02), cube(4, 0.18, 0.045), cube(3, 0.33, 0.05)};
  return cell;
}

class Cubes {
 public:
  explicit Cubes(const runtime::CellFolders& folders = {})
      : cell_({test::place("left", "learm", "bus")}, 20, folders, {}, nullptr, {}, table()),
        client_(cell_) {
    runtime::RunningCell& running = cell_.cell();
    const auto camera = runtime::usual_camera();
    running.open_camera(0, {"eye", camera, 0.025}, running.table()->pictures(camera, [&running] {
      return running.robots_in_view(runtime::RunningCell::Stand::kTrue);
    }));
  }
  ApiCell& cell() { return cell_; }
  ApiClient& client() { return client_; }

  void aside() {
    ASSERT_EQ(client_.sentence("lease.take", {{"robot", "left"}}), "");
    ASSERT_EQ(client_.sentence("robot.enable", {{"robot", "left"}}), "");
    ASSERT_EQ(client_.run("left", kAside)["phase"], "done");
  }
  /// A picture with so many cubes in it.
  Json look(std::size_t cubes) {
    Json shot;
    const bool came = cell_.until([&] {
      shot = client_.call("camera.look")["result"];
      return shot.contains("cubes") && shot["cubes"].size() == cubes;
    });
    EXPECT_TRUE(came) << shot["cubes"].dump();
    return shot;
  }

 private:
  ApiCell cell_;
  ApiClient client_;
};

TEST(ApiCubes, verdicts_say_which_can_be_had_and_why_others_not) {
  Cubes here;
  here.aside();
  here.look(3);
  const Json told = here.client().call("robot.cubes", {{"robot", "left"}})["result"];
  ASSERT_EQ(told["cubes"].size(), 3U) << told.dump();
  EXPECT_EQ(told["camera"], "eye");
  for (const Json& one : told["cubes"]) {
    const bool far = one["x_m"].get<double>() > 0.3;
    EXPECT_EQ(one["fine"].get<bool>(), !far) << one.dump();
    EXPECT_EQ(one.contains("error"), far);
    if (!far) continue;
    EXPECT_EQ(one["error"]["code"], "out_of_reach");
    EXPECT_NE(one["error"]["sentence"].get<std::string>().find("out of reach by"),
              std::string::npos);
    EXPECT_NE(one["help"].get<std::string>().find("nearer"), std::string::npos);
  }
  EXPECT_NE(
      here.client().sentence("robot.cubes", {{"robot", "left"}, {"camera", "ear"}}).find("eye"),
      std::string::npos);
}

TEST(ApiCubes, a_preview_shows_the_cubes_that_are_seen_and_their_way_into_the_basket) {
  Cubes here;
  here.aside();
  here.look(3);
  const Json shown =
      here.client().call("robot.preview", {{"robot", "left"}, {"text", kSort}, {"samples", 400}});
  ASSERT_TRUE(shown.contains("result")) << shown.dump();
  const Json& samples = shown["result"]["samples"];
  // Twice down to the table, and twice over the basket.
  int picks = 0, places = 0;
  bool low = false, over = false;
  for (const Json& tool : samples["tool"]) {
    const double x = tool[0], y = tool[1], z = tool[2];
    const bool is_low = z < 0.03;
    const bool is_over = std::hypot(x - 0.06, y - 0.18) < 0.06 && z < 0.1;
    picks += is_low && !low ? 1 : 0;
    places += is_over && !over ? 1 : 0;
    low = is_low;
    over = is_over;
  }
  EXPECT_EQ(picks, 2);
  EXPECT_EQ(places, 2);
  EXPECT_LT(shown["result"]["duration_s"].get<double>(), 120);
}

TEST(ApiCubes, where_cubes_can_be_taken_is_computed_while_a_client_asks) {
  Cubes here;
  Json reach;
  const bool whole = here.cell().until([&] {
    reach = here.client().call("robot.cube_reach", {{"robot", "left"}})["result"];
    return reach["done"] == 1;
  });
  ASSERT_TRUE(whole) << reach["done"].dump();
  const auto at = [&](double x, double y) {
    const double step = reach["step_m"];
    const auto column =
        static_cast<std::size_t>(std::lround((x - reach["x_m"].get<double>()) / step));
    const auto row = static_cast<std::size_t>(std::lround((y - reach["y_m"].get<double>()) / step));
    return reach["rows"][row].get<std::string>()[column];
  };
  EXPECT_EQ(at(0.17, -0.02), 't');
  EXPECT_EQ(at(0.33, 0.05), '-');
  EXPECT_EQ(at(-0.3, 0), '-');
  for (const Json& row : reach["rows"]) {
    EXPECT_EQ(row.get<std::string>().find('.'), std::string::npos);
  }
  EXPECT_EQ(here.client().sentence("robot.cube_reach", {{"robot", "left"}, {"edge_m", 1}}),
            "edge_m has to be 0.005 to 0.2");
}

TEST(ApiCubes, a_basket_is_moved_and_kept_and_programs_find_it_there) {
  const sinew::test::ScratchFolder folder;
  runtime::CellFolders folders;
  folders.baskets = folder.at("cell.baskets.json");
  {
    Cubes here(folders);
    here.aside();
    ApiClient& client = here.client();
    const Json moved =
        client.call("basket.move", {{"basket", "tray"}, {"x_m", 0.02}, {"y_m", 0.2}});
    ASSERT_TRUE(moved.contains("result")) << moved.dump();
    EXPECT_EQ(moved["result"]["basket"]["y_m"], 0.2);
    EXPECT_TRUE(moved["result"]["warnings"].empty()) << moved.dump();
    EXPECT_EQ(client.call("cell.describe")["result"]["baskets"][0]["x_m"], 0.02);
    EXPECT_EQ(here.look(3)["baskets"][0]["y_m"], 0.2);
    ASSERT_EQ(client.run("left", std::string(kSort))["phase"], "done");
    // As they really lie: one may hide another from the camera.
    std::ptrdiff_t in = 0;
    here.cell().cell().table()->cubes().with([&](const sim::CubeWorld& world) {
      in = std::ranges::count(world.cubes(), sim::CubePlace::kBasket, &sim::CubeState::where);
    });
    EXPECT_EQ(in, 2);
    const Json far = client.call("basket.move", {{"basket", "tray"}, {"x_m", 1}, {"y_m", 0}});
    ASSERT_TRUE(far.contains("result")) << far.dump();
    ASSERT_EQ(far["result"]["warnings"].size(), 1U);
    EXPECT_EQ(far["result"]["warnings"][0]["robot"], "left");
    EXPECT_EQ(far["result"]["warnings"][0]["error"]["code"], "basket_out_of_reach");
  }
  Cubes again(folders);
  EXPECT_EQ(again.client().call("cell.describe")["result"]["baskets"][0]["x_m"], 1);
}

TEST(ApiCubes, a_basket_stays_while_a_program_handles_cubes) {
  Cubes here;
  here.aside();
  ApiClient& client = here.client();
  const Json begun =
      client.call("program.run", {{"robot", "left"}, {"text", kSort}, {"name", "sort"}});
  ASSERT_TRUE(begun.contains("result")) << begun.dump();
  const Json params{{"basket", "tray"}, {"x_m", 0.1}, {"y_m", 0.2}};
  EXPECT_EQ(client.sentence("basket.move", params),
            "'sort' handles cubes on left: stop it or wait for its end, then move the basket");
  EXPECT_EQ(client.sentence("basket.move", {{"basket", "box"}, {"x_m", 0}, {"y_m", 0}}),
            "no basket of this cell has that name; there are tray");
  client.call("robot.stop", {{"robot", "left"}});
  client.finish("left");
  EXPECT_EQ(client.sentence("basket.move", params), "");
  ApiClient viewer(here.cell(), Role::kViewer);
  EXPECT_NE(viewer.sentence("basket.move", params), "");
}

TEST(ApiCubes, what_happens_to_a_simulated_camera_is_in_its_pictures) {
  Cubes here;
  here.aside();
  here.look(3);
  ApiClient& client = here.client();
  const auto shown = [&](const char* trouble, const auto& is_so) {
    ASSERT_EQ(client.sentence("simulation.camera", {{"trouble", trouble}}), "");
    Json shot;
    EXPECT_TRUE(here.cell().until([&] {
      shot = client.call("camera.look")["result"];
      return shot["trouble"] == trouble && is_so(shot);
    })) << trouble
        << shot["fault"].dump();
  };
  const auto code = [](const Json& shot) {
    return shot.contains("fault") ? shot["fault"]["code"].get<std::string>() : "none";
  };
  shown("unplugged", [&](const Json& shot) { return code(shot) == "camera_lost"; });
  shown("covered", [&](const Json& shot) { return code(shot) == "camera_blind"; });
  shown("hand", [&](const Json& shot) { return code(shot) == "none"; });
  shown("none",
        [&](const Json& shot) { return code(shot) == "none" && shot["cubes"].size() == 3; });
  EXPECT_EQ(client.sentence("simulation.camera", {{"trouble", "fog"}}),
            "trouble has to be none, hand, covered, unplugged or frozen");
  ApiClient viewer(here.cell(), Role::kViewer);
  EXPECT_NE(viewer.sentence("simulation.camera", {{"trouble", "covered"}}), "");
}

TEST(ApiCubes, those_who_draw_the_cell_hear_of_a_basket_that_was_moved) {
  Cubes here;
  ApiClient& client = here.client();
  client.call("objects.subscribe", {{"objects", {"cell"}}, {"rate_hz", 50}});
  ASSERT_EQ(client.sentence("basket.move", {{"basket", "tray"}, {"x_m", 0.1}, {"y_m", 0.1}}), "");
  const bool told = here.cell().until([&] {
    client.call("cell.status");
    return std::ranges::any_of(client.messages(), [](const Json& one) {
      return one["method"] == "objects" && one["params"]["objects"].contains("cell") &&
             one["params"]["objects"]["cell"]["baskets"][0]["x_m"] == 0.1;
    });
  });
  EXPECT_TRUE(told);
}

}  // namespace
}  // namespace sinew::server
