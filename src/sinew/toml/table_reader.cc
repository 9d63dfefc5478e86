#include "sinew/toml/table_reader.h"

#include <algorithm>
#include <cmath>

#include "sinew/core/number_text.h"
#include "sinew/core/spelling.h"

namespace sinew {
namespace {

const TomlEntry* find(const TomlTable& table, std::string_view key) {
  const auto found = std::ranges::find(table, key, &TomlEntry::key);
  return found == table.end() ? nullptr : &*found;
}

std::string with_unit(std::string_view pattern, std::string_view unit) {
  std::string key(pattern);
  const std::size_t star = key.find('*');
  if (star != std::string::npos) key.replace(star, 1, unit);
  return key;
}

std::string range_text(const Unit& unit, const Range& range) {
  const std::string upper = number_text(range.upper / unit.to_si);
  std::string text = range.lower_excluded ? "above 0 and at most " + upper
                                          : number_text(range.lower / unit.to_si) + " to " + upper;
  if (!unit.text.empty()) text += " " + std::string(unit.text);
  return text;
}

bool blank(std::string_view text) {
  return text.find_first_not_of(" \t\r\n") == std::string_view::npos;
}

}  // namespace

std::string any_of_text(std::span<const std::string_view> words) {
  std::string text;
  for (std::size_t i = 0; i < words.size(); ++i) {
    if (i > 0) text += i + 1 == words.size() ? " or " : ", ";
    text += "`" + std::string(words[i]) + "`";
  }
  return text;
}

std::string TableReader::dotted(std::string_view key) const {
  const std::string shown = printable(key);
  return path_.empty() ? shown : path_ + "." + shown;
}

void TableReader::complain(std::string_view pattern, std::string message) {
  const auto asked = std::ranges::find(asked_, pattern, &Asked::pattern);
  if (asked == asked_.end() || asked->entry == nullptr) {
    findings_->complain(place_, dotted(pattern), std::move(message));
  } else {
    findings_->complain(asked->entry->node.place, dotted(asked->entry->key), std::move(message));
  }
}

void TableReader::complain(std::string message) {
  findings_->complain(place_, path_, std::move(message));
}

void TableReader::wrong_type(const TomlNode& node, const std::string& key,
                             std::string_view wanted) {
  findings_->complain(node.place, key,
                      "must be " + std::string(wanted) + ", not " + std::string(type_name(node)));
}

const TomlEntry* TableReader::ask(std::string_view pattern, Dimension dimension, Presence presence,
                                  bool constant) {
  const bool required = presence == Presence::kRequired && next_ == Presence::kRequired;
  next_ = Presence::kRequired;
  Asked asked{
      .pattern = std::string(pattern), .spellings = {}, .required = required, .constant = constant};
  for (const Unit& unit : dimension) {
    asked.spellings.push_back(with_unit(pattern, unit.name));
    const TomlEntry* entry = find(*table_, asked.spellings.back());
    if (entry == nullptr) continue;
    if (asked.entry == nullptr) {
      asked.entry = entry;
      continue;
    }
    const TomlEntry* first = std::min(asked.entry, entry);  // entries stand in file order
    const TomlEntry* second = std::max(asked.entry, entry);
    findings_->complain(second->place, dotted(second->key),
                        "the same quantity stands in `" + first->key + "` already; keep one");
    asked.entry = first;
  }
  asked_.push_back(std::move(asked));
  return asked_.back().entry;
}

bool TableReader::real(const TomlNode& node, const std::string& key, const Unit& unit,
                       const Range& range, double& out) {
  double value = 0;
  if (const auto* real_value = std::get_if<double>(&node.value)) {
    value = *real_value;
  } else if (const auto* whole = std::get_if<std::int64_t>(&node.value)) {
    value = static_cast<double>(*whole);
  } else {
    wrong_type(node, key, "a number");
    return false;
  }
  const double value_si = value * unit.to_si;
  const bool high_enough = range.lower_excluded ? value_si > range.lower : value_si >= range.lower;
  const bool inside = high_enough && value_si <= range.upper;  // false for NaN, too
  if (!inside) {
    findings_->complain(node.place, key,
                        "must be " + range_text(unit, range) + ", not " + number_text(value));
    return false;
  }
  out = value_si;
  return true;
}

namespace {

/// The unit that the key of `entry` names; it was found by one of them.
const Unit& unit_of(std::string_view pattern, Dimension dimension, const TomlEntry& entry) {
  return *std::ranges::find_if(
      dimension, [&](const Unit& u) { return with_unit(pattern, u.name) == entry.key; });
}

}  // namespace

bool TableReader::quantity(std::string_view pattern, Dimension dimension, const Range& range,
                           double& out) {
  const TomlEntry* entry = ask(pattern, dimension, Presence::kRequired, true);
  if (entry == nullptr) return false;
  return real(entry->node, dotted(entry->key), unit_of(pattern, dimension, *entry), range, out);
}

bool TableReader::number(std::string_view key, const Range& range, double& out) {
  const TomlEntry* entry = ask(key, {&kPlain, 1}, Presence::kRequired, true);
  return entry != nullptr && real(entry->node, dotted(key), kPlain, range, out);
}

bool TableReader::three(std::string_view pattern, const TomlEntry* entry, const Unit& unit,
                        const Range& range, Vec3& out) {
  const auto* items = std::get_if<TomlArray>(&entry->node.value);
  if (items == nullptr) {
    wrong_type(entry->node, dotted(entry->key), "a list of three numbers");
    return false;
  }
  if (items->size() != 3) {
    complain(pattern, "must have three numbers, not " + std::to_string(items->size()));
    return false;
  }
  std::array<double, 3> values{};
  bool good = true;
  for (std::size_t i = 0; i < 3; ++i) {
    const std::string key = dotted(entry->key) + "[" + std::to_string(i + 1) + "]";
    good = real((*items)[i], key, unit, range, values[i]) && good;
  }
  if (good) out = {values[0], values[1], values[2]};
  return good;
}

bool TableReader::vector(std::string_view pattern, Dimension dimension, const Range& range,
                         Vec3& out) {
  const TomlEntry* entry = ask(pattern, dimension, Presence::kRequired, true);
  if (entry == nullptr) return false;
  return three(pattern, entry, unit_of(pattern, dimension, *entry), range, out);
}

bool TableReader::direction(std::string_view key, Vec3& out) {
  constexpr double kLongest = 1e3;
  constexpr double kShortest = 1e-3;  // shorter than this its rounding would turn it
  const TomlEntry* entry = ask(key, {&kPlain, 1}, Presence::kRequired, true);
  Vec3 written;
  if (entry == nullptr || !three(key, entry, kPlain, between(-kLongest, kLongest), written)) {
    return false;
  }
  if (norm(written) < kShortest) {
    complain(key, "must point somewhere: its length is below 0.001");
    return false;
  }
  out = normalized(written);
  return true;
}

bool TableReader::whole_number(std::string_view key, std::int64_t lower, std::int64_t upper,
                               std::int64_t& out) {
  const TomlEntry* entry = ask(key, {&kPlain, 1}, Presence::kRequired, true);
  if (entry == nullptr) return false;
  const auto* value = std::get_if<std::int64_t>(&entry->node.value);
  if (value == nullptr) {
    wrong_type(entry->node, dotted(key), "a whole number");
    return false;
  }
  if (*value < lower || *value > upper) {
    complain(key, "must be " + std::to_string(lower) + " to " + std::to_string(upper) + ", not " +
                      std::to_string(*value));
    return false;
  }
  out = *value;
  return true;
}

template <class T>
const T* TableReader::value_of(std::string_view key, std::string_view wanted) {
  const TomlEntry* entry = ask(key, {&kPlain, 1}, Presence::kRequired, false);
  if (entry == nullptr) return nullptr;
  const T* value = std::get_if<T>(&entry->node.value);
  if (value == nullptr) wrong_type(entry->node, dotted(key), wanted);
  return value;
}

bool TableReader::boolean(std::string_view key, bool& out) {
  const bool* value = value_of<bool>(key, "true or false");
  if (value != nullptr) out = *value;
  return value != nullptr;
}

bool TableReader::text(std::string_view key, std::size_t max_bytes, std::string& out) {
  const auto* value = value_of<std::string>(key, "a string");
  if (value == nullptr) return false;
  const bool control = std::ranges::any_of(
      *value, [](char c) { return static_cast<unsigned char>(c) < 0x20 || c == 0x7F; });
  if (blank(*value) || control || value->size() > max_bytes) {
    complain(key, "must be 1 to " + std::to_string(max_bytes) +
                      " bytes of text, not blank, without control characters");
    return false;
  }
  out = *value;
  return true;
}

bool TableReader::texts(std::string_view key, std::size_t max_bytes,
                        std::vector<std::string>& out) {
  const auto* items = value_of<TomlArray>(key, "a list of strings");
  if (items == nullptr) return false;
  std::vector<std::string> texts;
  for (const TomlNode& item : *items) {
    const auto* text = std::get_if<std::string>(&item.value);
    if (text == nullptr) {
      wrong_type(item, dotted(key), "a list of strings");
      return false;
    }
    if (!blank(*text) && text->size() <= max_bytes) texts.push_back(*text);
  }
  if (texts.empty() || texts.size() != items->size()) {
    complain(key, "must be a list of names, each of 1 to " + std::to_string(max_bytes) + " bytes");
    return false;
  }
  out = std::move(texts);
  return true;
}

bool TableReader::one_of(std::string_view key, std::span<const std::string_view> words,
                         std::size_t& index) {
  const TomlEntry* entry = ask(key, {&kPlain, 1}, Presence::kRequired, false);
  if (entry == nullptr) return false;
  const auto* value = std::get_if<std::string>(&entry->node.value);
  if (value == nullptr) {
    wrong_type(entry->node, dotted(key), "a string");
    return false;
  }
  const auto found = std::ranges::find(words, *value);
  if (found != words.end()) {
    index = static_cast<std::size_t>(found - words.begin());
    return true;
  }
  const std::string_view meant = nearest_spelling(*value, words);
  std::string message = "must be " + any_of_text(words) + ", not `" + printable(*value) + "`";
  if (!meant.empty()) message += "; did you mean `" + std::string(meant) + "`?";
  complain(key, std::move(message));
  return false;
}

std::optional<TableReader> TableReader::table(std::string_view key, Presence presence) {
  const TomlEntry* entry = ask(key, {&kPlain, 1}, presence, false);
  if (entry == nullptr) return std::nullopt;
  const auto* inner = std::get_if<TomlTable>(&entry->node.value);
  if (inner == nullptr) {
    wrong_type(entry->node, dotted(key), "a table");
    return std::nullopt;
  }
  return TableReader(*inner, entry->node.place, dotted(key), *findings_);
}

std::vector<TableReader> TableReader::table_or_tables(std::string_view key) {
  const TomlEntry* entry = ask(key, {&kPlain, 1}, Presence::kOptional, false);
  if (entry == nullptr) return {};
  if (std::holds_alternative<TomlArray>(entry->node.value)) return tables(key, Presence::kOptional);
  std::vector<TableReader> readers;
  if (auto one = table(key, Presence::kOptional)) readers.push_back(std::move(*one));
  return readers;
}

std::vector<TableReader> TableReader::tables(std::string_view key, Presence presence) {
  std::vector<TableReader> readers;
  const TomlEntry* entry = ask(key, {&kPlain, 1}, presence, false);
  if (entry == nullptr) return readers;
  const auto* items = std::get_if<TomlArray>(&entry->node.value);
  if (items == nullptr) {
    wrong_type(entry->node, dotted(key), "a list of tables, each under [[" + dotted(key) + "]]");
    return readers;
  }
  for (const TomlNode& item : *items) {
    const std::string path = dotted(key) + "[" + std::to_string(readers.size() + 1) + "]";
    const auto* inner = std::get_if<TomlTable>(&item.value);
    if (inner == nullptr) {
      wrong_type(item, path, "a table");
      return {};
    }
    readers.emplace_back(*inner, item.place, path, *findings_);
  }
  return readers;
}

}  // namespace sinew
