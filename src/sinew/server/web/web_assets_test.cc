#include "sinew/server/web/web_assets.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <iostream>

namespace sinew::server {
namespace {

/// The page and all that it may ever fetch, as it goes over the network.
TEST(WebAssets, whole_panel_weighs_less_than_a_megabyte) {
  const std::span<const Asset> assets = web_assets();
  if (assets.empty()) GTEST_SKIP() << "a build without a panel";
  std::size_t bytes = 0;
  for (const Asset& asset : assets) bytes += asset.gzip.size();
  std::cout << "  " << assets.size() << " files, " << bytes << " bytes compressed\n";
  EXPECT_LT(bytes, 1'000'000U);
  EXPECT_EQ(std::ranges::count(assets, "/index.html", &Asset::path), 1);
}

}  // namespace
}  // namespace sinew::server
