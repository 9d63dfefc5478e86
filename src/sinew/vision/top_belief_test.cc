#include "sinew/vision/top_belief.h"

#include <gtest/gtest.h>

namespace sinew::vision {
namespace {

Top top_at(double x, double edge, double sureness, double flat = 1) {
  Top top;
  const double u = edge / 2, v = flat * edge / 2;
  top.quad = {Pixel{x - u, 100 - v}, {x + u, 100 - v}, {x + u, 100 + v}, {x - u, 100 + v}};
  top.sureness = sureness;
  top.corners = 4;
  return top;
}

TEST(TopBelief, others_of_its_size_and_shape_speak_for_a_top) {
  const double alone = beliefs(std::vector{top_at(0, 40, 0.4)})[0];
  const Top sure = top_at(100, 40, 0.8);
  const Top larger = top_at(200, 80, 0.8);
  const Top flatter = top_at(300, 56, 0.8, 0.5);
  const double among_alike = beliefs(std::vector{top_at(0, 41, 0.4), sure})[0];
  const double beside_larger = beliefs(std::vector{top_at(0, 40, 0.4), larger})[0];
  const double beside_flatter = beliefs(std::vector{top_at(0, 40, 0.4), flatter})[0];
  EXPECT_GT(among_alike, alone - 0.02) << "one that is alone is not held against others";
  EXPECT_GT(among_alike, beside_larger + 0.1);
  EXPECT_GT(among_alike, beside_flatter + 0.1);
}

TEST(TopBelief, grows_with_sureness_and_with_how_far_aside_it_is_seen_from) {
  EXPECT_TRUE(beliefs({}).empty());
  double before = 0;
  for (const double sureness : {0.13, 0.3, 0.5, 0.7, 0.95}) {
    const double belief = beliefs(std::vector{top_at(0, 40, sureness)})[0];
    EXPECT_GT(belief, before);
    EXPECT_LT(belief, 1);
    before = belief;
  }
  EXPECT_GT(beliefs(std::vector{top_at(0, 40, 0.4, 0.4)})[0],
            beliefs(std::vector{top_at(0, 40, 0.4)})[0]);
}

}  // namespace
}  // namespace sinew::vision
