#pragma once

#include <cstdint>
#include <expected>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "sinew/calibration/table_calibration.h"
#include "sinew/vision/tags.h"

namespace sinew::calibration {

/// Why a picture is no view to calibrate a camera with.
struct ViewRefusal {
  /// no_board, no_sheet, few_tags, blurred, same_view, picture_size, views_full
  std::string code;
  std::string sentence;  ///< with what to do

  /// The board or the camera has to be held differently; nothing is wrong with either.
  bool is_spare() const { return code == "blurred" || code == "same_view"; }
};

/// A picture of the board or of the sheet, and what was found in it.
struct TakenView {
  std::uint64_t number = 0;  ///< from 1 on; none is used twice
  BoardView seen;
  std::size_t tags = 0;
};

/// What the views show so far.
struct ViewsResult {
  Coverage coverage;
  std::optional<std::string> better;  ///< the view to add; nothing where the views suffice
  std::vector<double> residuals;      ///< px, rms, by view; empty without a lens
  double rms = 0;                     ///< px, of all of them
  /// With the sheet and five views.
  std::optional<TableCalibration> camera;
  /// Why there is no lens, or no camera, though there are views enough for one: its sentence names
  /// views by their numbers.
  std::optional<CalibrationError> trouble;
  std::uint64_t trouble_view = 0;  ///< its view or sheet; 0: of all
};

/// Pictures of a printed board, and one of the sheet on the table, as they are collected to
/// calibrate a camera. For one thread.
class BoardViews {
 public:
  static constexpr std::size_t kViewsMax = 30;
  static constexpr std::size_t kViewsLeast = 5;  ///< for a camera
  static constexpr std::size_t kTagsLeast = 4;   ///< of the board, in a view
  static constexpr std::size_t kSheetLeast = 3;  ///< of the sheet

  /// Nothing for a paper that is none of a4, a3 and letter.
  static std::optional<BoardViews> of(std::string_view paper);

  /// A picture of the board. A view that adds nothing is refused.
  std::expected<TakenView, ViewRefusal> add(const vision::Picture& picture);
  /// A picture of the sheet on the table, in place of the one before.
  std::expected<TakenView, ViewRefusal> lay(const vision::Picture& picture);
  /// @return  whether there was such a view
  bool drop(std::uint64_t number);

  const vision::TagBoard& board() const { return board_; }
  const vision::TagBoard& sheet() const { return sheet_; }
  const std::vector<TakenView>& views() const { return views_; }
  const std::optional<TakenView>& table() const { return table_; }

  /// Lens, residuals and, with the sheet, the calibrated camera: some tenths of a second. The
  /// camera has the sheet's paper and no name.
  ViewsResult result() const;

 private:
  BoardViews(vision::TagBoard board, vision::TagBoard sheet);
  std::expected<TakenView, ViewRefusal> view_of(const vision::Picture& picture,
                                                const vision::TagBoard& wanted,
                                                std::size_t tags_least);
  std::optional<ViewRefusal> size_change(const vision::Picture& picture) const;
  void put_trouble(ViewsResult& result, CalibrationError error) const;

  vision::TagBoard board_;
  vision::TagBoard sheet_;
  std::unique_ptr<vision::TagFinder> finder_;
  std::vector<TakenView> views_;
  std::optional<TakenView> table_;
  std::uint64_t last_ = 0;
};

/// Rms of the distances between points and their model, px, by view; points that the fit left out
/// do not count. @param lens  of these views
std::vector<double> view_residuals(std::span<const BoardView> views, const Intrinsics& lens);

}  // namespace sinew::calibration
