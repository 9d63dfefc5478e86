#include "sinew/cli/output/frames_text.h"

#include <fmt/format.h>

#include <array>

#include "sinew/cli/output/table.h"
#include "sinew/core/units.h"

namespace sinew::cli {
namespace {

/// A homogeneous matrix, translation in mm.
using Matrix = std::array<std::array<double, 4>, 4>;

Matrix matrix_mm(const Rotation& R, const Vec3& p) {
  return {{{R.x.x, R.y.x, R.z.x, to_mm(p.x)},
           {R.x.y, R.y.y, R.z.y, to_mm(p.y)},
           {R.x.z, R.y.z, R.z.z, to_mm(p.z)},
           {0, 0, 0, 1}}};
}

/// Zeros that are only rounding read better as 0.
double rounded(double value) {
  return std::abs(value) < 1e-12 ? 0.0 : value;
}

class Frames {
 public:
  void add(const std::string& name, const Rotation& R, const Vec3& p) {
    const Matrix matrix = matrix_mm(R, p);
    Json rows = Json::array();
    text_ += fmt::format("\n  {}\n", name);
    for (const auto& row : matrix) {
      Json values = Json::array();
      for (const double value : row) values.push_back(rounded(value));
      rows.push_back(values);
      text_ += fmt::format("    [{:>10} {:>10} {:>10} {:>12} ]\n", number(row[0], 6),
                           number(row[1], 6), number(row[2], 6), number(row[3], 4));
    }
    json_[name] = rows;
  }
  const std::string& text() const { return text_; }
  const Json& json() const { return json_; }

 private:
  std::string text_;
  Json json_ = Json::object();
};

}  // namespace

void add_frames(Outcome& outcome, const RobotModel& model, const kinematics::SerialArm& arm,
                const JointVector& q) {
  const kinematics::SerialChain& chain = arm.chain();
  Table table({"i", "joint", "theta deg", "d mm", "a mm", "alpha deg"});
  table.left(1);
  outcome.json["dh"] = Json::array();
  Frames frames;
  std::vector<kinematics::PoseBF> X_0{{}};
  for (std::size_t i = 0; i < q.size(); ++i) {
    const DhRow& row = chain.rows()[i];
    const bool slides = chain.slides(i);
    const double theta_deg = to_deg(row.theta_offset + (slides ? 0 : q[i]));
    const double d = row.d + (slides ? q[i] : 0);
    table.add({fmt::format("{}", i + 1), model.joints[i].name, number(theta_deg, 4),
               number(to_mm(d), 4), number(to_mm(row.a), 4), number(to_deg(row.alpha), 4)});
    outcome.json["dh"].push_back({{"joint", model.joints[i].name},
                                  {"theta_deg", theta_deg},
                                  {"theta_offset_deg", to_deg(row.theta_offset)},
                                  {"d_mm", to_mm(d)},
                                  {"a_mm", to_mm(row.a)},
                                  {"alpha_deg", to_deg(row.alpha)}});
    const kinematics::PoseBF X_link = chain.link(i, q[i]);
    frames.add(fmt::format("X_{}{}", i, i + 1), X_link.R, X_link.p);
    X_0.push_back({X_0.back().R * X_link.R, X_0.back().R * X_link.p + X_0.back().p});
  }
  for (std::size_t i = 2; i <= q.size(); ++i) {
    frames.add(fmt::format("X_0{}", i), X_0[i].R, X_0[i].p);
  }
  if (q.size() > 3) {
    const auto X_30 = X_0[3].inverse();
    frames.add("X_03 inverse", X_30.R, X_30.p);
    frames.add(fmt::format("X_3{}", q.size()), X_30.R * X_0.back().R,
               X_30.R * X_0.back().p + X_30.p);
  }
  frames.add("X_FT (tool on the flange)", arm.tool().R, arm.tool().p);
  const auto X_BT = arm.forward(q);
  frames.add("X_0T", X_BT.R, X_BT.p);
  outcome.json["frames_mm"] = frames.json();
  outcome.text +=
      "\n  X_{i-1,i} = Rot_z(theta) Trans_z(d) Trans_x(a) Rot_x(alpha); lengths in mm\n\n" +
      table.text() + frames.text();
}

}  // namespace sinew::cli
