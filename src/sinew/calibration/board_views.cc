#include "sinew/calibration/board_views.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "sinew/calibration/view_sharpness.h"
#include "sinew/core/number_text.h"

namespace sinew::calibration {
namespace {

constexpr double kEdgeMost = 4;      // px, of a picture of up to kEdgeWidth px
constexpr double kEdgeWidth = 1280;  // px
/// Views whose points are nearer than this share of the picture's width are one.
constexpr double kSameView = 0.025;

std::string size_text(int width, int height) {
  return std::to_string(width) + " x " + std::to_string(height) + " px";
}

ViewRefusal no_board() {
  return {"no_board",
          "No tag of the board is seen. Hold the printed board so that it fills half of the "
          "picture; sinew camera board prints it."};
}

ViewRefusal no_sheet() {
  return {"no_sheet",
          "No tag of the sheet is seen. Lay the printed sheet on the table in the middle of the "
          "picture; sinew camera sheet prints it."};
}

ViewRefusal few_tags(std::size_t seen, std::size_t least, bool of_sheet) {
  if (of_sheet) {
    return {"few_tags", "Only " + std::to_string(seen) + " of the 4 tags of the sheet are seen (" +
                            std::to_string(least) + " needed). Clear what covers the sheet."};
  }
  return {"few_tags", "Only " + std::to_string(seen) + " tags of the board are seen (" +
                          std::to_string(least) + " needed). Show more of the board."};
}

/// px, rms over the points that both views show; nothing where these are less than half of the
/// points of the smaller view.
std::optional<double> apart(const vision::BoardCorners& a, const vision::BoardCorners& b) {
  double sum = 0;
  std::size_t common = 0;
  for (std::size_t i = 0; i < a.pixels.size(); ++i) {
    const auto same = std::ranges::find(b.points_B, a.points_B[i]);
    if (same == b.points_B.end()) continue;
    const auto off = a.pixels[i] - b.pixels[static_cast<std::size_t>(same - b.points_B.begin())];
    sum += dot(off, off);
    ++common;
  }
  if (2 * common < std::min(a.pixels.size(), b.pixels.size())) return std::nullopt;
  return std::sqrt(sum / static_cast<double>(common));
}

/// A corner that is guessed beyond the picture's border is none to measure with.
bool is_inside(const vision::Quad& quad, const vision::Picture& picture) {
  return std::ranges::all_of(quad, [&](vision::Pixel p) {
    return p.x >= 0 && p.y >= 0 && p.x <= picture.width && p.y <= picture.height;
  });
}

std::vector<BoardView> boards_of(const std::vector<TakenView>& views) {
  std::vector<BoardView> boards;
  boards.reserve(views.size());
  for (const TakenView& view : views) boards.push_back(view.seen);
  return boards;
}

}  // namespace

std::vector<double> view_residuals(std::span<const BoardView> views, const Intrinsics& lens) {
  std::vector<double> residuals;
  for (std::size_t i = 0; i < views.size(); ++i) {
    std::vector<double> errors;
    const vision::BoardCorners& seen = views[i].seen;
    for (std::size_t k = 0; k < seen.pixels.size(); ++k) {
      const bool left_out = std::ranges::any_of(
          lens.wrong_points, [&](const WrongPoint& p) { return p.view == i && p.point == k; });
      const auto model = lens.camera.project(lens.X_CB[i] * seen.points_B[k]);
      if (!left_out && model) errors.push_back(length(*model - seen.pixels[k]));
    }
    residuals.push_back(rms(errors));
  }
  return residuals;
}

std::optional<BoardViews> BoardViews::of(std::string_view paper) {
  auto board = vision::calibration_board(paper);
  auto sheet = vision::table_sheet(paper);
  if (!board || !sheet) return std::nullopt;
  return BoardViews(std::move(*board), std::move(*sheet));
}

BoardViews::BoardViews(vision::TagBoard board, vision::TagBoard sheet)
    : board_(std::move(board)),
      sheet_(std::move(sheet)),
      finder_(std::make_unique<vision::TagFinder>(std::vector{board_.family})) {}

std::optional<ViewRefusal> BoardViews::size_change(const vision::Picture& picture) const {
  const TakenView* first = !views_.empty() ? &views_.front() : table_ ? &*table_ : nullptr;
  if (first == nullptr ||
      (first->seen.width == picture.width && first->seen.height == picture.height)) {
    return std::nullopt;
  }
  return ViewRefusal{"picture_size",
                     "The picture has " + size_text(picture.width, picture.height) +
                         ", the views before have " +
                         size_text(first->seen.width, first->seen.height) +
                         ". Set the camera to its former size, or begin the calibration again."};
}

std::expected<TakenView, ViewRefusal> BoardViews::view_of(const vision::Picture& picture,
                                                          const vision::TagBoard& wanted,
                                                          std::size_t tags_least) {
  const bool of_sheet = wanted.first == sheet_.first;
  if (auto changed = size_change(picture)) return std::unexpected(std::move(*changed));
  std::vector<vision::SeenTag> tags = finder_->find(picture);
  std::erase_if(tags, [&](const vision::SeenTag& tag) {
    return !wanted.has(tag) || !is_inside(tag.corners, picture);
  });
  if (tags.empty()) return std::unexpected(of_sheet ? no_sheet() : no_board());
  if (tags.size() < tags_least) {
    return std::unexpected(few_tags(tags.size(), tags_least, of_sheet));
  }
  const double width = edge_width(picture, tags);
  const double most = kEdgeMost * std::max(1.0, picture.width / kEdgeWidth);
  if (width > most) {
    return std::unexpected(ViewRefusal{
        "blurred", "The picture is blurred: edges are " + number_text(width, 1) +
                       " px wide (limit " + number_text(most, 1) +
                       " px). Hold everything still, use more light, or focus the camera."});
  }
  return TakenView{0, {picture.width, picture.height, corners_in(wanted, tags)}, tags.size()};
}

std::expected<TakenView, ViewRefusal> BoardViews::add(const vision::Picture& picture) {
  if (views_.size() >= kViewsMax) {
    return std::unexpected(
        ViewRefusal{"views_full", std::to_string(kViewsMax) + " views are the most. Delete one."});
  }
  auto view = view_of(picture, board_, kTagsLeast);
  if (!view) return view;
  for (const TakenView& other : views_) {
    const auto distance = apart(view->seen.seen, other.seen.seen);
    if (!distance || *distance >= kSameView * picture.width) continue;
    return std::unexpected(
        ViewRefusal{"same_view", "The board is where view " + std::to_string(other.number) +
                                     " shows it already. Move, tilt or turn the board."});
  }
  view->number = ++last_;
  views_.push_back(*view);
  return view;
}

std::expected<TakenView, ViewRefusal> BoardViews::lay(const vision::Picture& picture) {
  auto view = view_of(picture, sheet_, kSheetLeast);
  if (!view) return view;
  view->number = ++last_;
  table_ = *view;
  return view;
}

bool BoardViews::drop(std::uint64_t number) {
  if (table_ && table_->number == number) {
    table_.reset();
    return true;
  }
  return std::erase_if(views_, [&](const TakenView& view) { return view.number == number; }) > 0;
}

void BoardViews::put_trouble(ViewsResult& result, CalibrationError error) const {
  if (error.index >= 0) {
    const auto index = static_cast<std::size_t>(error.index);
    result.trouble_view = index < views_.size() ? views_[index].number : table_->number;
    error.index = static_cast<int>(result.trouble_view) - 1;
  }
  result.trouble = error;
}

ViewsResult BoardViews::result() const {
  constexpr std::size_t kLensLeast = 4;
  ViewsResult result;
  const std::vector<BoardView> boards = boards_of(views_);
  std::optional<Intrinsics> lens;
  if (table_ && boards.size() >= kViewsLeast) {
    auto camera = table_calibration(boards, table_->seen);
    if (camera) {
      lens = camera->intrinsics;
      result.camera = std::move(*camera);
      result.camera->camera.sheet = sheet_.paper;
    } else {
      put_trouble(result, camera.error());
    }
  }
  if (!lens && boards.size() >= kLensLeast) {
    auto found = intrinsics(boards);
    if (found) {
      lens = std::move(*found);
    } else {
      put_trouble(result, found.error());
    }
  }
  result.coverage = coverage(boards, lens ? std::optional(lens->camera) : std::nullopt);
  result.better = what_to_add(result.coverage);
  if (!lens) return result;
  result.residuals = view_residuals(boards, *lens);
  result.rms = lens->rms;
  return result;
}

}  // namespace sinew::calibration
