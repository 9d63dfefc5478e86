#include "sinew/planning/collision/cell_way.h"

#include <cmath>

namespace sinew::planning {

void CellWay::add_up() {
  JointArray sum{};
  sums_.reserve(path_->size() + 1);
  sums_.push_back(sum);
  PathPoint bound;
  for (std::size_t i = 0; i < path_->size(); ++i) {
    const double length = path_->begin(i + 1) - path_->begin(i);
    path_->bound_piece(i, 0, length, bound);
    for (std::size_t k = 0; k < kMaxJoints; ++k) sum[k] += bound.dq[k] * length;
    sums_.push_back(sum);
  }
}

void CellWay::apart_to(const JointArray& from, const JointArray& to) {
  if (boxes_.empty()) begin_ = from;
  JointBox box;
  for (std::size_t k = 0; k < kMaxJoints; ++k) {
    box.q[k] = 0.5 * (from[k] + to[k]);
    box.half[k] = 0.5 * std::abs(to[k] - from[k]);
  }
  boxes_.push_back(box);
}

JointArray CellWay::start() const {
  if (path_ == nullptr || path_->empty()) return begin_;
  PathPoint at;
  path_->sample(0, at);
  return at.q;
}

CellWay::Part CellWay::part_of_box(std::size_t i, const JointBox& box) const {
  const auto count = static_cast<double>(boxes_.size());
  return {box, static_cast<double>(i) / count, static_cast<double>(i + 1) / count};
}

CellWay::Part CellWay::pieces(std::size_t first, std::size_t last) const {
  const std::size_t middle = first + (last - first) / 2;
  PathPoint at;
  path_->sample_piece(middle, 0, at);
  Part part{
      {at.q, {}}, path_->begin(first) / path_->length(), path_->begin(last) / path_->length()};
  for (std::size_t k = 0; k < kMaxJoints; ++k) {
    part.box.half[k] =
        std::max(sums_[middle][k] - sums_[first][k], sums_[last][k] - sums_[middle][k]);
  }
  return part;
}

CellWay::Part CellWay::stretch(std::size_t piece, double u0, double u1) const {
  PathPoint at, bound;
  path_->sample_piece(piece, 0.5 * (u0 + u1), at);
  path_->bound_piece(piece, u0, u1, bound);
  const double begin = path_->begin(piece);
  Part part{{at.q, {}}, (begin + u0) / path_->length(), (begin + u1) / path_->length()};
  for (std::size_t k = 0; k < kMaxJoints; ++k) {
    part.box.half[k] = bound.dq[k] * 0.5 * (u1 - u0);
  }
  return part;
}

std::size_t CellWay::widest(const JointArray& half) {
  return static_cast<std::size_t>(std::ranges::max_element(half) - half.begin());
}

}  // namespace sinew::planning
