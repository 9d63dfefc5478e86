// The closing half of TableReader: what was not asked for, what is missing, where numbers are from.

#include <algorithm>

#include "sinew/core/spelling.h"
#include "sinew/toml/table_reader.h"

namespace sinew {
namespace {

constexpr std::string_view kSource = "source";
constexpr std::string_view kRest = "rest";
constexpr std::size_t kMaxSourceBytes = 1000;

/// "velocity_*_max" -> "velocity_max"; empty for a pattern that has no unit.
std::string without_unit(std::string_view pattern) {
  const std::size_t star = pattern.find('*');
  if (star == std::string_view::npos) return {};
  std::string key(pattern);
  const bool after_bar = star > 0 && key[star - 1] == '_';
  key.erase(after_bar ? star - 1 : star, 2);
  return key;
}

std::vector<std::string_view> views(const std::vector<std::string>& words) {
  return {words.begin(), words.end()};
}

bool says_something(const TomlNode& node) {
  const auto* text = std::get_if<std::string>(&node.value);
  return text != nullptr && text->find_first_not_of(" \t\r\n") != std::string::npos &&
         text->size() <= kMaxSourceBytes;
}

}  // namespace

void TableReader::check_unknown(const TomlEntry& entry) {
  std::vector<std::string_view> candidates{kSource};
  for (Asked& asked : asked_) {
    if (without_unit(asked.pattern) == entry.key) {
      findings_->complain(entry.place, dotted(entry.key),
                          "missing unit: write " + any_of_text(views(asked.spellings)));
      asked.excused = true;
      return;
    }
    for (const std::string& spelling : asked.spellings) candidates.push_back(spelling);
  }
  const std::string_view meant = nearest_spelling(entry.key, candidates);
  if (ignore_rest_ && !is_missing(meant)) return;
  if (meant.empty()) {
    findings_->complain(entry.place, dotted(entry.key),
                        "unknown key; known here are " + any_of_text(candidates));
    return;
  }
  findings_->complain(entry.place, dotted(entry.key),
                      "unknown key; did you mean `" + std::string(meant) + "`?");
  source_excused_ = source_excused_ || meant == kSource;
  for (Asked& asked : asked_) {
    if (std::ranges::find(asked.spellings, meant) != asked.spellings.end()) asked.excused = true;
  }
}

bool TableReader::is_missing(std::string_view spelling) const {
  return std::ranges::any_of(asked_, [&](const Asked& asked) {
    return asked.entry == nullptr &&
           std::ranges::find(asked.spellings, spelling) != asked.spellings.end();
  });
}

void TableReader::finish() {
  for (const TomlEntry& entry : *table_) {
    const bool known =
        entry.key == kSource || std::ranges::any_of(asked_, [&](const Asked& asked) {
          return std::ranges::find(asked.spellings, entry.key) != asked.spellings.end();
        });
    if (!known) check_unknown(entry);
  }
  for (const Asked& asked : asked_) {
    if (asked.entry != nullptr || !asked.required || asked.excused) continue;
    const bool has_units = asked.spellings.size() > 1;
    findings_->complain(place_, dotted(has_units ? without_unit(asked.pattern) : asked.pattern),
                        "missing: write " + any_of_text(views(asked.spellings)));
  }
  check_sources();
}

std::vector<const TomlEntry*> TableReader::constants() const {
  std::vector<const TomlEntry*> entries;
  for (const Asked& asked : asked_) {
    if (asked.constant && asked.entry != nullptr) entries.push_back(asked.entry);
  }
  return entries;
}

void TableReader::note_assumed(std::string_view key, std::string source) {
  findings_->note_source({dotted(key), place_.line, std::move(source)});
}

void TableReader::source_of_all() {
  const auto source = std::ranges::find(*table_, kSource, &TomlEntry::key);
  if (source == table_->end()) return;
  if (!says_something(source->node)) {
    findings_->complain(source->node.place, dotted(kSource),
                        "must be a string here: it counts for every table that has none");
    return;
  }
  findings_->set_usual_source(std::get<std::string>(source->node.value));
}

void TableReader::note_source(const TomlEntry& entry, const std::string& source) {
  findings_->note_source({dotted(entry.key), entry.place.line, source});
}

void TableReader::check_sources() {
  const auto source = std::ranges::find(*table_, kSource, &TomlEntry::key);
  if (source == table_->end()) {
    if (constants().empty() || source_excused_) return;
    if (findings_->usual_source().empty()) {
      findings_->complain(place_, dotted(kSource),
                          "missing: write where these numbers come from, or \"assumed\"");
    }
    for (const TomlEntry* entry : constants()) note_source(*entry, findings_->usual_source());
    return;
  }
  if (const auto* sources = std::get_if<TomlTable>(&source->node.value)) {
    check_source_table(*source, *sources);
    return;
  }
  if (!says_something(source->node)) {
    findings_->complain(source->node.place, dotted(kSource),
                        "must be a string that says where these numbers come from, or a table "
                        "with one string per key");
    return;
  }
  for (const TomlEntry* entry : constants()) {
    note_source(*entry, std::get<std::string>(source->node.value));
  }
}

void TableReader::check_source_table(const TomlEntry& source, const TomlTable& sources) {
  std::vector<std::string_view> names{kRest};
  for (const Asked& asked : asked_) {
    if (!asked.constant) continue;
    if (asked.entry != nullptr) {
      names.push_back(asked.entry->key);
    } else {  // missing, which has been told; its source is no second fault
      names.insert(names.end(), asked.spellings.begin(), asked.spellings.end());
    }
  }
  for (const TomlEntry& entry : sources) {
    const std::string key = dotted(kSource) + "." + printable(entry.key);
    if (std::ranges::find(names, entry.key) == names.end()) {
      if (ignore_rest_) continue;
      const std::string_view meant = nearest_spelling(entry.key, names);
      findings_->complain(
          entry.place, key,
          "no such number in this table" +
              (meant.empty() ? std::string() : "; did you mean `" + std::string(meant) + "`?"));
    } else if (!says_something(entry.node)) {
      findings_->complain(entry.node.place, key,
                          "must be a string that says where the number comes from");
    }
  }
  const auto rest = std::ranges::find(sources, kRest, &TomlEntry::key);
  for (const TomlEntry* entry : constants()) {
    auto own = std::ranges::find(sources, entry->key, &TomlEntry::key);
    if (own == sources.end()) own = rest;
    if (own == sources.end() && !findings_->usual_source().empty()) {
      note_source(*entry, findings_->usual_source());
    } else if (own == sources.end()) {
      findings_->complain(source.node.place, dotted(kSource),
                          "says nothing of `" + entry->key + "`; name it or add `rest`");
    } else if (says_something(own->node)) {
      note_source(*entry, std::get<std::string>(own->node.value));
    }
  }
}

}  // namespace sinew
