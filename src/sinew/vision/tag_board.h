#pragma once

#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "sinew/core/vec3.h"
#include "sinew/vision/camera_model.h"
#include "sinew/vision/tags.h"

namespace sinew::vision {

/// A point of a sheet that a tool can touch.
struct BoardMark {
  std::string name;  ///< "cross1", or "tag580": the middle of that tag
  Vec3 p_B;          ///< m
};

/// A printed sheet of tags whose places are known. Its frame B has its origin in the middle of the
/// sheet, x to the right, y up the sheet, z out of the paper.
struct TagBoard {
  std::string paper;  ///< "a4"
  double width = 0;   ///< m, of the sheet
  double height = 0;  ///< m
  TagFamily family = TagFamily::k36h11;
  int first = 0;  ///< number of the upper left tag; then along the rows
  int columns = 0;
  int rows = 0;
  double tag = 0;    ///< m, side of a tag's border
  double pitch = 0;  ///< m, from tag to tag
  double lift = 0;   ///< m, of the tags' middle above that of the sheet: the ruler lies below
  std::vector<BoardMark> crosses = {};  ///< printed with their numbers

  bool has(const SeenTag& seen) const {
    return seen.family == family && seen.id >= first && seen.id < first + columns * rows;
  }
  /// p_B of a corner, m; 0 is the upper left one, then clockwise. @pre the board has that tag
  Vec3 corner(int id, std::size_t which) const;
};

/// To calibrate a camera with: as many tags as the paper holds. "a4", "a3" or "letter".
std::optional<TagBoard> calibration_board(std::string_view paper);

/// Four tags in the corners of a sheet, which lie on the table for good: the camera finds its pose,
/// and that it was moved. With five crosses for the tip of a tool: 1 to 4 clockwise from the upper
/// left one, 5 in the middle.
std::optional<TagBoard> table_sheet(std::string_view paper);

/// A tag by itself, its middle at B's origin. @pre the family has that number
TagBoard single_tag(TagFamily family, int id, double side);

/// The crosses of a board, then the middles of its tags.
std::vector<BoardMark> marks_of(const TagBoard& board);

/// True to scale, with a ruler to check the printer with.
std::string svg_of(const TagBoard& board);
std::string pdf_of(const TagBoard& board);

/// For simulated cameras. @param scale  px per m, such that the sheet has at most 64 million
Picture picture_of(const TagBoard& board, double scale);

/// Corners of the board that a picture shows, and where.
struct BoardCorners {
  std::vector<Vec3> points_B;  ///< m
  std::vector<Pixel> pixels;
};
BoardCorners corners_in(const TagBoard& board, const std::vector<SeenTag>& tags);

}  // namespace sinew::vision
