#include "sinew/program/formats/program_format.h"

#include <algorithm>
#include <array>
#include <optional>

#include "sinew/program/language/program_rows.h"
#include "sinew/program/language/row_reader.h"

namespace sinew::program {
namespace {

/// Longer rows are not lined up with: they would push their neighbours' remarks out of sight.
constexpr std::size_t kAlignMax = 60;

/// In the order in which rows show them; joints, and whatever is unknown, stand before speed.
constexpr std::array<std::string_view, 19> kBefore{
    "via", "to", "x",  "y",      "z",     "pitch", "roll", "rx",  "ry",   "rz",
    "dx",  "dy", "dz", "dpitch", "droll", "drx",   "dry",  "drz", "frame"};
constexpr std::array<std::string_view, 4> kBehind{"speed", "accel", "blend", "time"};

/// Where a word stands among its row's others.
std::size_t rank_of(std::string_view row, std::string_view word) {
  const std::size_t equals = word.find('=');
  if (equals == std::string_view::npos) return 0;
  const std::string_view name = word.substr(0, equals);
  const auto option = std::ranges::find(kBehind, name);
  if (option != kBehind.end()) {
    // The joints' share before the tool's speed.
    const std::size_t of_tool = word.ends_with("/s") ? 1 : 0;
    return 100 + 2 * static_cast<std::size_t>(option - kBehind.begin()) + of_tool;
  }
  if (row == "joint") return name == "to" ? 1 : 2;
  const auto place = std::ranges::find(kBefore, name);
  return 1 + static_cast<std::size_t>(place - kBefore.begin());
}

std::size_t characters(std::string_view text) {
  return static_cast<std::size_t>(
      std::ranges::count_if(text, [](char c) { return (c & 0xC0) != 0x80; }));
}

struct Row {
  std::string code;    ///< indented
  std::string remark;  ///< with its #
  bool empty() const { return code.empty() && remark.empty(); }
};

class Layout {
 public:
  explicit Layout(std::string_view file_name) : reader_(file_name) {}

  void take(int number, std::string_view line) {
    reader_.begin(number, line);
    Row row;
    if (const std::size_t mark = line.find('#'); mark != std::string_view::npos) {
      row.remark = line.substr(mark);
      std::ranges::replace(row.remark, '\t', ' ');
      row.remark.erase(row.remark.find_last_not_of(" \r") + 1);
    }
    if (!reader_.words().empty()) row.code = code();
    if (row.empty() && (rows_.empty() || rows_.back().empty())) return;
    if (row.code.empty() && !row.remark.empty()) {
      row.code = std::string(2 * open_.size(), ' ');
      row.code += row.remark;
      row.remark.clear();
    }
    rows_.push_back(std::move(row));
  }

  std::expected<std::string, std::vector<Complaint>> finish() {
    for (const auto& [line, name] : open_) {
      reader_.complain_in(line, Word{name, 1},
                          name + " without end: write end behind its last step");
    }
    if (!reader_.complaints().empty()) return std::unexpected(std::move(reader_.complaints()));
    while (!rows_.empty() && rows_.back().empty()) rows_.pop_back();
    std::string out;
    for (std::size_t i = 0; i < rows_.size();) {
      const std::size_t last = neighbours_end(i);
      std::size_t widest = 0;
      for (std::size_t k = i; k < last; ++k) widest = std::max(widest, characters(rows_[k].code));
      for (; i < last; ++i) {
        out += rows_[i].code;
        if (!rows_[i].remark.empty()) {
          out += std::string(widest - characters(rows_[i].code) + 2, ' ') + rows_[i].remark;
        }
        out += '\n';
      }
    }
    return out;
  }

  bool full() const { return reader_.full(); }

 private:
  struct Open {
    int line = 0;
    std::string name;
  };

  /// Rows whose remarks are lined up with that of row `i`.
  std::size_t neighbours_end(std::size_t i) const {
    const auto joins = [&](std::size_t k) {
      return !rows_[k].remark.empty() && characters(rows_[k].code) <= kAlignMax;
    };
    if (!joins(i)) return i + 1;
    while (i < rows_.size() && joins(i)) ++i;
    return i;
  }

  std::string code() {
    const auto& words = reader_.words();
    const std::string_view name = words[0].text;
    if (const auto why = unknown_row(name)) reader_.complain(words[0], *why);
    for (const Word& word : words) {
      const auto control = [](char c) { return static_cast<unsigned char>(c) < 0x20; };
      if (std::ranges::any_of(word.text, control)) {
        reader_.complain(word, in_quotes(word.text) + " has a control character in it");
      }
    }
    const bool closes = name == "end" || name == "else";
    if (closes && (open_.empty() || (name == "else" && open_.back().name != "if"))) {
      reader_.complain(words[0], name == "end" ? "end without loop or if" : "else without if");
    }
    if (name == "end" && !open_.empty()) open_.pop_back();
    const std::size_t depth = open_.size() - (name == "else" && !open_.empty() ? 1 : 0);
    if (name == "loop" || name == "if" || name == "repeat") {
      open_.push_back({reader_.line(), std::string(name)});
    }
    std::string out(2 * depth, ' ');
    out += name;
    for (const std::string& word : arguments()) out += " " + word;
    return out;
  }

  std::vector<std::string> arguments() const {
    const auto& words = reader_.words();
    const std::string_view name = words[0].text;
    std::vector<std::string> out;
    for (const Word& word : std::span(words).subspan(1)) out.emplace_back(word.text);
    const bool looks = !out.empty() && out[0] == "seen";
    if (name == "if" && !looks) join(out, 0, out.size());
    if (name == "wait" && out.size() >= 4 && out[0] == "until" && out[out.size() - 2] == "for") {
      join(out, 1, out.size() - 2);
    }
    constexpr std::array<std::string_view, 7> kSorted{"joint",  "move",   "line", "arc",
                                                      "spline", "nozzle", "place"};
    if (std::ranges::find(kSorted, name) == kSorted.end()) return out;
    std::vector<std::pair<std::size_t, std::size_t>> order;
    for (std::size_t i = 0; i < out.size(); ++i) order.emplace_back(rank_of(name, out[i]), i);
    std::ranges::sort(order);
    std::vector<std::string> sorted;
    for (const auto& [rank, place] : order) sorted.push_back(std::move(out[place]));
    return sorted;
  }

  /// A condition is one word.
  static void join(std::vector<std::string>& words, std::size_t first, std::size_t last) {
    if (last <= first + 1) return;
    std::string all;
    for (std::size_t i = first; i < last; ++i) all += words[i];
    const auto at = words.begin() + static_cast<std::ptrdiff_t>(first);
    words.erase(at + 1, words.begin() + static_cast<std::ptrdiff_t>(last));
    words[first] = std::move(all);
  }

  RowReader reader_;
  std::vector<Open> open_;
  std::vector<Row> rows_;
};

}  // namespace

std::expected<std::string, std::vector<Complaint>> format(std::string_view text,
                                                          std::string_view file_name) {
  Layout layout(file_name);
  for_each_line(text, [&](int number, std::string_view line) {
    layout.take(number, line);
    return !layout.full();
  });
  return layout.finish();
}

}  // namespace sinew::program
