#include "sinew/runtime/cameras/cell_baskets.h"

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <nlohmann/json.hpp>

#include "sinew/core/assert.h"
#include "sinew/core/rotation.h"
#include "sinew/io/file.h"

namespace sinew::runtime {
namespace {

using Json = nlohmann::ordered_json;
using Place = Pose<frame::World, frame::Box>;

Json place_json(const Place& X_WK) {
  return {X_WK.p.x, X_WK.p.y, X_WK.p.z, fixed_xyz(X_WK.R).z};
}

std::optional<Place> place_of(const Json& json) {
  const auto is_number = [](const Json& one) { return one.is_number(); };
  if (!json.is_array() || json.size() != 4 || !std::ranges::all_of(json, is_number)) {
    return std::nullopt;
  }
  const std::vector<double> v = json;
  return Place{rotation_z(v[3]), {v[0], v[1], v[2]}};
}

bool same_place(const Place& a, const Place& b) {
  constexpr double kSame = 1e-9;
  return norm(a.p - b.p) < kSame && std::abs(fixed_xyz(a.R).z - fixed_xyz(b.R).z) < kSame;
}

std::string text_of(const std::vector<CellBasket>& of_file, const std::vector<CellBasket>& now) {
  Json baskets = Json::object();
  for (std::size_t i = 0; i < now.size(); ++i) {
    if (same_place(now[i].X_WK, of_file[i].X_WK)) continue;
    baskets[now[i].name] = {{"from_m_rad", place_json(of_file[i].X_WK)},
                            {"to_m_rad", place_json(now[i].X_WK)}};
  }
  return Json{{"sinew_baskets", 1}, {"baskets", baskets}}.dump(2) + "\n";
}

}  // namespace

io::IoResult<void> CellBaskets::keep_in(const std::string& file) {
  const std::scoped_lock lock(mutex_);
  file_ = file;
  if (!io::exists(file)) return {};
  const auto text = io::read_file(file);
  if (!text) return std::unexpected(text.error());
  const Json read = Json::parse(*text, nullptr, false);
  const bool fits = read.is_object() && read.value("sinew_baskets", Json()) == 1 &&
                    read.contains("baskets") && read["baskets"].is_object();
  if (!fits) {
    return std::unexpected(io::IoError{
        file +
        " does not say where baskets were moved to: remove it, and they stand where the "
        "cell's file says"});
  }
  for (std::size_t i = 0; i < now_.size(); ++i) {
    const auto moved = read["baskets"].find(now_[i].name);
    if (moved == read["baskets"].end() || !moved->is_object()) continue;
    const auto from = place_of(moved->value("from_m_rad", Json()));
    const auto to = place_of(moved->value("to_m_rad", Json()));
    if (from && to && same_place(*from, of_file_[i].X_WK)) now_[i].X_WK = *to;
  }
  return {};
}

std::vector<CellBasket> CellBaskets::all() const {
  const std::scoped_lock lock(mutex_);
  return now_;
}

std::optional<std::size_t> CellBaskets::find(std::string_view name) const {
  const auto found = std::ranges::find(of_file_, name, &CellBasket::name);
  if (found == of_file_.end()) return std::nullopt;
  return static_cast<std::size_t>(found - of_file_.begin());
}

std::uint64_t CellBaskets::revision() const {
  const std::scoped_lock lock(mutex_);
  return revision_;
}

void CellBaskets::move(std::size_t basket, const Place& X_WK) {
  const std::scoped_lock lock(mutex_);
  SINEW_ASSERT(basket < now_.size());
  now_[basket].X_WK = X_WK;
  ++revision_;
}

io::IoResult<void> CellBaskets::keep() const {
  if (file_.empty()) return {};
  std::error_code error;  // where there is no such folder the file says so
  std::filesystem::create_directories(std::filesystem::path(file_).parent_path(), error);
  return io::replace_file(file_, text_of(of_file_, all()));
}

}  // namespace sinew::runtime
