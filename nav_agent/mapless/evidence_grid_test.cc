#include "nav_agent/mapless/evidence_grid.h"

#include <vector>

#include "gtest/gtest.h"

namespace treeline::mapless {
namespace {

core::Occupancy AtPoint(const EvidenceGrid& map, geometry::Vec2 point) {
  return map.At(map.CellOf(point));
}

TEST(EvidenceGrid, KnowsWhatBeamsMetAndPassed) {
  EvidenceGrid map;
  EXPECT_EQ(AtPoint(map, {1, 0}), core::Occupancy::kUnknown);
  const std::vector<GridBeam> beams = {{.from = {0, 0}, .to = {2, 0}}};
  map.AddScan(beams);
  EXPECT_EQ(AtPoint(map, {2, 0}), core::Occupancy::kOccupied);
  EXPECT_EQ(AtPoint(map, {1, 0}), core::Occupancy::kFree);
  EXPECT_EQ(AtPoint(map, {2.5, 0}), core::Occupancy::kUnknown);
  EXPECT_EQ(AtPoint(map, {1, 0.5}), core::Occupancy::kUnknown);
}

TEST(EvidenceGrid, ABeamThatPassesDoesNotEraseWhatAnotherOfTheScanMet) {
  EvidenceGrid map;
  // Both go through the cell of (1, 0).
  const std::vector<GridBeam> beams = {{.from = {0, 0}, .to = {2, 0}},
                                       {.from = {0, 0}, .to = {1, 0.001}}};
  for (int scan = 0; scan < 50; ++scan) map.AddScan(beams);
  EXPECT_EQ(AtPoint(map, {1, 0}), core::Occupancy::kOccupied);
}

TEST(EvidenceGrid, WhatHasGoneIsForgottenAfterSomeScans) {
  EvidenceGrid map;
  const std::vector<GridBeam> there = {{.from = {0, 0}, .to = {1, 0}}};
  const std::vector<GridBeam> gone = {{.from = {0, 0}, .to = {3, 0}}};
  for (int scan = 0; scan < 50; ++scan) map.AddScan(there);
  map.AddScan(gone);
  EXPECT_EQ(AtPoint(map, {1, 0}), core::Occupancy::kOccupied);
  for (int scan = 0; scan < kMaxEvidence; ++scan) map.AddScan(gone);
  EXPECT_EQ(AtPoint(map, {1, 0}), core::Occupancy::kFree);
}

TEST(EvidenceGrid, GrowsInAllDirectionsAndKeepsWhatItKnows) {
  EvidenceGrid map;
  map.Mark({0.5, 0.5});
  for (const geometry::Vec2 far :
       {geometry::Vec2{30, 0}, {-30, 0}, {0, 30}, {0, -30}}) {
    const std::vector<GridBeam> beams = {{.from = {0, 0}, .to = far}};
    map.AddScan(beams);
    EXPECT_EQ(AtPoint(map, far), core::Occupancy::kOccupied);
  }
  EXPECT_EQ(AtPoint(map, {0.5, 0.5}), core::Occupancy::kOccupied);
  EXPECT_LE(map.seen_low().x, -30);
  EXPECT_GE(map.seen_high().y, 30);
}

TEST(EvidenceGrid, NotesNothingBeyondItsLargestSize) {
  EvidenceGrid map(0.1, 20);
  const std::vector<GridBeam> beams = {{.from = {0, 0}, .to = {5, 0}},
                                       {.from = {0, 0}, .to = {90, 0}}};
  map.AddScan(beams);
  EXPECT_LE(map.width(), 200);
  EXPECT_EQ(AtPoint(map, {90, 0}), core::Occupancy::kUnknown);
}

TEST(EvidenceGrid, WhatWasMarkedCanTurnOutToBeFree) {
  EvidenceGrid map;
  map.Mark({1, 0});
  const std::vector<GridBeam> beams = {{.from = {0, 0}, .to = {2, 0}}};
  for (int scan = 0; scan < kMaxEvidence; ++scan) map.AddScan(beams);
  EXPECT_EQ(AtPoint(map, {1, 0}), core::Occupancy::kFree);
  map.Clear();
  EXPECT_EQ(AtPoint(map, {2, 0}), core::Occupancy::kUnknown);
}

TEST(EvidenceGrid, PartsReachBeyondIt) {
  EvidenceGrid map(0.1, 20);
  map.Mark({0, 0});
  const core::CellIndex cell = map.CellOf({0, 0});
  const std::vector<uint8_t> part =
      map.ObstaclesIn(cell.x - 1000, cell.y, 1001, 1);
  EXPECT_EQ(part.back(), 1);
  EXPECT_EQ(part.front(), 0);
}

}  // namespace
}  // namespace treeline::mapless
