#pragma once

#include <cstdint>
#include <deque>
#include <vector>

#include "sinew/server/json_rpc.h"

namespace sinew::server {

/// What happened in the cell, for people: the last kMax events, each with a number.
class EventLog {
 public:
  static constexpr std::size_t kMax = 1000;
  /// Numbers that JavaScript can count: more come from a file that was tampered with.
  static constexpr std::uint64_t kNumberMax = std::uint64_t{1} << 52;

  /// Events of an earlier life, oldest first; before the first add(). Their numbers go on.
  void begin(const std::vector<Json>& events) {
    for (const Json& event : events) {
      const auto number = event.find("number");
      const bool goes_on = number != event.end() && number->is_number_unsigned() &&
                           number->get<std::uint64_t>() > last_ &&
                           number->get<std::uint64_t>() < kNumberMax;
      if (goes_on) last_ = number->get<std::uint64_t>() - 1;
      add(event);
    }
  }
  /// @param event  an object; its number is put in front
  void add(Json event) {
    Json numbered{{"number", ++last_}};
    numbered.update(event);
    numbered["number"] = last_;
    events_.push_back(std::move(numbered));
    if (events_.size() > kMax) events_.pop_front();
  }
  /// Of the last event; 0 before the first one.
  std::uint64_t last() const { return last_; }
  /// Those behind this number that are still known, oldest first.
  Json after(std::uint64_t number) const {
    Json list = Json::array();
    for (const Json& event : events_) {
      if (event["number"].get<std::uint64_t>() > number) list.push_back(event);
    }
    return list;
  }

 private:
  std::deque<Json> events_;
  std::uint64_t last_ = 0;
};

}  // namespace sinew::server
