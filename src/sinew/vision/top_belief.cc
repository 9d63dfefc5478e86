#include "sinew/vision/top_belief.h"

#include <algorithm>
#include <cmath>

namespace sinew::vision {
namespace {

/// The square behind a nearly affine quad: its edge (px), and the two numbers by which perspective
/// stretches it, both 0 from straight above.
struct Form {
  double edge = 0;
  Pixel stretch;
};

Form form_of(const Quad& quad) {
  const Pixel u = 0.5 * (quad[1] - quad[0] + quad[2] - quad[3]);
  const Pixel v = 0.5 * (quad[3] - quad[0] + quad[2] - quad[1]);
  const double xx = u.x * u.x + v.x * v.x;
  const double yy = u.y * u.y + v.y * v.y;
  const double xy = u.x * u.y + v.x * v.y;
  constexpr double kLeast = 1e-6;  // px^2
  const double sum = std::max(kLeast, xx + yy);
  return {std::sqrt(std::max(kLeast, std::abs(cross(u, v)))), {(xx - yy) / sum, 2 * xy / sum}};
}

/// 1 for two of the same size and shape.
double likeness(const Form& one, const Form& other) {
  constexpr double kSize = 0.15;  // of the logarithm of an edge
  constexpr double kShape = 0.2;
  const double size = std::log(one.edge / other.edge) / kSize;
  const double shape = length(one.stretch - other.stretch) / kShape;
  return std::exp(-size * size - shape * shape);
}

}  // namespace

std::vector<TopEvidence> evidence_of(std::span<const Top> tops) {
  constexpr double kAlone = 0.1;  // so much counts for and against one without others
  std::vector<Form> forms;
  for (const Top& top : tops) forms.push_back(form_of(top.quad));
  std::vector<TopEvidence> evidence;
  for (std::size_t i = 0; i < tops.size(); ++i) {
    double alike = kAlone, all = kAlone;
    for (std::size_t k = 0; k < tops.size(); ++k) {
      if (k == i) continue;
      const double weight = tops[k].sureness * tops[k].sureness;
      alike += weight * likeness(forms[i], forms[k]);
      all += weight;
    }
    const double sure = tops[i].sureness;
    evidence.push_back({std::log(sure / (1 - sure)), std::log(alike / all),
                        length(forms[i].stretch), static_cast<double>(tops[i].corners)});
  }
  return evidence;
}

std::vector<double> beliefs(std::span<const Top> tops) {
  // Logistic regression over the tops of rendered tables: tools/cube_net/belief.py.
  constexpr TopEvidence kWeights{2.89, 0.63, 2.88, 0.25};
  constexpr double kOffset = 0.4;
  std::vector<double> believed;
  for (const TopEvidence& one : evidence_of(tops)) {
    const double odds = kWeights.network * one.network + kWeights.alike * one.alike +
                        kWeights.stretch * one.stretch + kWeights.corners * one.corners + kOffset;
    believed.push_back(1 / (1 + std::exp(-odds)));
  }
  return believed;
}

}  // namespace sinew::vision
