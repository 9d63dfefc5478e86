#pragma once

#include <cstdint>
#include <expected>
#include <optional>
#include <string>
#include <string_view>

#include "sinew/calibration/board_views.h"
#include "sinew/calibration/sheet_touches.h"
#include "sinew/runtime/running_cell.h"

namespace sinew::runtime {

/// The calibration of one camera of a running cell, step by step: views of a printed board, a view
/// of the sheet on the table, marks of the sheet that a robot's tool touches, a file. Takes its
/// time; for one thread, which no robot waits for.
class CameraCalibration {
 public:
  using Refusal = calibration::ViewRefusal;
  enum class Step : std::uint8_t { kBoard, kSheet, kTouch };
  struct Saved {
    std::string file;
    double accuracy = 0;      ///< m at the table, 95 %
    bool sheet_stays = true;  ///< on the table, so that a camera that was moved is noticed
  };

  /// In front of a simulated camera a person shows the board from now on, until this ends.
  /// @param cell  outlives this  @param camera  of the cell's, opened
  /// @return  nothing for a paper that is none of a4, a3 and letter
  static std::optional<CameraCalibration> begin(RunningCell& cell, std::size_t camera,
                                                const std::string& paper);
  CameraCalibration(CameraCalibration&& other) noexcept;
  CameraCalibration& operator=(CameraCalibration&&) = delete;
  ~CameraCalibration();

  std::size_t camera() const { return camera_; }
  const std::string& paper() const { return views_.board().paper; }
  const calibration::BoardViews& views() const { return views_; }
  const calibration::ViewsResult& result() const { return result_; }
  /// What the next view shows.
  Step step() const { return step_; }
  void expect(Step step);
  /// Takes a picture and looks for the board or the sheet in it.
  /// @error  of the camera, code "no_picture"; those of BoardViews
  std::expected<calibration::TakenView, Refusal> take();
  /// Of the camera, where the last take() had no picture for that reason.
  const std::optional<Error>& fault() const { return fault_; }
  bool drop(std::uint64_t view);
  /// The tip of a robot's tool is on a mark of the sheet; once more where it was before.
  /// @param robot  of the cell's
  /// @param pin    m, that stands out of its tool
  /// @error  codes "unknown_mark", "no_tip", "moves", "position_unknown", "jaws_open",
  /// "other_robot"
  std::expected<void, Refusal> touch(std::size_t robot, std::string_view mark, double pin);
  /// Forgets that a mark was touched. @return  whether it was
  bool lift(std::string_view mark);
  /// Null: no mark was touched.
  const calibration::SheetTouches* touches() const { return touches_ ? &*touches_ : nullptr; }
  /// Where the sheet lies: by the touches, else as the cell's file says.
  Pose<frame::World, frame::Table> table_in(const Cell& cell) const;
  /// What the touches say. @pre some mark was touched
  const std::expected<calibration::TouchedSheet, calibration::TouchRefusal>& touched() const {
    return touched_;
  }
  /// Writes the camera's file; the camera sees by it from its next picture on.
  /// @error  codes "unfinished", "touches", "no_file", "not_written"
  std::expected<Saved, Refusal> save(bool sheet_stays);

 private:
  CameraCalibration(RunningCell& cell, std::size_t camera, calibration::BoardViews views);
  void show();
  std::expected<vision::Picture, Refusal> picture();

  RunningCell* cell_;  ///< null: moved from
  std::size_t camera_;
  calibration::BoardViews views_;
  calibration::ViewsResult result_;
  std::optional<calibration::SheetTouches> touches_;
  std::expected<calibration::TouchedSheet, calibration::TouchRefusal> touched_;
  Step step_ = Step::kBoard;
  std::optional<Error> fault_;
  std::uint64_t pose_ = 0;  ///< in which the board is shown to a simulated camera
};

}  // namespace sinew::runtime
