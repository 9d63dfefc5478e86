#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <string_view>
#include <vector>

#include "sinew/vision/picture.h"

namespace sinew::vision {

/// AprilTag families: 36h11 is the common one; Standard41h12 has the same safety with fewer cells.
enum class TagFamily : std::uint8_t { k36h11, kStandard41h12 };

std::string_view name(TagFamily family);
std::optional<TagFamily> tag_family_named(std::string_view text);

/// A printed tag, as a picture of it shows it.
struct SeenTag {
  TagFamily family = TagFamily::k36h11;
  int id = 0;
  Quad corners{};     ///< px, of its border: the upper left one of the upright tag first, clockwise
  double margin = 0;  ///< how far its cells are from being misread; below 20 rarely a real tag
};

/// Finds tags in pictures (libapriltag). One thread at a time.
class TagFinder {
 public:
  explicit TagFinder(const std::vector<TagFamily>& families);
  ~TagFinder();
  TagFinder(const TagFinder&) = delete;
  TagFinder& operator=(const TagFinder&) = delete;

  /// By family and number; of a tag that is there twice both.
  std::vector<SeenTag> find(const Picture& picture);

 private:
  struct Detector;
  std::unique_ptr<Detector> detector_;
};

/// How a tag is printed: true is white. Its border, whose corners count, keeps `quiet` cells away
/// from the edges of this square.
struct TagCells {
  int side = 0;
  int quiet = 0;
  std::vector<bool> white;  ///< row by row from above

  bool at(int x, int y) const { return white[static_cast<std::size_t>(y * side + x)]; }
};

/// Nothing for a number that the family has not.
std::optional<TagCells> tag_cells(TagFamily family, int id);

}  // namespace sinew::vision
