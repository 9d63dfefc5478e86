#pragma once

#include <span>
#include <vector>

#include "sinew/vision/top_search.h"

namespace sinew::vision {

/// What speaks for a top, each a number that grows with it.
struct TopEvidence {
  double network = 0;  ///< logit of its sureness
  double alike = 0;  ///< logarithm of the share of the others that have its size and shape, 0: all
  double stretch = 0;  ///< by perspective, 0 to 1: the network is too little sure of stretched tops
  double corners = 0;  ///< of four
};
std::vector<TopEvidence> evidence_of(std::span<const Top> tops);

/// How likely each top is that of a cube, 0 to 1: by how sure the network is of it, and by the
/// others in the picture. Cubes on a table have one size, and one camera sees their tops in one
/// shape.
std::vector<double> beliefs(std::span<const Top> tops);

}  // namespace sinew::vision
