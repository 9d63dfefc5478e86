#include "sinew/program/formats/pose_file.h"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <cstdio>
#include <optional>

#include "sinew/core/assert.h"
#include "sinew/core/units.h"
#include "sinew/program/language/row_reader.h"

namespace sinew::program {
namespace {

constexpr std::size_t kNumbers = 24;
constexpr double kTotalMax = 1e6;  // deg: totals grow with every turn

/// The bytes of a text in UTF-16 whose characters are ASCII; others become '?'.
std::string from_utf16(std::string_view text, bool big_end) {
  std::string out;
  for (std::size_t i = 0; i + 1 < text.size(); i += 2) {
    const auto low = static_cast<unsigned char>(text[big_end ? i + 1 : i]);
    const auto high = static_cast<unsigned char>(text[big_end ? i : i + 1]);
    out += high == 0 && low < 0x80 ? static_cast<char>(low) : '?';
  }
  if (text.size() % 2 != 0) out += '?';
  return out;
}

std::string plain(std::string_view text) {
  if (text.starts_with("\xFF\xFE")) return from_utf16(text.substr(2), false);
  if (text.starts_with("\xFE\xFF")) return from_utf16(text.substr(2), true);
  if (text.starts_with("\xEF\xBB\xBF")) text.remove_prefix(3);
  return std::string(text);
}

/// The rows of a file, those at its end that are empty left out.
std::vector<std::string_view> rows_of(std::string_view text) {
  std::vector<std::string_view> rows;
  while (!text.empty()) {
    const std::size_t end = std::min(text.find('\n'), text.size());
    std::string_view row = text.substr(0, end);
    if (row.ends_with('\r')) row.remove_suffix(1);
    rows.push_back(row);
    text.remove_prefix(std::min(end + 1, text.size()));
  }
  const auto blank = [](std::string_view row) {
    return row.find_first_not_of(" \t\r") == std::string_view::npos;
  };
  while (!rows.empty() && blank(rows.back())) rows.pop_back();
  return rows;
}

class NumberReader {
 public:
  explicit NumberReader(std::string_view file_name) : file_name_(file_name) {}

  /// @param line  from 1
  double read(std::string_view row, int line, double largest) {
    const std::size_t first = std::min(row.find_first_not_of(" \t"), row.size());
    std::string word(row.substr(first));
    word.erase(word.find_last_not_of(" \t") + 1);
    const auto wrong = [&](std::size_t at, const std::string& why) {
      complain(line, static_cast<int>(first + at) + 1, in_quotes(word.substr(0, 40)) + why);
      return 0.0;
    };
    const std::size_t mark = word.find_first_of(".,");
    if (mark != std::string::npos) {
      if (word.find_first_of(".,", mark + 1) != std::string::npos) {
        return wrong(0, ": has more than one decimal mark");
      }
      if (mark_ != 0 && mark_ != word[mark]) {
        return wrong(mark, std::string(": the decimal mark was ") + mark_ + " in line " +
                               std::to_string(mark_line_) + "; a file has one kind");
      }
      if (mark_ == 0) mark_line_ = line;
      mark_ = word[mark];
      word[mark] = '.';
    }
    const std::size_t sign = word.starts_with('+') && !word.starts_with("+-") ? 1 : 0;
    double value = 0;
    const char* end = word.data() + word.size();
    const auto [stop, error] = std::from_chars(word.data() + sign, end, value);
    if (error != std::errc{} || stop != end || !std::isfinite(value)) {
      return wrong(0, word.empty() ? ": a number is missing" : " is not a finite number");
    }
    if (std::abs(value) > largest) return wrong(0, " is beyond any platform");
    return value;
  }

  void complain(int line, int column, std::string message) {
    if (complaints_.size() < RowReader::kComplaintMax) {
      complaints_.push_back({file_name_, line, column, "", std::move(message)});
    }
  }
  std::vector<Complaint>& complaints() { return complaints_; }

 private:
  std::string file_name_;
  char mark_ = 0;  ///< of the file, once one was seen
  int mark_line_ = 0;
  std::vector<Complaint> complaints_;
};

/// 24 rows from `first` on.
PoseFile read_pose(std::span<const std::string_view> rows, int first, NumberReader& reader) {
  std::array<double, kNumbers> values{};
  for (std::size_t i = 0; i < kNumbers; ++i) {
    const bool turns = i >= kNumbers - 3;
    const double most = turns ? kTotalMax : to_mm(kFarAway);
    values[i] = reader.read(rows[i], first + static_cast<int>(i), most);
  }
  const auto three = [&](std::size_t i) { return Vec3{values[i], values[i + 1], values[i + 2]}; };
  PoseFile pose;
  for (std::size_t leg = 0; leg < kLegs; ++leg) pose.heads[leg] = from_mm(1) * three(3 * leg);
  pose.translation_total = from_mm(1) * three(18);
  pose.rotation_total = from_deg(1) * three(21);
  return pose;
}

bool has_rows(std::span<const std::string_view> rows, std::size_t wanted, const char* what,
              NumberReader& reader) {
  if (rows.size() == wanted) return true;
  const bool more = rows.size() > wanted;
  const int line = static_cast<int>(more ? wanted + 1 : std::max<std::size_t>(1, rows.size()));
  reader.complain(line, 1,
                  std::string(what) + std::to_string(wanted) + " rows, this one " +
                      std::to_string(rows.size()));
  return false;
}

/// The eigenvector of the largest eigenvalue, after Jacobi; converges quadratically.
std::array<double, 4> largest_eigenvector(std::array<std::array<double, 4>, 4> a) {
  std::array<std::array<double, 4>, 4> v{};
  for (std::size_t i = 0; i < 4; ++i) v[i][i] = 1;
  constexpr int kSweeps = 30;
  for (int sweep = 0; sweep < kSweeps; ++sweep) {
    for (std::size_t p = 0; p < 4; ++p) {
      for (std::size_t q = p + 1; q < 4; ++q) {
        if (a[p][q] == 0) continue;
        const double angle = 0.5 * std::atan2(2 * a[p][q], a[q][q] - a[p][p]);
        const double c = std::cos(angle), s = std::sin(angle);
        for (auto& row : a) {
          const double ap = row[p], aq = row[q];
          row[p] = c * ap - s * aq;
          row[q] = s * ap + c * aq;
        }
        for (std::size_t k = 0; k < 4; ++k) {
          const double ap = a[p][k], aq = a[q][k];
          a[p][k] = c * ap - s * aq;
          a[q][k] = s * ap + c * aq;
        }
        for (auto& row : v) {
          const double vp = row[p], vq = row[q];
          row[p] = c * vp - s * vq;
          row[q] = s * vp + c * vq;
        }
      }
    }
  }
  std::size_t best = 0;
  for (std::size_t i = 1; i < 4; ++i) {
    if (a[i][i] > a[best][best]) best = i;
  }
  return {v[0][best], v[1][best], v[2][best], v[3][best]};
}

Vec3 mean(std::span<const Vec3> points) {
  Vec3 sum;
  for (const Vec3& p : points) sum = sum + p;
  return (1.0 / static_cast<double>(points.size())) * sum;
}

}  // namespace

std::expected<PoseFile, std::vector<Complaint>> read_pose_file(std::string_view text,
                                                               std::string_view file_name) {
  NumberReader reader(file_name);
  const std::string bytes = plain(text);
  const auto rows = rows_of(bytes);
  PoseFile pose;
  if (has_rows(rows, kNumbers, "a .pos file has ", reader)) pose = read_pose(rows, 1, reader);
  if (!reader.complaints().empty()) return std::unexpected(std::move(reader.complaints()));
  return pose;
}

std::expected<PlatformConfig, std::vector<Complaint>> read_platform_config(
    std::string_view text, std::string_view file_name) {
  NumberReader reader(file_name);
  const std::string bytes = plain(text);
  const auto rows = rows_of(bytes);
  PlatformConfig config;
  if (has_rows(rows, 2 + 2 * kNumbers, "a config.cfg has ", reader)) {
    config.port = rows[0];
    config.folder = rows[1];
    const std::span<const std::string_view> all = rows;
    config.real = read_pose(all.subspan(2, kNumbers), 3, reader);
    config.preview = read_pose(all.subspan(2 + kNumbers, kNumbers), 3 + kNumbers, reader);
  }
  if (!reader.complaints().empty()) return std::unexpected(std::move(reader.complaints()));
  return config;
}

std::string pose_text(const PoseFile& file, DecimalMark mark) {
  std::string out;
  const auto put = [&](double value) {
    std::array<char, 64> buffer{};
    const int size = std::snprintf(buffer.data(), buffer.size(), "%.9f", value + 0.0);
    std::string word(buffer.data(), static_cast<std::size_t>(size));
    word.erase(word.find_last_not_of('0') + 1);
    if (word.back() == '.') word.pop_back();
    if (word == "-0") word = "0";
    if (mark == DecimalMark::kComma) std::ranges::replace(word, '.', ',');
    out += word + "\n";
  };
  const auto put_three = [&](const Vec3& v) { put(v.x), put(v.y), put(v.z); };
  for (const Vec3& head : file.heads) put_three(to_mm(1) * head);
  put_three(to_mm(1) * file.translation_total);
  put_three(to_deg(1) * file.rotation_total);
  return out;
}

PlatformFit fit_platform(const std::array<Vec3, kLegs>& heads, const HexapodGeometry& geometry) {
  const Vec3 p_BM = mean(heads);
  const Vec3 p_PM = mean(geometry.p_PA);
  std::array<std::array<double, 3>, 3> S{};  // of what the platform has times what the base sees
  for (std::size_t leg = 0; leg < kLegs; ++leg) {
    const Vec3 a = geometry.p_PA[leg] - p_PM;
    const Vec3 b = heads[leg] - p_BM;
    const std::array<double, 3> from{a.x, a.y, a.z}, to{b.x, b.y, b.z};
    for (std::size_t i = 0; i < 3; ++i) {
      for (std::size_t j = 0; j < 3; ++j) S[i][j] += from[i] * to[j];
    }
  }
  const auto& [x, y, z] = S;
  const auto wxyz =
      largest_eigenvector({{{x[0] + y[1] + z[2], y[2] - z[1], z[0] - x[2], x[1] - y[0]},
                            {y[2] - z[1], x[0] - y[1] - z[2], x[1] + y[0], z[0] + x[2]},
                            {z[0] - x[2], x[1] + y[0], -x[0] + y[1] - z[2], y[2] + z[1]},
                            {x[1] - y[0], z[0] + x[2], y[2] + z[1], -x[0] - y[1] + z[2]}}});
  PlatformFit fit;
  fit.X_BP.R = rotation_from_quaternion(wxyz);
  fit.X_BP.p = p_BM - fit.X_BP.R * p_PM;
  for (std::size_t leg = 0; leg < kLegs; ++leg) {
    fit.residual = std::max(fit.residual, norm(heads[leg] - fit.X_BP * geometry.p_PA[leg]));
  }
  return fit;
}

PoseFile pose_file(const kinematics::PoseBP& X_BP, const HexapodGeometry& geometry) {
  PoseFile file;
  for (std::size_t leg = 0; leg < kLegs; ++leg) file.heads[leg] = X_BP * geometry.p_PA[leg];
  const auto& home = geometry.X_BP_home;
  file.translation_total = X_BP.p - home.p;
  file.rotation_total = fixed_xyz(X_BP.R * home.R.transposed());
  return file;
}

FixedVector<JointPosition, kMaxJoints> uncertain_legs(const PlatformFit& fit,
                                                      const RobotModel& robot) {
  const auto* geometry = std::get_if<HexapodGeometry>(&robot.geometry);
  SINEW_ASSERT(geometry != nullptr);
  FixedVector<JointPosition, kMaxJoints> legs;
  for (std::size_t leg = 0; leg < kLegs; ++leg) {
    const double length = norm(fit.X_BP * geometry->p_PA[leg] - geometry->p_BA[leg]);
    const Joint& limits = robot.joints[leg];
    legs.push_back({PositionQuality::kUncertain, length, limits.lower, limits.upper});
  }
  return legs;
}

}  // namespace sinew::program
