#pragma once

#include "sinew/core/rotation.h"
#include "sinew/core/vec3.h"

namespace sinew {

/// Frames, as types: `Pose<Base, Tool>` is X_BT, and X_BT * X_TC compiles where X_BT * X_BC does
/// not.
namespace frame {
struct World;
struct Base;
struct Flange;
struct Tool;
struct Platform;
struct Link;  ///< whichever link of a robot is spoken of
struct Box;
}  // namespace frame

/// Pose X_AB of frame B in frame A: p_AB in m, R_AB. Costs nothing over an untyped pose. @rt
template <class A, class B>
struct Pose {
  Rotation R;
  Vec3 p;

  constexpr Pose<B, A> inverse() const { return {R.transposed(), -1.0 * transposed_times(R, p)}; }

  friend constexpr bool operator==(const Pose&, const Pose&) = default;
};

template <class A, class B, class C>
constexpr Pose<A, C> operator*(const Pose<A, B>& X_AB, const Pose<B, C>& X_BC) {
  return {X_AB.R * X_BC.R, X_AB.R * X_BC.p + X_AB.p};
}

/// Point at p_BQ (in B, m) expressed in A.
template <class A, class B>
constexpr Vec3 operator*(const Pose<A, B>& X_AB, const Vec3& p_BQ) {
  return X_AB.R * p_BQ + X_AB.p;
}

/// The same numbers under other frame names: the one place where a frame may be renamed.
template <class A, class B, class C, class D>
constexpr Pose<A, B> relabel(const Pose<C, D>& X) {
  return {X.R, X.p};
}

}  // namespace sinew
