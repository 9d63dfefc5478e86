#pragma once

#include <algorithm>
#include <cstdint>
#include <optional>
#include <vector>

#include "sinew/planning/collision/cell_body.h"

namespace sinew::planning {

/// What the joints do on a motion, as the device really makes it: along a path, joints that each go
/// to their end at a pace of their own, or anywhere (nobody knows). In pieces that contain all
/// places at which the joints may be, as finely as somebody asks.
class CellWay {
 public:
  /// The joints are in `box` while the share from `begin` to `end` of the way is gone.
  struct Part {
    JointBox box;
    double begin = 0;
    double end = 1;
  };
  /// What to do next with a part that was looked at.
  enum class Next : std::uint8_t {
    kOn,     ///< it is done
    kFiner,  ///< its halves
    kEnd,    ///< nothing more
  };

  /// Nobody knows where the joints go.
  CellWay() = default;
  /// @param path  outlives this
  explicit CellWay(const JointPath& path) : path_(&path) { add_up(); }
  explicit CellWay(JointPath&& path) : own_(std::move(path)), path_(&*own_) { add_up(); }
  CellWay(const CellWay&) = delete;
  CellWay& operator=(const CellWay&) = delete;

  /// From there on to `q`, no two joints together.
  void apart_to(const JointArray& from, const JointArray& to);
  bool known() const { return path_ != nullptr || !boxes_.empty(); }
  /// It goes nowhere.
  bool empty() const { return known() && boxes_.empty() && path_->empty(); }
  /// Where it begins; without meaning where nobody knows.
  JointArray start() const;

  /// visit(Part) -> Next, in the order of the way.
  template <class Visit>
  bool walk(Visit&& visit) const {
    if (path_ != nullptr) {
      return path_->empty() || walk_pieces(0, path_->size(), visit);
    }
    for (std::size_t i = 0; i < boxes_.size(); ++i) {
      if (!walk_box(part_of_box(i, boxes_[i]), visit)) return false;
    }
    return true;
  }

 private:
  void add_up();
  Part part_of_box(std::size_t i, const JointBox& box) const;
  /// Of the pieces from `first` to before `last`, as far as their sums tell.
  Part pieces(std::size_t first, std::size_t last) const;
  Part stretch(std::size_t piece, double u0, double u1) const;
  /// Splits where it is widest.
  static std::size_t widest(const JointArray& half);

  template <class Visit>
  bool walk_pieces(std::size_t first, std::size_t last, Visit&& visit) const {
    if (last - first == 1) {
      return walk_stretch(first, 0, path_->begin(last) - path_->begin(first), visit);
    }
    const Next next = visit(pieces(first, last));
    if (next != Next::kFiner) return next == Next::kOn;
    const std::size_t middle = first + (last - first) / 2;
    return walk_pieces(first, middle, visit) && walk_pieces(middle, last, visit);
  }
  template <class Visit>
  bool walk_stretch(std::size_t piece, double u0, double u1, Visit&& visit) const {
    const Next next = visit(stretch(piece, u0, u1));
    if (next != Next::kFiner) return next == Next::kOn;
    const double middle = 0.5 * (u0 + u1);
    if (!(middle > u0 && middle < u1)) return true;
    return walk_stretch(piece, u0, middle, visit) && walk_stretch(piece, middle, u1, visit);
  }
  template <class Visit>
  static bool walk_box(Part part, Visit&& visit) {
    const Next next = visit(part);
    if (next != Next::kFiner) return next == Next::kOn;
    const std::size_t k = widest(part.box.half);
    part.box.half[k] /= 2;
    Part other = part;
    part.box.q[k] -= part.box.half[k];
    other.box.q[k] += part.box.half[k];
    return walk_box(part, visit) && walk_box(other, visit);
  }

  std::optional<JointPath> own_;
  const JointPath* path_ = nullptr;
  std::vector<JointArray> sums_;  ///< of how far each joint goes in all pieces before
  std::vector<JointBox> boxes_;
  JointArray begin_{};  ///< of the first box
};

}  // namespace sinew::planning
