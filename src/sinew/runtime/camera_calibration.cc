#include "sinew/runtime/camera_calibration.h"

#include <algorithm>
#include <chrono>
#include <utility>

#include "sinew/calibration/robot_tip.h"
#include "sinew/config/camera_file.h"
#include "sinew/core/error_code.h"
#include "sinew/io/clock.h"
#include "sinew/io/file.h"
#include "sinew/model/error_sentence.h"
#include "sinew/model/hand.h"
#include "sinew/program/plans/cube_rows.h"
#include "sinew/runtime/cameras/camera_place.h"

namespace sinew::runtime {
namespace {

/// A camera that gives nothing says so itself; this is for a computer that does much else.
constexpr Duration kPatience = std::chrono::seconds(60);
constexpr Duration kTurn = std::chrono::milliseconds(5);

std::unexpected<CameraCalibration::Refusal> refused(std::string code, std::string sentence) {
  return std::unexpected(CameraCalibration::Refusal{std::move(code), std::move(sentence)});
}

struct ToolAtRest {
  JointVector q;
  calibration::TouchTool tool;
};

/// Of a tool that has one tip, which rests.
/// @param pin  m, that stands out of it
std::expected<ToolAtRest, CameraCalibration::Refusal> tool_at_rest(const Station& station,
                                                                   double pin) {
  using control::MachineState;
  constexpr double kClosed = 2e-3;    // m
  constexpr double kPinMost = 12e-3;  // m: jaws that measure it have a pin between them
  const RobotModel& model = station.robot();
  if (std::holds_alternative<HexapodGeometry>(model.geometry)) {
    return refused("no_tip", station.name() + " is a platform: it has no tip to touch marks with.");
  }
  const StationView view = station.view();
  if (view.state == MachineState::kMoving || view.state == MachineState::kStopping ||
      view.state == MachineState::kRecovering) {
    return refused("moves", station.name() + " moves. Wait until it is at rest.");
  }
  ToolAtRest at;
  for (const JointPosition& joint : view.positions) {
    if (joint.quality >= PositionQuality::kCommanded) at.q.push_back(joint.q);
  }
  if (at.q.size() != model.joints.size()) {
    return refused("position_unknown", "It is not known where " + station.name() +
                                           " stands. Enable it, home it in Setup, then touch "
                                           "the mark.");
  }
  if (jaws_of(model) == nullptr) return at;
  at.tool.jaws = view.tool.jaws.value_or(kPinMost + kClosed);
  if (at.tool.jaws <= (pin > 0 ? kPinMost : kClosed)) return at;
  return refused("jaws_open",
                 "The jaws of " + station.name() +
                     " are not closed. Close them on the pin, so that the tool has one tip, then "
                     "touch the mark.");
}

bool lift_from(calibration::SheetTouches& touches, std::string_view mark) {
  return std::erase_if(touches.marks, [&](const auto& one) { return one.mark == mark; }) > 0;
}

}  // namespace

std::optional<CameraCalibration> CameraCalibration::begin(RunningCell& cell, std::size_t camera,
                                                          const std::string& paper) {
  auto views = calibration::BoardViews::of(paper);
  if (!views) return std::nullopt;
  return CameraCalibration(cell, camera, std::move(*views));
}

CameraCalibration::CameraCalibration(RunningCell& cell, std::size_t camera,
                                     calibration::BoardViews views)
    : cell_(&cell), camera_(camera), views_(std::move(views)), result_(views_.result()) {
  show();
}

CameraCalibration::CameraCalibration(CameraCalibration&& other) noexcept
    : cell_(std::exchange(other.cell_, nullptr)),
      camera_(other.camera_),
      views_(std::move(other.views_)),
      result_(std::move(other.result_)),
      touches_(std::move(other.touches_)),
      touched_(std::move(other.touched_)),
      step_(other.step_),
      pose_(other.pose_) {}

CameraCalibration::~CameraCalibration() {
  const bool shows = cell_ != nullptr && cell_->cell().cameras[camera_].device == kSimulatedCamera;
  if (shows) cell_->table()->show(std::nullopt);
}

void CameraCalibration::show() {
  if (cell_->cell().cameras[camera_].device != kSimulatedCamera) return;
  const bool holds = step_ == Step::kBoard;
  cell_->table()->show(SimulatedTable::Shown{.camera = camera_,
                                             .board = holds ? views_.board() : views_.sheet(),
                                             .pose = holds ? std::optional(pose_) : std::nullopt});
}

void CameraCalibration::expect(Step step) {
  step_ = step;
  show();
}

std::expected<vision::Picture, CameraCalibration::Refusal> CameraCalibration::picture() {
  fault_.reset();
  Camera& camera = *cell_->camera(camera_);
  const io::Clock clock;
  const Instant end = clock.now() + kPatience;
  const std::uint64_t wanted = camera.ask();
  auto shot = camera.newest();
  while ((!shot || shot->number < wanted) && clock.now() < end) {
    clock.pause(kTurn);
    shot = camera.newest();
  }
  if (!shot || shot->number < wanted) {
    return std::unexpected(Refusal{
        "no_picture", camera.name() + " has given no picture. Check the camera and its cable."});
  }
  // A picture of another size, or one without the sheet, is what a calibration begins with.
  const bool says_nothing =
      shot->fault && (shot->picture.width == 0 || shot->fault->code == ErrorCode::kCameraBlind ||
                      shot->fault->code == ErrorCode::kCameraFrozen);
  if (says_nothing) {
    fault_ = shot->fault;
    return std::unexpected(
        Refusal{"no_picture", sentence_of(*shot->fault, cell_->station(0).robot())});
  }
  return shot->picture;
}

std::expected<calibration::TakenView, CameraCalibration::Refusal> CameraCalibration::take() {
  const auto taken = picture();
  if (!taken) return std::unexpected(taken.error());
  auto view = step_ == Step::kBoard ? views_.add(*taken) : views_.lay(*taken);
  if (view && step_ != Step::kBoard) touches_.reset();  // the sheet may lie elsewhere now
  // A person takes the board to its next pose, also where this one was no good.
  if (step_ == Step::kBoard) {
    ++pose_;
    show();
  }
  if (view) result_ = views_.result();
  return view;
}

bool CameraCalibration::drop(std::uint64_t view) {
  if (!views_.drop(view)) return false;
  result_ = views_.result();
  return true;
}

std::expected<void, CameraCalibration::Refusal> CameraCalibration::touch(std::size_t robot,
                                                                         std::string_view mark,
                                                                         double pin) {
  const std::vector<vision::BoardMark> marks = marks_of(views_.sheet());
  const auto known = std::ranges::find(marks, mark, &vision::BoardMark::name);
  if (known == marks.end()) {
    std::string names;
    for (const vision::BoardMark& one : marks) names += (names.empty() ? "" : ", ") + one.name;
    return refused("unknown_mark", "The sheet has no such mark; its marks are " + names + ".");
  }
  const Station& station = cell_->station(robot);
  auto at = tool_at_rest(station, pin);
  if (!at) return std::unexpected(at.error());
  at->tool.pin = pin;
  if (touches_ && touches_->robot != station.name()) {
    return refused("other_robot", "The other marks were touched by " + touches_->robot +
                                      ". Go on with it, or delete these marks.");
  }
  if (!touches_) {
    touches_ = calibration::SheetTouches{
        .model = station.robot(),
        .robot = station.name(),
        .up = transposed_times(cell_->cell().robots[robot].X_WB.R, Vec3{0, 0, 1}),
        .sheet = views_.sheet(),
        .marks = {}};
  }
  touches_->tool = at->tool;
  lift_from(*touches_, mark);
  touches_->marks.push_back(
      {known->name, known->p_B, "", at->q, calibration::tip_at(station.robot(), at->q, at->tool)});
  touched_ = calibration::touched_sheet(*touches_);
  return {};
}

Pose<frame::World, frame::Table> CameraCalibration::table_in(const Cell& cell) const {
  vision::TableCamera by;
  if (touches_ && touched_) by.touched = {touches_->robot, touched_->frame.X_BW, touched_->error};
  return table_of(cell, cell.cameras[camera_], &by);
}

bool CameraCalibration::lift(std::string_view mark) {
  if (!touches_ || !lift_from(*touches_, mark)) return false;
  if (touches_->marks.empty()) {
    touches_.reset();
  } else {
    touched_ = calibration::touched_sheet(*touches_);
  }
  return true;
}

std::expected<CameraCalibration::Saved, CameraCalibration::Refusal> CameraCalibration::save(
    bool sheet_stays) {
  Camera& camera = *cell_->camera(camera_);
  if (!result_.camera) {
    return std::unexpected(Refusal{
        "unfinished", result_.trouble ? sentence(*result_.trouble)
                                      : "The calibration has no result yet: it needs " +
                                            std::to_string(calibration::BoardViews::kViewsLeast) +
                                            " views of the board and one of the sheet."});
  }
  if (camera.calibration_file().empty()) {
    return std::unexpected(Refusal{
        "no_file", "This cell was not read from a file, so there is no place for a calibration."});
  }
  if (touches_ && !touched_) {
    return refused("touches",
                   "The marks that were touched do not say where the sheet lies. Touch more of "
                   "them, or delete them.");
  }
  vision::TableCamera calibrated = result_.camera->camera;
  if (touches_) {
    calibrated.touched = {touches_->robot, touched_->frame.X_BW, touched_->error};
  }
  calibrated.name = camera.name();
  calibrated.identity = camera.identity();
  if (!sheet_stays) calibrated.sheet.clear();
  const auto written = io::replace_file(camera.calibration_file(), camera_text(calibrated));
  if (!written) return std::unexpected(Refusal{"not_written", written.error().sentence});
  cell_->calibrate(camera_, calibrated);
  if (cell_->cell().cameras[camera_].device == kSimulatedCamera) {
    cell_->table()->leave_sheet(calibrated.sheet);
  }
  return Saved{camera.calibration_file(), calibrated.accuracy, sheet_stays};
}

}  // namespace sinew::runtime
