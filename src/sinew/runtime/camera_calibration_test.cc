#include "sinew/runtime/camera_calibration.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <deque>
#include <filesystem>

#include "sinew/calibration/robot_tip.h"
#include "sinew/config/camera_file.h"
#include "sinew/core/error_code.h"
#include "sinew/core/units.h"
#include "sinew/io/file.h"
#include "sinew/program/language/program_file.h"
#include "sinew/runtime/cameras/camera_identity.h"
#include "sinew/runtime/cameras/shown_board.h"
#include "sinew/runtime/links/robot_variant.h"
#include "support/robots.h"
#include "support/scratch_folder.h"

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

std::string code_of(const std::expected<void, CameraCalibration::Refusal>& touched) {
  return touched ? "" : touched.error().code;
}

/// The arm of the cell by a program, from rest to rest.
void run(RunningCell& cell, const std::string& rows) {
  auto parsed = program::parse(rows, "test.sinew", cell.station(0).robot());
  ASSERT_TRUE(parsed) << to_text(parsed.error().front());
  JobOrder order;
  order.title = "test";
  order.program = std::move(*parsed);
  order.take_over = true;
  order.on_client_loss = ClientLoss::kContinue;
  ASSERT_TRUE(cell.jobs(0).start(std::move(order), 1));
  const io::Clock clock;
  for (int i = 0; i < 6000 && !cell.jobs(0).view().over; ++i) {
    clock.pause(std::chrono::milliseconds(5));
  }
  const JobView job = cell.jobs(0).view();
  EXPECT_EQ(job.phase, program::Run::Phase::kDone)
      << rows << (job.failure ? describe(job.failure->error) : "");
}

TEST(CameraCalibration, marks_that_a_tool_touches_say_where_the_sheet_lies) {
  SimulatedCell simulated;
  RunningCell& cell = simulated.cell();
  auto one = CameraCalibration::begin(cell, 0, "a4");
  ASSERT_TRUE(one);
  EXPECT_EQ(code_of(one->touch(0, "cross9", 0)), "unknown_mark");
  run(cell, "jaws 40mm\n");
  EXPECT_EQ(code_of(one->touch(0, "cross1", 0)), "jaws_open");
  EXPECT_EQ(one->touches(), nullptr);
  run(cell, "joint base=0deg shoulder=0deg elbow=45deg wrist=45deg roll=0deg\njaws 0mm\n");
  // The sheet lies elsewhere than the cell's file says: turned, in front of the arm.
  constexpr double kPin = 0.03;  // m
  const Pose<frame::Base, frame::World> X_BS{rotation_z(-kPi / 2), {0.23, 0.004, 0}};
  const RobotModel& arm = cell.station(0).robot();
  const auto marks = marks_of(*vision::table_sheet("a4"));
  for (const std::string name : {"cross1", "cross2", "cross5", "tag582"}) {
    const auto mark = std::ranges::find(marks, name, &vision::BoardMark::name);
    const auto q = calibration::joints_for_tip(arm, {0, kPin}, X_BS * mark->p_B, Vec3{0, 0, -1});
    ASSERT_TRUE(q) << name;
    std::string row = "joint";
    for (std::size_t j = 0; j < q->size(); ++j) {
      row += " " + arm.joints[j].name + "=" + std::to_string(to_deg((*q)[j])) + "deg";
    }
    run(cell, row + "\n");
    const auto touched = one->touch(0, name, kPin);
    ASSERT_TRUE(touched) << touched.error().sentence;
  }
  ASSERT_TRUE(one->touched()) << one->touched().error().sentence;
  // Servos stand beside where they were sent.
  const auto X_WT = one->table_in(cell.cell());
  EXPECT_LT(norm(X_WT.p - X_BS.p), 0.012);
  EXPECT_LT(angle_between(X_WT.R, relabel<frame::World, frame::Table>(X_BS).R), from_deg(3));
  EXPECT_TRUE(one->lift("cross1"));
  EXPECT_FALSE(one->lift("cross1"));
  EXPECT_TRUE(one->lift("cross2"));
  ASSERT_FALSE(one->touched());
  EXPECT_EQ(one->touched().error().kind, calibration::TouchRefusal::Kind::kTooFew);
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
