#include "sinew/runtime/camera_calibration.h"

#include <gtest/gtest.h>

#include <deque>
#include <filesystem>

#include "sinew/config/camera_file.h"
#include "sinew/core/units.h"
#include "sinew/io/file.h"
#include "sinew/io/scratch_folder_test_support.h"
#include "sinew/runtime/camera_identity.h"
#include "sinew/runtime/robot_variant.h"
#include "sinew/runtime/shown_board.h"
#include "support/robots.h"

namespace sinew::runtime {
namespace {

using Step = CameraCalibration::Step;

/// A cell with a simulated camera, which keeps its calibration in a folder of the test.
class SimulatedCell {
 public:
  SimulatedCell() {
    Cell cell{.title = "test",
              .time_scale = 20,
              .robots = {},
              .objects = {},
              .cameras = {},
              .baskets = {},
              .cubes = {{.color = 0, .p_W = {0.3, 0.2, 0}, .turn = 0}}};
    cell.robots.push_back({});
    cell.robots[0].name = "left";
    cell.robots[0].robot = "learm";
    cell.cameras.push_back({.name = "eye",
                            .device = std::string(kSimulatedCamera),
                            .calibration = std::nullopt,
                            .cube = 0.025,
                            .X_WT = {Rotation{}, {0.4, 0.2, 0}}});
    auto model = variant_of(sinew::test::robot("learm"), "bus", std::nullopt);
    auto running = RunningCell::start(std::move(cell), {*model}, {});
    EXPECT_TRUE(running);
    cell_ = std::move(*running);
    Camera::Settings settings{.name = "eye",
                              .calibration = std::nullopt,
                              .edge = 0.025,
                              .identity = "simulated",
                              .calibration_file = file()};
    cell_->open_camera(0, std::move(settings), cell_->table()->pictures(usual_camera(), [this] {
      return cell_->robots_in_view(RunningCell::Stand::kTrue);
    }));
  }
  RunningCell& cell() { return *cell_; }
  std::string file() const { return folder_.at("camera-eye.toml"); }

 private:
  sinew::test::ScratchFolder folder_;
  std::unique_ptr<RunningCell> cell_;
};

std::string code_of(const std::expected<calibration::TakenView, CameraCalibration::Refusal>& took) {
  return took ? "" : took.error().code;
}

TEST(CameraCalibration, of_a_simulated_camera_finds_where_it_hangs) {
  SimulatedCell simulated;
  auto one = CameraCalibration::begin(simulated.cell(), 0, "a4");
  ASSERT_TRUE(one);
  EXPECT_EQ(one->save(true).error().code, "unfinished") << "nothing was shown";
  for (int i = 0; i < 8; ++i) {
    const auto took = one->take();
    ASSERT_TRUE(took) << i << ": " << took.error().sentence;
    EXPECT_EQ(took->number, static_cast<std::uint64_t>(i + 1));
  }
  EXPECT_EQ(one->result().residuals.size(), 8U);
  EXPECT_FALSE(one->result().camera) << "no sheet yet";
  EXPECT_EQ(one->save(true).error().code, "unfinished");
  one->expect(Step::kSheet);
  const auto sheet = one->take();
  ASSERT_TRUE(sheet) << sheet.error().sentence;
  EXPECT_EQ(sheet->tags, 4U);
  ASSERT_TRUE(one->result().camera);
  const vision::TableCamera& found = one->result().camera->camera;
  const vision::TableCamera real = usual_camera();
  EXPECT_LT(found.accuracy, 0.002);
  EXPECT_NEAR(found.model.fx, real.model.fx, 0.02 * real.model.fx);
  EXPECT_LT(norm(found.X_WC.p - real.X_WC.p), 0.01);
  for (const Vec3 p : {Vec3{0.1, 0.1, 0}, Vec3{-0.1, 0.1, 0}, Vec3{0, 0, 0}, Vec3{0.1, -0.1, 0}}) {
    const auto pixel = real.model.project(real.X_WC.inverse() * p);
    EXPECT_LT(norm(*vision::on_plane(found, *pixel, 0) - p), 0.002);
  }
  const auto saved = one->save(true);
  ASSERT_TRUE(saved) << saved.error().sentence;
  EXPECT_EQ(saved->file, simulated.file());
  const auto kept = read_camera(*io::read_file(simulated.file()), "camera-eye.toml");
  ASSERT_TRUE(kept) << to_text(kept.error().front());
  EXPECT_EQ(kept->name, "eye");
  EXPECT_EQ(kept->identity, "simulated");
  EXPECT_EQ(kept->sheet, "a4");
  EXPECT_EQ(kept->model.width, 640);
  // Seen by from then on, with the sheet on the table.
  ASSERT_TRUE(simulated.cell().camera(0)->calibration());
  EXPECT_EQ(simulated.cell().camera(0)->calibration()->accuracy, found.accuracy);
}

TEST(CameraCalibration, a_view_without_the_board_is_refused_and_drop_removes_one) {
  SimulatedCell simulated;
  auto one = CameraCalibration::begin(simulated.cell(), 0, "a4");
  ASSERT_TRUE(one->take());
  EXPECT_FALSE(one->drop(7));
  EXPECT_TRUE(one->drop(1));
  EXPECT_TRUE(one->views().views().empty());
  ASSERT_TRUE(one->take());
  EXPECT_EQ(one->views().views().front().number, 2U) << "no number is used twice";
  simulated.cell().table()->show(std::nullopt);
  // One tag is found in the grain of this table.
  const std::string bare = code_of(one->take());
  EXPECT_TRUE(bare == "no_board" || bare == "few_tags") << bare;
  simulated.cell().table()->show(std::nullopt);
  one->expect(Step::kSheet);
  simulated.cell().table()->show(std::nullopt);
  EXPECT_EQ(code_of(one->take()), "no_sheet");
  SimulatedTable::Trouble trouble;
  trouble.unplugged = true;
  simulated.cell().table()->set_trouble(trouble);
  EXPECT_EQ(code_of(one->take()), "no_picture");
  EXPECT_EQ(one->fault()->code, ErrorCode::kCameraLost);
  EXPECT_FALSE(CameraCalibration::begin(simulated.cell(), 0, "a5"));
}

TEST(CameraCalibration, a_file_that_cannot_be_written_is_said) {
  SimulatedCell simulated;
  auto one = CameraCalibration::begin(simulated.cell(), 0, "a4");
  for (int i = 0; i < 5; ++i) ASSERT_TRUE(one->take());
  one->expect(Step::kSheet);
  ASSERT_TRUE(one->take());
  std::filesystem::create_directory(simulated.file());
  const auto saved = one->save(true);
  ASSERT_FALSE(saved);
  EXPECT_EQ(saved.error().code, "not_written");
  EXPECT_NE(saved.error().sentence.find(simulated.file()), std::string::npos);
  EXPECT_FALSE(simulated.cell().camera(0)->calibration()) << "what is not kept does not count";
}

TEST(HeldBoard, is_above_the_table_and_the_same_again) {
  const auto board = vision::calibration_board("a4");
  for (std::uint64_t pose = 0; pose < 40; ++pose) {
    const auto X_WP = held_board(usual_camera(), *board, pose);
    EXPECT_EQ(X_WP.p, held_board(usual_camera(), *board, pose).p);
    for (const double x : {-0.5, 0.5}) {
      for (const double y : {-0.5, 0.5}) {
        EXPECT_GT((X_WP * Vec3{x * board->width, y * board->height, 0}).z, 0.005) << pose;
      }
    }
  }
  EXPECT_FALSE(held_board(usual_camera(), *board, 0).p == held_board(usual_camera(), *board, 12).p);
}

TEST(CameraIdentity, names_no_password) {
  EXPECT_EQ(camera_identity("http://me:secret@10.0.0.7:8080/video"), "http://10.0.0.7:8080/video");
  EXPECT_EQ(camera_identity("http://10.0.0.7/a@b"), "http://10.0.0.7/a@b");
  EXPECT_EQ(camera_identity("simulated"), "simulated");
  EXPECT_EQ(camera_identity("table.jpg"), "table.jpg");
  EXPECT_EQ(camera_identity("/dev/no_such_camera"), "");
}

}  // namespace
}  // namespace sinew::runtime
