#include "io/point_faults.hpp"

#include <gtest/gtest.h>

namespace mien::io {
namespace {

TEST(IndexRanges, JoinNeighboursAndAreCutShortOnlyWhenAsked) {
    IndexRanges ranges;
    for (const int i : {3, 4, 4, 5, 7, 9}) ranges.add(i);
    ranges.add(10, 12);
    EXPECT_EQ(ranges.text(), "3-5, 7, 9-12");
    EXPECT_EQ(ranges.text(3), "3-5, 7, 9-12");
    EXPECT_EQ(ranges.text(2), "3-5, 7, ... (8 in all)");
    EXPECT_EQ(ranges.count(), 8);
    IndexRanges one;
    one.add(6);
    EXPECT_EQ(one.subject("frame", "frames"), "frame 6 is");
    EXPECT_EQ(ranges.subject("frame", "frames"), "frames 3-5, 7, 9-12 are");
}

TEST(PointFaults, PointsOfTheSameFramesAreNamedTogether) {
    const std::vector<std::string> names{"A", "B", "C"};
    for (const bool named : {false, true}) {
        PointFaults faults("weight", "weights", named ? &names : nullptr);
        for (const int frame : {1, 2, 4}) faults.add(frame, 0), faults.add(frame, 2);
        faults.add(4, 1);
        EXPECT_EQ(faults.count(), 7);
        EXPECT_EQ(faults.text(), named ? "weights 0 (A), 2 (C) of frames 1-2, 4; weight 1 (B) of frame 4" : "weights 0, 2 of frames 1-2, 4; weight 1 of frame 4");
        EXPECT_EQ(faults.text(1), named ? "weights 0 (A), ... (2 in all) of frames 1-2, ... (3 in all); ..." : "weights 0, ... (2 in all) of frames 1-2, ... (3 in all); ...");
        Findings findings;
        faults.report(findings, Severity::problem, ErrorCode::invalid, "w.csv", "infinite");
        ASSERT_EQ(findings.all().size(), 2u);
        EXPECT_EQ(findings.all()[1].text, named ? "w.csv: weight 1 (B) of frame 4 is infinite" : "w.csv: weight 1 of frame 4 is infinite");
    }
}

}  // namespace
}  // namespace mien::io
