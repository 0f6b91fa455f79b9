#include "simulation/worlds/furniture.h"

#include <cstddef>

namespace treeline::worlds {
namespace {

// A piece's name and who makes it.
template <typename Maker, typename... Width>
struct Piece {
  absl::string_view name;
  void (Maker::*make)(const Placement&, Width...);
};

// Makes the one of this name, if it is among them.
template <typename Maker, typename... Width, size_t kCount>
bool MakeNamed(const Piece<Maker, Width...> (&pieces)[kCount],
               absl::string_view name, Maker& maker, const Placement& at,
               Width... width_m) {
  for (const auto& piece : pieces) {
    if (piece.name != name) continue;
    (maker.*piece.make)(at, width_m...);
    return true;
  }
  return false;
}

constexpr Piece<HomeFurniture> kHome[] = {
    {"desk", &HomeFurniture::Desk},
    {"wardrobe", &HomeFurniture::Wardrobe},
    {"sofa", &HomeFurniture::Sofa},
    {"chair", &HomeFurniture::Chair},
    {"coffee_table", &HomeFurniture::CoffeeTable},
};
constexpr Piece<SmallFurnishings> kSmall[] = {
    {"floor_lamp", &SmallFurnishings::FloorLamp},
    {"boxes", &SmallFurnishings::BoxStack},
};
constexpr Piece<PublicFurniture> kPublic[] = {
    {"cafe_table", &PublicFurniture::CafeTable},
    {"stool", &PublicFurniture::Stool},
    {"machine", &PublicFurniture::Machine},
    {"office_chair", &PublicFurniture::OfficeChair},
    {"bin", &PublicFurniture::Bin},
};
constexpr Piece<HomeFurniture, float> kHomeWide[] = {
    {"bookcase", &HomeFurniture::Bookcase},
    {"sideboard", &HomeFurniture::Sideboard},
};
constexpr Piece<PublicFurniture, float> kPublicWide[] = {
    {"table", &PublicFurniture::Table}, {"counter", &PublicFurniture::Counter},
    {"bench", &PublicFurniture::Bench}, {"rack", &PublicFurniture::Rack},
    {"crate", &PublicFurniture::Crate}, {"rug", &PublicFurniture::Rug},
};

}  // namespace

bool FurnitureMaker::ByName(absl::string_view name, const Placement& at,
                            float width_m) {
  if (MakeNamed(kHome, name, home_, at) ||
      MakeNamed(kSmall, name, things_, at) ||
      MakeNamed(kPublic, name, public_, at) ||
      MakeNamed(kHomeWide, name, home_, at, width_m) ||
      MakeNamed(kPublicWide, name, public_, at, width_m)) {
    return true;
  }
  if (name != "plant") return false;
  things_.Plant(at, Uniform(0.7f, 1.3f));
  return true;
}

}  // namespace treeline::worlds
