#include "sinew/render/paint.h"

#include <array>

namespace sinew::render {
namespace {

using vision::ColorName;

/// sRGB of things that people call by these names.
constexpr std::array kRed{0xC8202AU, 0xB01820U, 0xD83030U, 0xA01C24U, 0xE8342CU, 0xD8384CU};
constexpr std::array kOrange{0xF07820U, 0xE86818U, 0xFF8C2AU, 0xD87020U, 0xF58A3CU};
constexpr std::array kYellow{0xF0C818U, 0xE8D020U, 0xFFD83AU, 0xD8B818U, 0xF4E060U, 0xE8E050U};
constexpr std::array kGreen{0x2A8A3CU, 0x1C7030U, 0x3FAE4EU, 0x60B840U,
                            0x108060U, 0xA0E098U, 0x184828U, 0x90C840U};
constexpr std::array kBlue{0x1C50A8U, 0x2060C0U, 0x1A3A80U, 0x3080D0U,
                           0x4AA0E0U, 0x1C2460U, 0x2890B8U};
constexpr std::array kPurple{0x602890U, 0x7840A0U, 0x502070U, 0x8858B8U, 0x9878C8U};
constexpr std::array kPink{0xF070A8U, 0xE85898U, 0xF8A0C0U, 0xE04080U, 0xE890B0U};
constexpr std::array kBlack{0x101012U, 0x1C1C20U, 0x262628U, 0x18181CU};
constexpr std::array kWood{0xD8B888U, 0xC8A070U, 0xE0C8A0U, 0xB89060U};
constexpr std::array kPale{0xF0F0ECU, 0xD8D8D8U, 0xA0A0A0U, 0x787878U, 0xE8E4D8U};
constexpr std::array kTables{0xE8E8E4U, 0xD0CEC8U, 0xB0AEA8U, 0x888884U, 0x505052U, 0x242426U,
                             0xC8A880U, 0xA87848U, 0x704828U, 0xE0D0B0U, 0x1C6848U, 0x20704CU,
                             0x284878U, 0x801C20U, 0xD8B030U, 0x305030U, 0x8090A0U, 0xF4F4F4U};
constexpr std::array kSkins{0xE8B898U, 0xD09870U, 0xA86C48U, 0x704428U, 0xF0C8B0U};

int whole(SplitMix64& random, int low, int high) {
  return static_cast<int>(random.uniform(low, high + 1));
}

}  // namespace

std::span<const unsigned> table_swatches() {
  return kTables;
}

std::span<const unsigned> skin_swatches() {
  return kSkins;
}

std::span<const unsigned> swatches_of(ColorName color) {
  const std::array<std::span<const unsigned>, vision::kColorNames> all{
      kRed, kOrange, kYellow, kGreen, kBlue, kPurple, kPink, kBlack, kWood};
  return all[static_cast<std::size_t>(color)];
}

Rgb near_one_of(SplitMix64& random, std::span<const unsigned> swatches) {
  const auto last = static_cast<int>(swatches.size()) - 1;
  const Rgb c = from_srgb(swatches[static_cast<std::size_t>(whole(random, 0, last))]);
  const auto some = [&](float v) { return v * static_cast<float>(random.uniform(0.88, 1.12)); };
  return static_cast<float>(random.uniform(0.75, 1.15)) * Rgb{some(c.r), some(c.g), some(c.b)};
}

Rgb any_color(SplitMix64& random) {
  const std::array<std::span<const unsigned>, 11> all{
      kRed, kOrange, kYellow, kGreen, kBlue, kPink, kPurple, kBlack, kPale, kWood, kTables};
  return near_one_of(random, all[static_cast<std::size_t>(whole(random, 0, 10))]);
}

Material plastic(SplitMix64& random, Rgb color) {
  Material made{color,
                static_cast<float>(random.uniform(0, 0.07)),
                static_cast<float>(random.uniform(0.12, 0.6)),
                {}};
  return made;
}

Material painted_block(SplitMix64& random, std::optional<ColorName> color, BlockStyle style,
                       double edge) {
  Material material = plastic(
      random, near_one_of(random, color ? swatches_of(*color) : std::span<const unsigned>(kPale)));
  if (color == ColorName::kWood) {
    print_on(material, grain(random, 0.35), 0.04);
    return material;
  }
  switch (style) {
    case BlockStyle::kLayers:
      print_on(material, layers(random, random.uniform(0.1, 0.4)), 0.01);
      break;
    case BlockStyle::kGrain:
      print_on(material, grain(random, random.uniform(0.1, 0.4)), 0.04);
      break;
    case BlockStyle::kClouds:
      print_on(material, clouds(random, random.uniform(0.1, 0.35)), 0.05);
      break;
    case BlockStyle::kFramed:
      print_on(material, framed(random.uniform(0.03, 0.08)), edge);
      break;
    case BlockStyle::kScrew:
      print_on(material, screw(random, random.uniform(0.1, 0.35)), edge);
      break;
    case BlockStyle::kPlain:
    default:
      break;
  }
  return material;
}

void print_on(Material& material, PrintPicture picture, double size, bool single) {
  material.print = {std::move(picture), size, size, single};
}

}  // namespace sinew::render
