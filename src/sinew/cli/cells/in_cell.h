#pragma once

#include <expected>
#include <initializer_list>
#include <string_view>

#include "sinew/cli/cells/cell_verbs.h"
#include "sinew/cli/output/verb.h"

namespace sinew::cli {

/// Of verbs that work alone where no running cell is named.
struct InCell {
  bool named = false;
  CellRequest cell;
};

/// What such a verb was called with.
template <class Request>
struct WithCell : InCell {
  Request request;
};

void add_cell_options(CLI::App& verb, InCell& in);

/// Whether a running cell is meant; takes what the call says besides.
bool on_cell(InCell& in, const ChosenVerb& call);

/// What a running cell does not hear must not seem to be heard.
/// @param heard  names of the options that it does
std::expected<void, Outcome> check_heard(const CLI::App& verb,
                                         std::initializer_list<std::string_view> heard);

}  // namespace sinew::cli
