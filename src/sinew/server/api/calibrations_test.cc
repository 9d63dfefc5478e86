#include <gtest/gtest.h>

#include <memory>
#include <mutex>

#include "sinew/render/cell_scene.h"
#include "sinew/server/api/api_test_cell.h"
#include "support/scratch_folder.h"

namespace sinew::server {
namespace {

using test::ApiCell;
using test::ApiClient;
using test::place;

/// A cell with a camera in front of which the test holds things.
class HeldCell {
 public:
  HeldCell() : cell_({place("left", "learm", "bus")}, 20, {}, {}, nullptr, {}, table()) {
    runtime::Camera::Settings settings{.name = "top",
                                       .calibration = std::nullopt,
                                       .edge = 0.025,
                                       .identity = "camera of the test",
                                       .calibration_file = folder_.at("top.toml")};
    cell_.cell().open_camera(0, std::move(settings), [this](const std::stop_token&) {
      const std::scoped_lock lock(mutex_);
      // No two pictures are the same to the last bit.
      auto picture = held_;
      picture.rgb[0] = static_cast<std::uint8_t>(++taken_);
      return Expected<vision::Picture>(std::move(picture));
    });
  }
  ApiCell& cell() { return cell_; }
  std::string file() const { return folder_.at("top.toml"); }

  void hold(const std::optional<vision::TagBoard>& board, double aside, double turn,
            int width = 640) {
    render::CellView view;
    if (board) view.sheets.push_back({*board, {}, nullptr});
    // A bare table shows nothing that can be told apart.
    for (const double x : {-0.14, 0.0, 0.14}) {
      view.clutter.push_back({render::ViewedThing::Form::kBox,
                              {Rotation{}, {x, 0.16, 0.01}},
                              {0.03, 0.02, 0.01},
                              0x203060});
    }
    view.reach = 0.2;
    const Vec3 eye{0.5 * std::sin(aside) * std::cos(turn), 0.5 * std::sin(aside) * std::sin(turn),
                   0.5 * std::cos(aside)};
    auto picture = picture_of(view, vision::pinhole(width, 3 * width / 4, from_deg(50)),
                              render::looking_at(eye, {}), {}, 1);
    const std::scoped_lock lock(mutex_);
    held_ = std::move(picture);
  }
  void hold_board(int pose, int width = 640) {
    hold(vision::calibration_board("a4"), 0.12 * pose, 1.3 * pose, width);
  }
  void lay_sheet() { hold(vision::table_sheet("a4"), 0.2, 1); }

 private:
  static Cell table() {
    Cell cell;
    CellCamera& camera = cell.cameras.emplace_back();
    camera.name = "top";
    camera.device = "held";
    camera.X_WT.p = {0.2, 0, 0};
    return cell;
  }

  sinew::test::ScratchFolder folder_;
  std::mutex mutex_;
  vision::Picture held_ = vision::black_picture(640, 480);
  int taken_ = 0;
  ApiCell cell_;
};

const std::string kTake = "camera.calibration.take";

TEST(Calibrations, steps_out_of_order_are_refused_with_what_to_do) {
  HeldCell held;
  ApiClient client(held.cell());
  EXPECT_EQ(client.call("camera.calibration.status")["result"]["under_way"], false);
  const std::string none =
      "No calibration of top is under way. Begin one: camera.calibration.begin.";
  EXPECT_EQ(client.sentence(kTake), none);
  EXPECT_EQ(client.sentence("camera.calibration.save"), none);
  EXPECT_EQ(client.sentence("camera.calibration.end"), none);
  EXPECT_EQ(client.sentence("camera.calibration.begin", {{"paper", "a5"}}),
            "paper has to be a4, a3 or letter");
  EXPECT_NE(client.sentence("camera.calibration.begin", {{"camera", "eye"}}).find("there are top"),
            std::string::npos);
  EXPECT_EQ(client.call("camera.calibration.begin")["result"]["step"], "board");
  EXPECT_NE(client.sentence("camera.calibration.save").find("no result yet"), std::string::npos);
  EXPECT_EQ(client.sentence("camera.calibration.expect", {{"step", "table"}}),
            "step has to be board, sheet or touch");
  EXPECT_EQ(client.sentence("camera.calibration.drop", {{"view", 3}}),
            "There is no view 3 (any more).");
  EXPECT_EQ(client.sentence("camera.calibration.drop"), "view or mark says what to remove");
  EXPECT_EQ(client.sentence("camera.calibration.drop", {{"mark", "cross1"}}),
            "This mark was not touched.");
  EXPECT_NE(client.sentence("camera.calibration.begin", {{"paper", "a3"}}).find("paper a4"),
            std::string::npos);
  held.hold(std::nullopt, 0.1, 0);
  EXPECT_NE(client.sentence(kTake).find("No tag of the board is seen"), std::string::npos);
  ApiClient viewer(held.cell(), Role::kViewer);
  EXPECT_NE(viewer.sentence(kTake).find("viewers watch"), std::string::npos);
  EXPECT_EQ(viewer.call("camera.calibration.status")["result"]["under_way"], true);
}

TEST(Calibrations, views_are_everybodys_and_outlive_a_client) {
  HeldCell held;
  Json begun;
  {
    ApiClient first(held.cell());
    begun = first.call("camera.calibration.begin")["result"];
    held.hold_board(1);
    const Json took = first.call(kTake, {{"session", begun["session"]}})["result"];
    EXPECT_EQ(took["taken"], 1);
    EXPECT_EQ(took["views"].size(), 1U);
    EXPECT_EQ(took["views"][0]["corners_px"].size(), took["views"][0]["tags"].get<std::size_t>());
    EXPECT_EQ(took["width_px"], 640);
    EXPECT_EQ(first.call(kTake)["error"]["data"]["code"], "same_view");
  }
  ApiClient second(held.cell());
  ApiClient third(held.cell());
  const Json again = second.call("camera.calibration.begin")["result"];
  EXPECT_EQ(again["session"], begun["session"]);
  EXPECT_EQ(again["views"].size(), 1U) << "a page that is loaded again goes on";
  held.hold_board(3, 320);
  EXPECT_EQ(second.call(kTake)["error"]["data"]["code"], "picture_size");
  // Begun again by one of two: the other hears of it.
  const Json anew = third.call("camera.calibration.begin", {{"anew", true}})["result"];
  EXPECT_TRUE(anew["views"].empty());
  EXPECT_EQ(second.call(kTake, {{"session", again["session"]}})["error"]["data"]["code"],
            "begun_again");
  held.hold_board(3);
  EXPECT_EQ(second.call(kTake, {{"session", anew["session"]}})["result"]["taken"], 1);
  third.call("camera.calibration.end");
  EXPECT_EQ(second.call(kTake)["error"]["data"]["code"], "not_begun");
}

TEST(Calibrations, to_the_end_the_camera_sees_by_it_without_a_restart) {
  HeldCell held;
  ApiClient client(held.cell());
  client.call("camera.calibration.begin");
  for (int pose = 0; pose < 6; ++pose) {
    held.hold_board(pose);
    const Json took = client.call(kTake);
    ASSERT_TRUE(took.contains("result")) << took.dump();
  }
  client.call("camera.calibration.expect", {{"step", "sheet"}});
  EXPECT_EQ(client.call(kTake)["error"]["data"]["code"], "no_sheet") << "the board lies there";
  held.lay_sheet();
  const Json state = client.call(kTake)["result"];
  ASSERT_TRUE(state.contains("result")) << state.dump();
  EXPECT_LT(state["result"]["table_error_m"].get<double>(), 0.004);
  EXPECT_TRUE(state["views"][0].contains("residual_px"));
  EXPECT_FALSE(client.call("cell.describe")["result"]["cameras"][0].contains("lens"));
  // Not while a program runs.
  const Json ran = client.call("program.run", {{"robot", "left"}, {"text", test::kStand}});
  ASSERT_TRUE(ran.contains("result")) << ran.dump();
  EXPECT_EQ(client.sentence("camera.calibration.save"),
            "'program' runs on left: stop the program, then save the calibration");
  client.finish("left");
  const Json saved = client.call("camera.calibration.save", {{"sheet_stays", false}})["result"];
  ASSERT_TRUE(saved.contains("saved")) << saved.dump();
  EXPECT_EQ(saved["saved"]["file"], held.file());
  EXPECT_EQ(saved["under_way"], false);
  const Json camera = client.call("cell.describe")["result"]["cameras"][0];
  EXPECT_EQ(camera["lens"]["accuracy_m"], saved["saved"]["table_error_m"]);
  // The eye of lay_sheet(), in the cell.
  EXPECT_NEAR(camera["lens"]["pose"]["x_m"].get<double>(),
              0.2 + 0.5 * std::sin(0.2) * std::cos(1.0), 0.01);
  EXPECT_NEAR(camera["lens"]["pose"]["z_m"].get<double>(), 0.5 * std::cos(0.2), 0.01);
}

TEST(Calibrations, tags_of_the_picture_and_sheets_to_print) {
  HeldCell held;
  ApiClient client(held.cell());
  held.lay_sheet();
  Json shot;
  EXPECT_TRUE(held.cell().until([&] {
    shot = client.call("camera.look", {{"tags", true}})["result"];
    return shot.contains("tags") && shot["tags"].size() == 4;
  }));
  EXPECT_EQ(shot["tags"][0]["id"], 580);
  const Json svg = client.call("camera.print", {{"what", "board"}})["result"]["text"];
  EXPECT_EQ(svg.get<std::string>().substr(0, 4), "<svg");
  const Json pdf =
      client.call("camera.print", {{"what", "sheet"}, {"form", "pdf"}})["result"]["text"];
  EXPECT_EQ(pdf.get<std::string>().substr(0, 5), "%PDF-");
  EXPECT_EQ(client.sentence("camera.print", {{"what", "table"}}), "what has to be board or sheet");
  EXPECT_EQ(client.sentence("camera.print", {{"what", "board"}, {"form", "png"}}),
            "form has to be svg or pdf");
}

}  // namespace
}  // namespace sinew::server
