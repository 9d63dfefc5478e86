#include "sinew/server/api/calibrations.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <utility>

#include "sinew/server/json/robot_json.h"

namespace sinew::server {
namespace {

using calibration::BoardViews;
using calibration::Coverage;
using calibration::TakenView;
using Step = runtime::CameraCalibration::Step;

/// By tag; to a hundredth of a pixel.
Json corners_json(const TakenView& view) {
  const auto rounded = [](double px) { return std::round(100 * px) / 100; };
  Json tags = Json::array();
  const auto& pixels = view.seen.seen.pixels;
  for (std::size_t i = 0; i + 3 < pixels.size(); i += 4) {
    Json corners = Json::array();
    for (std::size_t k = i; k < i + 4; ++k) {
      corners.push_back({rounded(pixels[k].x), rounded(pixels[k].y)});
    }
    tags.push_back(std::move(corners));
  }
  return tags;
}

Json view_json(const TakenView& view) {
  return {{"view", view.number}, {"tags", view.tags}, {"corners_px", corners_json(view)}};
}

Json coverage_json(const Coverage& coverage) {
  Json rows = Json::array();
  for (const auto& row : coverage.seen) {
    Json cells = Json::array();
    for (const bool seen : row) cells.push_back(seen);
    rows.push_back(std::move(cells));
  }
  return rows;
}

std::string_view step_name(Step step) {
  return step == Step::kBoard ? "board" : step == Step::kSheet ? "sheet" : "touch";
}

/// What the marks that were touched say, beside where the cell's file has the sheet.
Json touch_json(const runtime::CameraCalibration& one, const Pose<frame::World, frame::Table>& X_WT,
                const Pose<frame::World, frame::Table>& X_WT_file) {
  const calibration::SheetTouches& touches = *one.touches();
  const auto& touched = one.touched();
  Json marks = Json::array();
  for (std::size_t i = 0; i < touches.marks.size(); ++i) {
    Json mark{{"mark", touches.marks[i].mark}};
    if (touched) mark["off_m"] = touched->frame.residuals[i];
    marks.push_back(std::move(mark));
  }
  Json json{{"robot", touches.robot}, {"marks", std::move(marks)}};
  if (!touched) {
    json["trouble"] = touched.error().sentence;
    json["too_few"] = touched.error().kind == calibration::TouchRefusal::Kind::kTooFew;
    return json;
  }
  json["rms_m"] = touched->frame.rms;
  json["error_m"] = touched->error;
  json["pose"] = pose_json(X_WT.p, X_WT.R);
  json["moved_m"] = norm(X_WT.p - X_WT_file.p);
  if (const auto next = calibration::next_touch(touches, *touched)) {
    json["next"] = {{"mark", next->mark.name}, {"error_m", next->error}};
  }
  return json;
}

/// The camera's pose in the cell.
Json result_json(const calibration::TableCalibration& result,
                 const Pose<frame::World, frame::Table>& X_WT) {
  const vision::TableCamera& camera = result.camera;
  const auto X_WC = X_WT * relabel<frame::Table, frame::Camera>(camera.X_WC);
  return {{"table_error_m", camera.accuracy},
          {"reprojection_px", camera.reprojection},
          {"ambiguous", result.table.ambiguous()},
          {"left_out", result.intrinsics.wrong_points.size()},
          {"pose", pose_json(X_WC.p, X_WC.R)},
          {"fx_px", camera.model.fx},
          {"fy_px", camera.model.fy},
          {"center_px", {camera.model.center.x, camera.model.center.y}},
          {"lens", camera.model.lens}};
}

void put_calibration(Json& json, const runtime::CameraCalibration& one, const Cell& cell) {
  const calibration::ViewsResult& result = one.result();
  const auto& views = one.views().views();
  const auto& sheet = one.views().table();
  json["step"] = step_name(one.step());
  json["paper"] = one.paper();
  json["views_least"] = BoardViews::kViewsLeast;
  json["views_enough"] = Coverage::kViewsEnough;
  const TakenView* first = !views.empty() ? &views.front() : sheet ? &*sheet : nullptr;
  if (first != nullptr) {
    json["width_px"] = first->seen.width;
    json["height_px"] = first->seen.height;
  }
  json["views"] = Json::array();
  for (std::size_t i = 0; i < views.size(); ++i) {
    Json view = view_json(views[i]);
    if (i < result.residuals.size()) view["residual_px"] = result.residuals[i];
    json["views"].push_back(std::move(view));
  }
  if (sheet) json["sheet"] = view_json(*sheet);
  json["coverage"] = coverage_json(result.coverage);
  if (result.better) json["better"] = *result.better;
  if (result.trouble) json["trouble"] = sentence(*result.trouble);
  const CellCamera& place = cell.cameras[one.camera()];
  const auto X_WT = one.table_in(cell);
  if (result.camera) json["result"] = result_json(*result.camera, X_WT);
  if (one.touches() != nullptr) json["touch"] = touch_json(one, X_WT, place.X_WT);
  const vision::TagBoard& paper = one.views().sheet();
  json["paper_m"] = {paper.width, paper.height};
  json["marks"] = Json::array();
  for (const vision::BoardMark& mark : marks_of(paper)) {
    json["marks"].push_back({{"mark", mark.name}, {"x_m", mark.p_B.x}, {"y_m", mark.p_B.y}});
  }
}

RpcError refused(const calibration::ViewRefusal& why) {
  return {RpcCode::kRefused, why.sentence, {{"code", why.code}}};
}

}  // namespace

Calibrations::Result Calibrations::status(std::size_t camera) const {
  const CellCamera& place = cell_.cell().cameras[camera];
  const auto one = under_way_.find(camera);
  Json json{{"camera", place.name},
            {"under_way", one != under_way_.end()},
            {"simulated", place.device == kSimulatedCamera}};
  const std::string& file = cell_.camera(camera)->calibration_file();
  if (!file.empty()) json["file"] = file;
  const auto kept = cell_.camera(camera)->calibration();
  if (kept && kept->touched) json["table_robot"] = kept->touched->robot;
  if (one == under_way_.end()) return json;
  json["session"] = one->second.session;
  put_calibration(json, one->second.calibration, cell_.cell());
  return json;
}

std::expected<Calibrations::One*, RpcError> Calibrations::found(std::size_t camera,
                                                                std::uint64_t session) {
  const std::string& name = cell_.cell().cameras[camera].name;
  const auto one = under_way_.find(camera);
  if (one == under_way_.end()) {
    return std::unexpected(RpcError{
        RpcCode::kRefused,
        "No calibration of " + name + " is under way. Begin one: camera.calibration.begin.",
        {{"code", "not_begun"}}});
  }
  if (session != 0 && session != one->second.session) {
    return std::unexpected(RpcError{RpcCode::kRefused,
                                    "Another client has begun the calibration of " + name +
                                        " again. Continue with its views, or begin again.",
                                    {{"code", "begun_again"}}});
  }
  return &one->second;
}

Calibrations::Result Calibrations::begin(std::size_t camera, const std::string& paper, bool anew) {
  if (cell_.camera(camera)->is_on_arm()) {
    return std::unexpected(RpcError{RpcCode::kRefused,
                                    "This camera is on an arm: sinew camera calibrate finds its "
                                    "lens, and sinew camera hand-eye where it is.",
                                    {{"code", "on_arm"}}});
  }
  const auto before = under_way_.find(camera);
  if (before != under_way_.end() && !anew) {
    if (before->second.calibration.paper() == paper) {
      before->second.calibration.expect(runtime::CameraCalibration::Step::kBoard);
      return status(camera);
    }
    return std::unexpected(RpcError{RpcCode::kRefused,
                                    "A calibration with paper " +
                                        before->second.calibration.paper() +
                                        " is under way. Continue it, or begin again (anew).",
                                    {{"code", "other_paper"}}});
  }
  auto begun = runtime::CameraCalibration::begin(cell_, camera, paper);
  if (!begun) return std::unexpected(invalid("paper has to be a4, a3 or letter"));
  // The former one stops to show things as it ends: before this one begins to.
  if (before != under_way_.end()) under_way_.erase(before);
  begun->expect(Step::kBoard);
  under_way_.emplace(camera, One{++last_, std::move(*begun)});
  return status(camera);
}

Calibrations::Result Calibrations::expect(std::size_t camera, std::uint64_t session,
                                          const std::string& step) {
  constexpr std::array kSteps{Step::kBoard, Step::kSheet, Step::kTouch};
  const auto* const wanted = std::ranges::find(kSteps, step, step_name);
  if (wanted == kSteps.end()) {
    return std::unexpected(invalid("step has to be board, sheet or touch"));
  }
  const auto one = found(camera, session);
  if (!one) return std::unexpected(one.error());
  (*one)->calibration.expect(*wanted);
  return status(camera);
}

Calibrations::Result Calibrations::take(std::size_t camera, std::uint64_t session) {
  const auto one = found(camera, session);
  if (!one) return std::unexpected(one.error());
  runtime::CameraCalibration& calibration = (*one)->calibration;
  const auto view = calibration.take();
  if (!view) {
    RpcError why = refused(view.error());
    if (calibration.fault()) {
      why.data = error_json(*calibration.fault(), cell_.station(0).robot());
    }
    return std::unexpected(std::move(why));
  }
  auto json = status(camera);
  (*json)["taken"] = view->number;
  return json;
}

Calibrations::Result Calibrations::drop(std::size_t camera, std::uint64_t session,
                                        std::uint64_t view) {
  const auto one = found(camera, session);
  if (!one) return std::unexpected(one.error());
  if (!(*one)->calibration.drop(view)) {
    return std::unexpected(RpcError{RpcCode::kRefused,
                                    "There is no view " + std::to_string(view) + " (any more).",
                                    {{"code", "no_view"}}});
  }
  return status(camera);
}

Calibrations::Result Calibrations::touch(std::size_t camera, std::uint64_t session,
                                         std::size_t robot, const std::string& mark, double pin) {
  const auto one = found(camera, session);
  if (!one) return std::unexpected(one.error());
  const auto touched = (*one)->calibration.touch(robot, mark, pin);
  if (!touched) return std::unexpected(refused(touched.error()));
  return status(camera);
}

Calibrations::Result Calibrations::lift(std::size_t camera, std::uint64_t session,
                                        const std::string& mark) {
  const auto one = found(camera, session);
  if (!one) return std::unexpected(one.error());
  if (!(*one)->calibration.lift(mark)) {
    return std::unexpected(
        RpcError{RpcCode::kRefused, "This mark was not touched.", {{"code", "not_touched"}}});
  }
  return status(camera);
}

Calibrations::Result Calibrations::save(std::size_t camera, std::uint64_t session,
                                        bool sheet_stays) {
  const auto one = found(camera, session);
  if (!one) return std::unexpected(one.error());
  const auto saved = (*one)->calibration.save(sheet_stays);
  if (!saved) return std::unexpected(refused(saved.error()));
  under_way_.erase(camera);
  auto json = status(camera);
  (*json)["saved"] = {{"file", saved->file},
                      {"table_error_m", saved->accuracy},
                      {"sheet_stays", saved->sheet_stays}};
  return json;
}

Calibrations::Result Calibrations::end(std::size_t camera, std::uint64_t session) {
  const auto one = found(camera, session);
  if (!one) return std::unexpected(one.error());
  under_way_.erase(camera);
  return status(camera);
}

}  // namespace sinew::server
