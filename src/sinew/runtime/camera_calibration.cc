#include "sinew/runtime/camera_calibration.h"

#include <chrono>
#include <utility>

#include "sinew/config/camera_file.h"
#include "sinew/io/clock.h"
#include "sinew/io/file.h"
#include "sinew/model/error_sentence.h"

namespace sinew::runtime {
namespace {

/// A camera that gives nothing says so itself; this is for a computer that does much else.
constexpr Duration kPatience = std::chrono::seconds(60);
constexpr Duration kTurn = std::chrono::milliseconds(5);

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
  vision::TableCamera calibrated = result_.camera->camera;
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
