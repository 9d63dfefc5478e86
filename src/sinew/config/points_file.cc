#include "sinew/config/points_file.h"

#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>
#include <iterator>
#include <span>

#include "sinew/core/number_text.h"
#include "sinew/core/spelling.h"
#include "sinew/core/units.h"
#include "sinew/toml/findings.h"
#include "sinew/toml/toml_tree.h"

namespace sinew {
namespace {

constexpr std::size_t kPointsMax = 10'000;
constexpr std::size_t kPointNameMax = 40;  // bytes
constexpr std::size_t kTextMax = 200;      // bytes
constexpr double kFarAway = 100e3;         // mm
constexpr double kTurnMax = 720;           // deg
constexpr int kDigits = 9;                 // behind the point

constexpr std::array<std::string_view, 14> kKeys{
    "robot",  "joints_deg", "legs_mm", "joints", "x_mm",      "y_mm",      "z_mm",
    "rx_deg", "ry_deg",     "rz_deg",  "source", "taught_at", "pitch_deg", "roll_deg"};
/// What names the joints: as numbers of one unit, or as texts with a unit each.
constexpr std::array<std::string_view, 3> kJointKeys{"joints_deg", "legs_mm", "joints"};

std::uint8_t bit(std::size_t joint) {
  return static_cast<std::uint8_t>(1U << joint);
}

/// One [points.NAME].
class PointReader {
 public:
  PointReader(const TomlEntry& entry, const TomlTable& table, Findings& findings)
      : place_(entry.place), path_("points." + entry.key), table_(table), findings_(findings) {}

  std::optional<TaughtPoint> read(std::string name) {
    TaughtPoint point;
    point.name = std::move(name);
    for (const TomlEntry& entry : table_) check_known(entry);
    text("robot", point.robot);
    text("source", point.source);
    text("taught_at", point.taught_at);
    if (point.robot.empty() && find("robot") == nullptr) {
      complain(place_, "robot", "is missing: which robot's point is it? as in robot = \"learm\"");
    }
    read_place(point);
    return good_ ? std::optional(std::move(point)) : std::nullopt;
  }

 private:
  void complain(Place place, std::string_view key, std::string message) {
    good_ = false;
    findings_.complain(place, path_ + (key.empty() ? "" : "." + std::string(key)),
                       std::move(message));
  }

  void check_known(const TomlEntry& entry) {
    if (std::ranges::find(kKeys, entry.key) != kKeys.end()) return;
    const std::string_view meant = nearest_spelling(entry.key, kKeys);
    complain(entry.place, printable(entry.key),
             meant.empty() ? "no point has this key"
                           : "no point has this key; did you mean " + std::string(meant) + "?");
  }

  const TomlEntry* find(std::string_view key) const {
    const auto found = std::ranges::find(table_, key, &TomlEntry::key);
    return found != table_.end() ? &*found : nullptr;
  }

  void text(std::string_view key, std::string& out) {
    const TomlEntry* entry = find(key);
    if (entry == nullptr) return;
    const auto* value = std::get_if<std::string>(&entry->node.value);
    if (value == nullptr) {
      return complain(entry->node.place, key,
                      "must be a string, not " + std::string(type_name(entry->node)));
    }
    const auto control = [](char c) { return static_cast<unsigned char>(c) < 0x20 || c == 0x7F; };
    if (value->empty() || value->size() > kTextMax || std::ranges::any_of(*value, control)) {
      return complain(entry->node.place, key, "must be 1 to 200 bytes without control characters");
    }
    out = *value;
  }

  bool real(const TomlNode& node, std::string_view key, double largest, double& out) {
    if (const auto* whole = std::get_if<std::int64_t>(&node.value)) {
      out = static_cast<double>(*whole);
    } else if (const auto* value = std::get_if<double>(&node.value)) {
      out = *value;
    } else {
      complain(node.place, key, "must be a number, not " + std::string(type_name(node)));
      return false;
    }
    return in_range(node, key, largest, out);
  }

  bool in_range(const TomlNode& node, std::string_view key, double largest, double out) {
    if (std::abs(out) <= largest) return true;  // not of NaN
    complain(node.place, key,
             "must be -" + number_text(largest) + " to " + number_text(largest) + ", not " +
                 number_text(out));
    return false;
  }

  std::optional<double> number(std::string_view key, double largest) {
    const TomlEntry* entry = find(key);
    double value = 0;
    if (entry == nullptr || !real(entry->node, key, largest, value)) return std::nullopt;
    return value;
  }

  void read_place(TaughtPoint& point) {
    std::vector<std::string_view> joints;
    std::ranges::copy_if(kJointKeys, std::back_inserter(joints),
                         [&](std::string_view key) { return find(key) != nullptr; });
    const auto of_tool = [](const TomlEntry& entry) {
      return entry.key.size() <= 9 && (entry.key.ends_with("_mm") || entry.key.ends_with("_deg")) &&
             entry.key != "legs_mm";
    };
    const auto first = std::ranges::find_if(table_, of_tool);
    if (joints.empty() && first == table_.end()) {
      return complain(place_, "",
                      "has no place: joints_deg, legs_mm, joints, or x_mm, y_mm and z_mm");
    }
    if (joints.size() > 1) {
      return complain(find(joints[1])->place, joints[1], std::string(joints[0]) + " says that");
    }
    if (!joints.empty() && first != table_.end()) {
      return complain(first->place, first->key,
                      std::string(joints[0]) +
                          " names the place already: a point is joints or the tool's, not both");
    }
    if (!joints.empty()) return read_joints(joints[0], point);
    read_tool(point);
  }

  /// "12.5mm" or "-90deg", of joints of both kinds; else a number in the unit of the key.
  bool joint_value(const TomlNode& node, std::string_view key, bool& slides, double& out) {
    std::string_view text;
    if (key == "joints") {
      const auto* value = std::get_if<std::string>(&node.value);
      text = value != nullptr ? *value : std::string_view();
      slides = text.ends_with("mm");
      const bool turns = text.ends_with("deg");
      if (turns || slides) text.remove_suffix(turns ? 3 : 2);
      const auto end = text.data() + text.size();
      const auto read = std::from_chars(text.data(), end, out);
      if ((!turns && !slides) || read.ec != std::errc() || read.ptr != end) {
        complain(node.place, key, "must be texts with their units, as in [\"90deg\", \"-20mm\"]");
        return false;
      }
      if (!in_range(node, key, slides ? kFarAway : kTurnMax, out)) return false;
    } else {
      slides = key == "legs_mm";
      if (!real(node, key, slides ? kFarAway : kTurnMax, out)) return false;
    }
    out = slides ? from_mm(out) : from_deg(out);
    return true;
  }

  void read_joints(std::string_view key, TaughtPoint& point) {
    const TomlEntry& entry = *find(key);
    const auto* list = std::get_if<TomlArray>(&entry.node.value);
    if (list == nullptr || list->empty() || list->size() > kMaxJoints) {
      return complain(entry.node.place, key,
                      "must be a list of 1 to " + std::to_string(kMaxJoints) +
                          (key == "joints" ? " texts" : " numbers"));
    }
    JointVector q;
    for (const TomlNode& node : *list) {
      double value = 0;
      bool slides = false;
      if (!joint_value(node, key, slides, value)) return;
      if (slides) point.lengths |= bit(q.size());
      q.push_back(value);
    }
    point.place = q;
  }

  /// All of these keys, or none of them.
  std::optional<std::vector<double>> together(std::span<const std::string_view> keys,
                                              double largest) {
    std::vector<double> values;
    const TomlEntry* given = nullptr;
    std::string missing;
    for (const std::string_view key : keys) {
      const TomlEntry* entry = find(key);
      if (entry == nullptr) {
        missing += (missing.empty() ? "" : ", ") + std::string(key);
        continue;
      }
      given = entry;
      const auto value = number(key, largest);
      if (value) values.push_back(*value);
    }
    if (given != nullptr && !missing.empty()) {
      complain(given->place, given->key, "needs " + missing + " beside it");
    }
    return values.size() == keys.size() ? std::optional(values) : std::nullopt;
  }

  void read_tool(TaughtPoint& point) {
    constexpr std::array<std::string_view, 3> kPosition{"x_mm", "y_mm", "z_mm"};
    constexpr std::array<std::string_view, 3> kTurnKeys{"rx_deg", "ry_deg", "rz_deg"};
    constexpr std::array<std::string_view, 2> kPitchRoll{"pitch_deg", "roll_deg"};
    const auto p = together(kPosition, kFarAway);
    const auto turn = together(kTurnKeys, kTurnMax);
    const auto attitude = together(kPitchRoll, kTurnMax);
    if (!p) {
      if (good_) complain(place_, "", "x_mm, y_mm and z_mm are missing");
      return;
    }
    if (turn && attitude) {
      return complain(find("pitch_deg")->place, "pitch_deg",
                      "rx_deg, ry_deg and rz_deg say the orientation already");
    }
    ToolPlace place{{from_mm((*p)[0]), from_mm((*p)[1]), from_mm((*p)[2])}, {}, {}, {}};
    if (turn) {
      place.R_BT = rotation_from_fixed_xyz(
          {from_deg((*turn)[0]), from_deg((*turn)[1]), from_deg((*turn)[2])});
    }
    if (attitude) {
      place.pitch = from_deg((*attitude)[0]);
      place.roll = from_deg((*attitude)[1]);
    }
    point.place = place;
  }

  Place place_;
  std::string path_;
  const TomlTable& table_;
  Findings& findings_;
  bool good_ = true;
};

void read_one(const TomlEntry& entry, Findings& findings, TaughtPoints& points) {
  const auto* one = std::get_if<TomlTable>(&entry.node.value);
  if (one == nullptr) {
    findings.complain(entry.node.place, "points." + printable(entry.key),
                      "must be a table: [points." + printable(entry.key) + "]");
  } else if (!is_point_name(entry.key)) {
    findings.complain(entry.place, "points." + printable(entry.key),
                      "a name is a letter and then letters, digits, - and _, 40 at most");
  } else if (points.size() == kPointsMax) {
    findings.complain(entry.place, "points", "has more than 10000 points");
  } else if (auto point = PointReader(entry, *one, findings).read(entry.key)) {
    points.push_back(std::move(*point));
  }
}

void read_all(const TomlEntry& root, Findings& findings, TaughtPoints& points) {
  const auto* table = std::get_if<TomlTable>(&root.node.value);
  if (table == nullptr) {
    return findings.complain(root.node.place, "points",
                             "must be a table: write each point below its [points.NAME]");
  }
  for (const TomlEntry& entry : *table) read_one(entry, findings, points);
}

TaughtPoint unusable(const std::string& name, const Complaint& why) {
  TaughtPoint point;
  point.name = name;
  point.wrong = to_text(why);
  return point;
}

std::string in_quotes(const std::string& text) {
  std::string out = "\"";
  for (const char c : text) {
    if (c == '"' || c == '\\') out += '\\';
    out += c;
  }
  return out + '"';
}

void put_joints(const JointVector& q, std::uint8_t lengths, std::string& out) {
  const bool all = lengths == (1U << q.size()) - 1;
  const bool mixed = lengths != 0 && !all;
  out += std::string(kJointKeys[mixed ? 2 : all ? 1 : 0]) + " = [";
  for (std::size_t i = 0; i < q.size(); ++i) {
    const bool slides = (lengths & bit(i)) != 0;
    const std::string value = number_text(slides ? to_mm(q[i]) : to_deg(q[i]), kDigits);
    out += i == 0 ? "" : ", ";
    out += mixed ? in_quotes(value + (slides ? "mm" : "deg")) : value;
  }
  out += "]\n";
}

void put_tool(const ToolPlace& place, std::string& out) {
  const auto put = [&](const char* key, double value) {
    out += std::string(key) + " = " + number_text(value, kDigits) + "\n";
  };
  put("x_mm", to_mm(place.p_BT.x));
  put("y_mm", to_mm(place.p_BT.y));
  put("z_mm", to_mm(place.p_BT.z));
  if (place.R_BT) {
    const Vec3 rpy = fixed_xyz(*place.R_BT);
    put("rx_deg", to_deg(rpy.x));
    put("ry_deg", to_deg(rpy.y));
    put("rz_deg", to_deg(rpy.z));
  }
  if (place.pitch) put("pitch_deg", to_deg(*place.pitch));
  if (place.roll) put("roll_deg", to_deg(*place.roll));
}

/// A line without blanks around it and without what stands behind a #.
std::string_view content_of(std::string_view line) {
  line = line.substr(0, line.find('#'));
  const std::size_t first = line.find_first_not_of(" \t\r\n");
  if (first == std::string_view::npos) return {};
  return line.substr(first, line.find_last_not_of(" \t\r\n") - first + 1);
}

/// Lines with their ends.
std::vector<std::string_view> lines_of(std::string_view text) {
  std::vector<std::string_view> lines;
  while (!text.empty()) {
    const std::size_t end = std::min(text.find('\n'), text.size() - 1) + 1;
    lines.push_back(text.substr(0, end));
    text.remove_prefix(end);
  }
  return lines;
}

std::string joined_lines(std::span<const std::string_view> lines) {
  std::string text;
  for (const std::string_view line : lines) text += line;
  return text;
}

using Lines = std::vector<std::string_view>;
using Changed = std::expected<std::string, std::vector<Complaint>>;

std::unexpected<std::vector<Complaint>> cannot(std::string_view file_name, std::string why) {
  return std::unexpected(std::vector{Complaint{std::string(file_name), 1, 1, "", std::move(why)}});
}

bool holds(const TaughtPoints& points, std::string_view name) {
  return std::ranges::find(points, name, &TaughtPoint::name) != points.end();
}

/// The lines of a point's table; remarks above the next one are that one's.
struct TableLines {
  Lines lines;
  std::size_t begin = 0;
  std::size_t end = 0;

  std::string before() const { return joined_lines({lines.data(), begin}); }
  std::string behind() const { return joined_lines({lines.data() + end, lines.size() - end}); }
};

std::expected<TableLines, std::vector<Complaint>> table_of(std::string_view toml,
                                                           std::string_view file_name,
                                                           std::string_view name) {
  TableLines table{lines_of(toml)};
  const std::string header = "[points." + std::string(name) + "]";
  const auto at = [&](std::size_t i) { return content_of(table.lines[i]); };
  while (table.begin < table.lines.size() && at(table.begin) != header) ++table.begin;
  if (table.begin == table.lines.size()) {
    return cannot(file_name, "the point '" + std::string(name) + "' is there, but not as a table " +
                                 header + "; change it by hand");
  }
  table.end = table.begin + 1;
  while (table.end < table.lines.size() && !at(table.end).starts_with('[')) ++table.end;
  while (table.end != table.begin + 1 && at(table.end - 1).empty()) --table.end;
  return table;
}

}  // namespace

Changed with_point(std::string_view toml, std::string_view file_name, const TaughtPoint& point) {
  const auto before = read_points(toml, file_name);
  if (!before) return std::unexpected(before.error());
  const std::string written_point = points_text({point});
  if (!holds(*before, point.name)) {
    std::string text(toml);
    if (!text.empty() && text.back() != '\n') text += "\n";
    return text + (text.empty() ? "" : "\n") + written_point;
  }
  const auto table = table_of(toml, file_name, point.name);
  if (!table) return std::unexpected(table.error());
  return table->before() + written_point + table->behind();
}

Changed without_point(std::string_view toml, std::string_view file_name, std::string_view name) {
  const auto before = read_points(toml, file_name);
  if (!before) return std::unexpected(before.error());
  if (!holds(*before, name)) {
    return cannot(file_name, "there is no point '" + std::string(name) + "'");
  }
  auto table = table_of(toml, file_name, name);
  if (!table) return std::unexpected(table.error());
  // Its empty line goes with it.
  const auto empty = [&](std::size_t i) {
    return table->lines[i].find_first_not_of(" \t\r\n") == std::string_view::npos;
  };
  if (table->end < table->lines.size() && empty(table->end)) {
    ++table->end;
  } else if (table->end == table->lines.size() && table->begin > 0 && empty(table->begin - 1)) {
    --table->begin;
  }
  return table->before() + table->behind();
}

Changed with_point_renamed(std::string_view toml, std::string_view file_name, std::string_view name,
                           std::string_view to) {
  const auto before = read_points(toml, file_name);
  if (!before) return std::unexpected(before.error());
  if (!holds(*before, name)) {
    return cannot(file_name, "there is no point '" + std::string(name) + "'");
  }
  if (holds(*before, to)) {
    return cannot(file_name, "there is a point '" + std::string(to) + "' already");
  }
  const auto table = table_of(toml, file_name, name);
  if (!table) return std::unexpected(table.error());
  std::string header(table->lines[table->begin]);
  const std::string old = "[points." + std::string(name) + "]";
  header.replace(header.find(old), old.size(), "[points." + std::string(to) + "]");
  const auto rest =
      std::span(table->lines).subspan(table->begin + 1, table->end - table->begin - 1);
  return table->before() + header + joined_lines(rest) + table->behind();
}

bool is_point_name(std::string_view name) {
  const auto letter = [](char c) { return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z'); };
  const auto inner = [&](char c) {
    return letter(c) || (c >= '0' && c <= '9') || c == '-' || c == '_';
  };
  return !name.empty() && name.size() <= kPointNameMax && letter(name.front()) &&
         std::ranges::all_of(name, inner);
}

std::expected<TaughtPoints, std::vector<Complaint>> read_points(std::string_view toml,
                                                                std::string_view file_name) {
  const auto tree = parse_toml_file(toml, file_name);
  if (!tree) return std::unexpected(tree.error());
  Findings findings{std::string(file_name)};
  TaughtPoints points;
  for (const TomlEntry& entry : *tree) {
    if (entry.key == "points") {
      read_all(entry, findings, points);
    } else {
      findings.complain(entry.place, printable(entry.key),
                        "a file of points has nothing but [points.NAME]");
    }
  }
  if (!findings.clean()) return std::unexpected(findings.take_complaints());
  return points;
}

TaughtPoints usable_points(std::string_view toml, std::string_view file_name) {
  auto tree = parse_toml_file(toml, file_name);
  if (!tree) return {unusable("", tree.error().front())};
  TaughtPoints points;
  const auto root = std::ranges::find(*tree, "points", &TomlEntry::key);
  if (root == tree->end()) return points;
  const auto* table = std::get_if<TomlTable>(&root->node.value);
  for (std::size_t i = 0; table != nullptr && i < table->size(); ++i) {
    Findings findings{std::string(file_name)};
    const TomlEntry& entry = (*table)[i];
    read_one(entry, findings, points);
    if (!findings.clean()) points.push_back(unusable(entry.key, findings.take_complaints()[0]));
  }
  return points;
}

std::string points_text(const TaughtPoints& points) {
  std::string out;
  for (const TaughtPoint& point : points) {
    if (!out.empty()) out += "\n";
    out += "[points." + point.name + "]\nrobot = " + in_quotes(point.robot) + "\n";
    if (const auto* q = std::get_if<JointVector>(&point.place)) {
      put_joints(*q, point.lengths, out);
    } else {
      put_tool(std::get<ToolPlace>(point.place), out);
    }
    if (!point.source.empty()) out += "source = " + in_quotes(point.source) + "\n";
    if (!point.taught_at.empty()) out += "taught_at = " + in_quotes(point.taught_at) + "\n";
  }
  return out;
}

}  // namespace sinew
