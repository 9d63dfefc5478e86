#include "sinew/program/plans/row_offers.h"

#include <algorithm>

#include "sinew/core/number_text.h"
#include "sinew/core/rotation.h"
#include "sinew/core/units.h"
#include "sinew/model/joint_value.h"

namespace sinew::program {
namespace {

using kinematics::PoseBT;

constexpr int kDigits = 3;

/// Something to type, as a row and behind an option.
struct Typed {
  std::string row;
  std::string option;
};

Typed joint_move(const planning::JointArray& q, const RobotModel& model) {
  Typed typed{"joint", "--to joints="};
  for (std::size_t j = 0; j < model.joints.size(); ++j) {
    const Joint& joint = model.joints[j];
    const std::string value = number_text(shown_value(q[j], joint), kDigits);
    typed.row += " " + joint.name + "=" + value + shown_unit(joint);
    typed.option += (j > 0 ? "," : "") + value;
  }
  return typed;
}

/// @param turned  the orientation as well
Typed line_to(const PoseBT& X_BT, bool turned) {
  const Vec3 rpy = fixed_xyz(X_BT.R);
  Typed typed{"line", "--to "};
  const struct {
    const char* name;
    double value;
    const char* unit;
  } kParts[] = {{"x", to_mm(X_BT.p.x), "mm"}, {"y", to_mm(X_BT.p.y), "mm"},
                {"z", to_mm(X_BT.p.z), "mm"}, {"rx", to_deg(rpy.x), "deg"},
                {"ry", to_deg(rpy.y), "deg"}, {"rz", to_deg(rpy.z), "deg"}};
  for (const auto& part : kParts) {
    if (!turned && part.unit[0] == 'd') break;
    const std::string value = number_text(part.value, kDigits);
    typed.row += std::string(" ") + part.name + "=" + value + part.unit;
    typed.option += (&part == kParts ? "" : ",") + value;
  }
  return typed;
}

/// Collects what works.
class Trial {
 public:
  Trial(const WayRefusal& way, const RobotModel& model, bool in_program)
      : way_(way), model_(model), in_program_(in_program), planner_(model) {}

  void offer(const std::string& what, const Typed& typed) {
    const auto row = parse(typed.row, "", model_);
    if (!row) return;
    const JointVector from(
        std::span<const double>(way_.refusal.from.q.data(), model_.joints.size()));
    if (!planner_.plan(from, way_.tool, row->steps)) return;
    found_.push_back(what + ": " + (in_program_ ? typed.row : typed.option));
  }
  void offer_untried(std::string sentence) { found_.push_back(std::move(sentence)); }
  std::vector<std::string> found() const { return found_; }

 private:
  const WayRefusal& way_;
  const RobotModel& model_;
  bool in_program_;
  RowPlanner planner_;
  std::vector<std::string> found_;
};

}  // namespace

std::vector<std::string> offers(const WayRefusal& way, const RobotModel& model, bool in_program) {
  const planning::MoveProposal& proposal = way.proposal;
  Trial trial(way, model, in_program);
  if (way.jaws_first && in_program) {
    trial.offer_untried("first open the jaws, then the same row: jaws " +
                        number_text(to_mm(*way.jaws_first), 1) + "mm");
  }
  const bool turns = !std::holds_alternative<PalletizerGeometry>(model.geometry);
  if (way.unsayable && way.unsayable->nearest) {
    planning::JointArray q{};
    std::ranges::copy(*way.unsayable->nearest, q.begin());
    trial.offer("the nearest place that can be sent", joint_move(q, model));
  }
  if (proposal.back_inside) {
    trial.offer("first back inside its limits", joint_move(*proposal.back_inside, model));
  }
  if (proposal.move_j) trial.offer("a joint move", joint_move(*proposal.move_j, model));
  if (proposal.other_start) {
    // The planner has tried it, with the row itself.
    const Typed start = joint_move(*proposal.other_start, model);
    trial.offer_untried("the same way from another branch, which is reached by " +
                        (in_program ? start.row : start.option));
  }
  if (proposal.tilted) {
    const auto& tilted = *proposal.tilted;
    std::string by = number_text(to_deg(tilted.tilt), 1) + " deg";
    if (tilted.swing != 0) by += " and swung by " + number_text(to_deg(tilted.swing), 1) + " deg";
    if (tilted.roll != 0) by += " and rolled by " + number_text(to_deg(tilted.roll), 1) + " deg";
    if (tilted.q) {
      trial.offer("the same point by a joint move, the tool tilted by " + by,
                  joint_move(*tilted.q, model));
    } else {
      trial.offer("the same line with the tool tilted by " + by, line_to(tilted.X_BT, turns));
    }
  }
  if (proposal.nearest_q) {
    trial.offer("the nearest orientation that it can have, by a joint move",
                joint_move(*proposal.nearest_q, model));
  } else if (proposal.nearest) {
    trial.offer("the nearest orientation that it can have", line_to(proposal.nearest->X_BT, turns));
  }
  if (proposal.near) {
    const double left = proposal.near->left;
    trial.offer(left > 0
                    ? "a joint move that ends " + number_text(to_mm(left), 1) + " mm short of it"
                    : std::string("as far as the joints can go"),
                joint_move(proposal.near->q, model));
  }
  if (proposal.part) {
    trial.offer("the first " + number_text(to_mm(proposal.part->length), 1) + " mm of the line",
                line_to(proposal.part->X_BT, turns));
  }
  return trial.found();
}

}  // namespace sinew::program
