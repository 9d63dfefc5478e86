#pragma once

#include <algorithm>
#include <cstdint>
#include <deque>
#include <functional>
#include <ranges>
#include <string>
#include <vector>

#include "sinew/server/json/json_rpc.h"

namespace sinew::server {

/// What happened in the cell, for people: the last kMax events, each with a number.
class EventLog {
 public:
  struct Event {
    std::uint64_t number = 0;
    std::string robot;
    std::string text;  ///< JSON, written once for all that are told
  };

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
    const auto robot = numbered.find("robot");
    const bool named = robot != numbered.end() && robot->is_string();
    events_.push_back({last_, named ? robot->get<std::string>() : "", text_of(numbered)});
    if (events_.size() > kMax) events_.pop_front();
  }
  /// Of the last event; 0 before the first one.
  std::uint64_t last() const { return last_; }
  /// Those behind this number that are still known, oldest first.
  auto after(std::uint64_t number) const {
    return std::ranges::subrange(
        std::ranges::upper_bound(events_, number, std::less{}, &Event::number), events_.end());
  }

 private:
  std::deque<Event> events_;
  std::uint64_t last_ = 0;
};

}  // namespace sinew::server
