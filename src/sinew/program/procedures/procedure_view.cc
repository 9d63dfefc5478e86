#include "sinew/program/procedures/procedure_view.h"

#include <array>

namespace sinew::program {
namespace {

using Asks = ProcedureView::Asks;

Asks asks_of(const Procedure& procedure) {
  if (procedure.phase() != Procedure::Phase::kAsking) return Asks::kNothing;
  const auto& what = procedure.step().what;
  if (std::holds_alternative<TellStep>(what)) return Asks::kYes;
  if (std::holds_alternative<NumberStep>(what)) return Asks::kNumber;
  if (std::holds_alternative<AdjustStep>(what)) return Asks::kAmount;
  if (std::holds_alternative<PlaceStep>(what)) return Asks::kPlace;
  const auto choices = procedure.choices();
  return !choices.empty() && choices[0] == "go" ? Asks::kGo : Asks::kWords;
}

}  // namespace

std::string_view name(ProcedureView::Asks asks) {
  constexpr std::array<std::string_view, 7> kNames{"",       "yes",    "go",   "words",
                                                   "number", "amount", "place"};
  return kNames[static_cast<std::size_t>(asks)];
}

ProcedureView view_of(const Procedure& procedure, Instant now) {
  ProcedureView view;
  const ProcedurePlan& plan = procedure.plan();
  view.id = plan.id;
  view.title = plan.title;
  view.phase = procedure.phase();
  view.place = procedure.place();
  view.trouble = procedure.trouble();
  for (std::size_t k = 0; k < plan.steps.size(); ++k) {
    view.steps.push_back({plan.steps[k].id, plan.steps[k].text, procedure.results()[k]});
  }
  view.progress = procedure.progress(now);
  view.elapsed = procedure.working_for(now);
  view.at_most = procedure.working_at_most();
  if (view.place == plan.steps.size()) return view;
  view.asks = asks_of(procedure);
  view.left = procedure.left() && !procedure.finished();
  view.ready = view.asks != Asks::kNothing && !procedure.waits_for_control() &&
               procedure.machine().state() == control::MachineState::kReady;
  view.question = procedure.question();
  view.choices = procedure.choices();
  if (const auto* number = std::get_if<NumberStep>(&procedure.step().what);
      number != nullptr && view.asks == Asks::kNumber) {
    view.range = ProcedureView::Range{number->measure, number->lower, number->upper};
  }
  if (const auto joint = procedure.joint()) {
    view.joint = procedure.machine().robot().joints[*joint].name;
  }
  return view;
}

}  // namespace sinew::program
