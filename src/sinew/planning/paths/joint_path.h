#pragma once

#include <array>
#include <cstddef>
#include <span>
#include <vector>

#include "sinew/model/robot_model.h"

namespace sinew::planning {

using JointArray = std::array<double, kMaxJoints>;

/// All joints at one place of a path: q in rad or m, and its derivatives with respect to the path's
/// parameter s. Elements from the number of joints on are zero.
struct PathPoint {
  JointArray q{};
  JointArray dq{};
  JointArray ddq{};
  JointArray dddq{};
};

/// A way through joint space: q as a function of s, made of polynomials of degree 5 at most. s
/// counts metres of the tool's way where a tool moves along a line, and something comparable
/// elsewhere; it never runs back. Whoever appends keeps q, dq and ddq continuous: this is what
/// makes a motion along the path free of jumps in acceleration.
///
/// Appending does not allocate up to the capacity that it was made with; sampling is @rt.
class JointPath {
 public:
  /// Pieces that one plan may have: 10 m of tool way in steps of 2.5 mm.
  static constexpr std::size_t kPiecesMax = 4096;

  explicit JointPath(std::size_t joints, std::size_t capacity = kPiecesMax);

  std::size_t joints() const { return joints_; }
  std::size_t size() const { return pieces_.size(); }
  std::size_t capacity() const { return pieces_.capacity(); }
  bool empty() const { return pieces_.empty(); }
  double length() const { return length_; }
  /// Where piece `i` begins; begin(size()) is the length.
  double begin(std::size_t i) const { return i < size() ? pieces_[i].s : length_; }

  void clear();
  /// Forgets the pieces from `count` on.
  void truncate(std::size_t count);

  /// Straight in joint space. @param length  > 0, in the unit of s. @return false: no room left
  bool append_line(std::span<const double> from, std::span<const double> to, double length);
  /// The polynomial of degree 5 with these values, first and second derivatives at its ends.
  bool append_quintic(const PathPoint& from, const PathPoint& to, double length);
  /// A C2 spline of cubics through `points` (one row a point, `knots` its places, rising strictly
  /// from 0), with the first derivatives at its two ends given: what a Jacobian tells there.
  /// @param points  knots.size() rows of joints() numbers, at least two.
  bool append_spline(std::span<const double> knots, std::span<const JointArray> points,
                     const JointArray& dq_first, const JointArray& dq_last);

  /// The piece in which s lies, s clamped to [0, length]. `hint` is where to look first.
  std::size_t piece_at(double s, std::size_t hint = 0) const;
  /// Within piece `i`, at `u` beyond its beginning: on a border each side tells its own dddq.
  void sample_piece(std::size_t i, double u, PathPoint& out) const;
  /// Upper bounds of |dq|, |ddq| and |dddq| (no q) within piece `i` between u0 and u1 beyond its
  /// beginning: exact where a derivative is linear there, never too low elsewhere.
  void bound_piece(std::size_t i, double u0, double u1, PathPoint& out) const;
  /// At s, clamped to [0, length].
  void sample(double s, PathPoint& out, std::size_t hint = 0) const;

 private:
  static constexpr std::size_t kDegree = 5;
  struct Piece {
    double s = 0;
    std::array<JointArray, kDegree + 1> coefficients;  ///< of u^0 .. u^5
  };

  bool has_room(std::size_t pieces) const { return size() + pieces <= capacity(); }

  std::size_t joints_;
  double length_ = 0;
  std::vector<Piece> pieces_;
  // Workspace of append_spline: second derivatives at the knots.
  std::vector<JointArray> curvature_;
  std::vector<double> diagonal_;
};

}  // namespace sinew::planning
