#include "sinew/vision/tags.h"

#include <apriltag/apriltag.h>
#include <apriltag/tag36h11.h>
#include <apriltag/tagStandard41h12.h>

#include <algorithm>
#include <array>
#include <cstdlib>
#include <tuple>

namespace sinew::vision {
namespace {

struct FamilyRow {
  TagFamily family;
  std::string_view name;
  apriltag_family_t* (*create)();
  void (*destroy)(apriltag_family_t*);
};
constexpr std::array<FamilyRow, 2> kFamilies{
    {{TagFamily::k36h11, "36h11", tag36h11_create, tag36h11_destroy},
     {TagFamily::kStandard41h12, "Standard41h12", tagStandard41h12_create,
      tagStandard41h12_destroy}}};

const FamilyRow& row_of(TagFamily family) {
  return kFamilies[static_cast<std::size_t>(family)];
}

using Family = std::unique_ptr<apriltag_family_t, void (*)(apriltag_family_t*)>;
Family made(TagFamily family) {
  const FamilyRow& row = row_of(family);
  return {row.create(), row.destroy};
}

std::vector<std::uint8_t> grey_of(const Picture& picture) {
  std::vector<std::uint8_t> grey(picture.rgb.size() / 3);
  for (std::size_t i = 0; i < grey.size(); ++i) {
    const std::uint8_t* rgb = picture.rgb.data() + 3 * i;
    grey[i] = static_cast<std::uint8_t>((77 * rgb[0] + 150 * rgb[1] + 29 * rgb[2]) / 256);
  }
  return grey;
}

}  // namespace

std::string_view name(TagFamily family) {
  return row_of(family).name;
}

std::optional<TagFamily> tag_family_named(std::string_view text) {
  for (const FamilyRow& row : kFamilies) {
    if (row.name == text) return row.family;
  }
  return std::nullopt;
}

struct TagFinder::Detector {
  std::vector<std::pair<TagFamily, Family>> families;
  std::unique_ptr<apriltag_detector_t, void (*)(apriltag_detector_t*)> detector{
      apriltag_detector_create(), apriltag_detector_destroy};
};

TagFinder::TagFinder(const std::vector<TagFamily>& families)
    : detector_(std::make_unique<Detector>()) {
  for (const TagFamily family : families) {
    detector_->families.emplace_back(family, made(family));
    // Two cells' errors are mended at most: with more, other prints are taken for tags.
    apriltag_detector_add_family_bits(detector_->detector.get(),
                                      detector_->families.back().second.get(), 2);
  }
  detector_->detector->nthreads = 1;
  detector_->detector->quad_decimate = 1;
}
TagFinder::~TagFinder() = default;

std::vector<SeenTag> TagFinder::find(const Picture& picture) {
  std::vector<SeenTag> seen;
  // What is smaller holds no tag, and libapriltag does not expect it.
  constexpr int kLeast = 16;
  if (picture.width < kLeast || picture.height < kLeast) return seen;
  std::vector<std::uint8_t> grey = grey_of(picture);
  image_u8_t image{picture.width, picture.height, picture.width, grey.data()};
  zarray_t* all = apriltag_detector_detect(detector_->detector.get(), &image);
  for (int i = 0; i < zarray_size(all); ++i) {
    apriltag_detection_t* one = nullptr;
    zarray_get(all, i, static_cast<void*>(&one));
    const auto family = std::ranges::find_if(
        detector_->families, [&](const auto& entry) { return entry.second.get() == one->family; });
    SeenTag tag{family->first, one->id, {}, one->decision_margin};
    // Theirs begin at the lower left and go the other way round.
    for (std::size_t k = 0; k < 4; ++k) tag.corners[k] = {one->p[3 - k][0], one->p[3 - k][1]};
    seen.push_back(tag);
  }
  apriltag_detections_destroy(all);
  std::ranges::sort(seen, [](const SeenTag& a, const SeenTag& b) {
    return std::tuple(a.family, a.id, a.corners[0].x) < std::tuple(b.family, b.id, b.corners[0].x);
  });
  return seen;
}

std::optional<TagCells> tag_cells(TagFamily family, int id) {
  const Family codes = made(family);
  if (id < 0 || static_cast<std::uint32_t>(id) >= codes->ncodes) return std::nullopt;
  image_u8_t* image = apriltag_to_image(codes.get(), id);
  TagCells cells{image->width, (codes->total_width - codes->width_at_border) / 2, {}};
  for (int y = 0; y < image->height; ++y) {
    for (int x = 0; x < image->width; ++x) {
      cells.white.push_back(image->buf[y * image->stride + x] > 127);
    }
  }
  // What its own function for this does, which Debian has in another library.
  std::free(image->buf);
  std::free(image);
  return cells;
}

}  // namespace sinew::vision
