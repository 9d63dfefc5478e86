#pragma once

#include <array>
#include <optional>
#include <vector>

#include "sinew/vision/picture.h"

namespace sinew::vision {

/// Columns and rows of square cells that a picture is looked at in.
struct CellGrid {
  int columns = 0;
  int rows = 0;

  std::size_t size() const {
    return static_cast<std::size_t>(columns) * static_cast<std::size_t>(rows);
  }
  std::size_t at(int column, int row) const {
    return static_cast<std::size_t>(row) * static_cast<std::size_t>(columns) +
           static_cast<std::size_t>(column);
  }
  friend bool operator==(const CellGrid&, const CellGrid&) = default;
};
/// The cell of a pixel in a picture of this size; nothing outside of it.
std::optional<std::size_t> cell_of(const CellGrid& grid, int width, int height, Pixel p);
/// Of a picture of this size, at most kCellsAcross along its longer side.
inline constexpr int kCellsAcross = 96;
CellGrid grid_of(int width, int height);

/// Notices what comes into the view of a camera that stands still, beside what may move there.
///
/// Each cell's color is held against what it was. A channel that is brighter or darker as a whole
/// is another exposure or white balance; darker cells of the same hue are a shadow, brighter ones
/// of very nearly the same hue one that has gone. What was hidden by something that may move is
/// seen anew afterwards.
class ViewWatch {
 public:
  /// @param least  cells; what is smaller does not count
  explicit ViewWatch(double least) : least_(least) {}

  /// What is seen next is how things are.
  void begin_again();
  /// @param picture   of the same size each time
  /// @param may_move  for each cell of grid_of(); what changes there is expected
  /// @return where something came into view, px: its middle, once two pictures in a row show it
  std::optional<Pixel> look(const Picture& picture, const std::vector<bool>& may_move);

 private:
  using Color = std::array<float, 3>;

  Color exposure_of(const Picture& cells, const std::vector<bool>& may_move) const;
  std::optional<Pixel> largest(const CellGrid& grid, std::vector<bool> changed) const;

  double least_;
  std::vector<Color> was_;
  std::vector<bool> known_;  ///< of each cell
  bool seen_ = false;        ///< in the last picture
};

}  // namespace sinew::vision
