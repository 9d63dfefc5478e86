#pragma once

#include <cstddef>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "sinew/core/complaint.h"
#include "sinew/core/quantity.h"
#include "sinew/core/vec3.h"

namespace sinew::program {

/// No arm that this is for reaches so far, m.
inline constexpr double kFarAway = 100;

/// A text as a complaint may show it.
std::string in_quotes(std::string_view text);
/// "a b c"
std::string listed(const std::vector<std::string>& names);

struct Word {
  std::string_view text;
  int column = 0;  ///< from 1
};

/// One row of a program as its words, and the complaints of all rows.
class RowReader {
 public:
  static constexpr std::size_t kComplaintMax = 100;

  explicit RowReader(std::string_view file_name) : file_name_(file_name) {}

  /// The next row, without its remark. @param line  outlives the words
  void begin(int number, std::string_view line);
  int line() const { return line_; }
  const std::vector<Word>& words() const { return words_; }

  void complain(const Word& word, std::string message) { complain_in(line_, word, message); }
  void complain_in(int line, const Word& word, std::string message);
  bool full() const { return complaints_.size() >= kComplaintMax; }
  std::vector<Complaint>& complaints() { return complaints_; }

  /// Whether the row has `count` words behind its first one; complains where it has not.
  bool takes_words(std::size_t count, std::string_view example);
  /// A number with its unit; complains at `word` where it is none.
  std::optional<double> quantity(const Word& word, std::string_view text, Measure measure);
  /// "X,Y,Z", each with its unit, m.
  std::optional<Vec3> point(const Word& word, std::string_view text);

 private:
  std::string file_name_;
  int line_ = 0;
  std::vector<Word> words_;
  std::vector<Complaint> complaints_;
};

}  // namespace sinew::program
