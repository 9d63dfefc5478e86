#include "sinew/program/language/row_reader.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "sinew/core/spelling.h"

namespace sinew::program {

std::string listed(const std::vector<std::string>& names) {
  std::string all;
  for (const std::string& one : names) all += (all.empty() ? "" : " ") + one;
  return all;
}

std::string in_quotes(std::string_view text) {
  return "'" + printable(text) + "'";
}

void RowReader::begin(int number, std::string_view line) {
  line_ = number;
  line = line.substr(0, line.find('#'));
  words_.clear();
  std::size_t place = 0;
  while ((place = line.find_first_not_of(" \t", place)) != std::string_view::npos) {
    const std::size_t end = std::min(line.find_first_of(" \t", place), line.size());
    words_.push_back({line.substr(place, end - place), static_cast<int>(place) + 1});
    place = end;
  }
}

void RowReader::complain_in(int line, const Word& word, std::string message) {
  if (!full()) complaints_.push_back({file_name_, line, word.column, "", std::move(message)});
}

bool RowReader::takes_words(std::size_t count, std::string_view example) {
  if (words_.size() == count + 1) return true;
  const bool more = words_.size() > count + 1;
  complain(
      more ? words_[count + 1] : words_.back(),
      (more ? "too many words; write " : "something is missing; write ") + std::string(example));
  return false;
}

std::optional<double> RowReader::quantity(const Word& word, std::string_view text,
                                          Measure measure) {
  const auto value = parse_quantity(text, measure, UnitRule::kRequired);
  if (!value) complain(word, value.error());
  return value ? std::optional(*value) : std::nullopt;
}

std::optional<Vec3> RowReader::point(const Word& word, std::string_view text) {
  if (std::ranges::count(text, ',') != 2) {
    complain(word, in_quotes(text) + ": a point is X,Y,Z, as in 200mm,0mm,150mm");
    return std::nullopt;
  }
  std::array<double, 3> p{};
  for (double& value : p) {
    const std::size_t end = std::min(text.find(','), text.size());
    const auto read = quantity(word, text.substr(0, end), Measure::kLength);
    if (!read) return std::nullopt;
    if (std::abs(*read) > kFarAway) {
      complain(word, in_quotes(text) + " is farther away than 100 m");
      return std::nullopt;
    }
    value = *read;
    text.remove_prefix(std::min(end + 1, text.size()));
  }
  return Vec3{p[0], p[1], p[2]};
}

}  // namespace sinew::program
