#pragma once

#include <string>
#include <string_view>

#include "sinew/server/web/http_head.h"

/// The heads of answers of the network door, as texts.
namespace sinew::server {

struct WebAnswer {
  int status = 200;
  std::string_view type = {};  ///< of the body; empty where there is none
  std::size_t length = 0;      ///< of the body, also where only the head is sent
  std::string fields = {};     ///< more of them, each with its line end
  bool close = false;          ///< the connection ends behind it
};

/// @param origin  of this server as the client calls it, `http://HOST`; empty where nobody knows
/// @return  with its empty line. Each answer carries the same protection, whatever it is.
std::string answer_head(const WebAnswer& answer, std::string_view origin);

/// A refusal whole, with its sentence as body; the connection ends behind it.
std::string refusal_text(const HttpRefusal& refusal, bool head_only = false);

/// What `/` shows where the program was built without a panel.
std::string_view no_panel_page();

}  // namespace sinew::server
