#include "model/lid.hpp"

#include <gtest/gtest.h>

#include "model/face_model.hpp"

namespace mien::model {
namespace {

/// Four vertices, of which the first two carry a marker each; markers reach vertex 2 by 0.5 and 0.25, vertex 3 by the second alone.
struct Sheet {
    FaceModel face;
    std::vector<Site> sites{Site::at_vertex(0), Site::at_vertex(1)};
    Sheet() {
        face.neutral.positions.resize(4, 3);
        face.neutral.positions << 0, 6, 10, 0, 20, 8, 0, 5, 11, 0, 30, 0;
    }
    Lid lid{Vec3(0, 0, 0), {{0, 0.5f, 1, 1}, {2, 1, 0.8f, 1}, {3, 0, 1, 0}}};
};

TEST(Lid, MarkersOnItShowAShareOfItsWayWhateverTheBase) {
    Sheet blended, shelled;
    BlendBase blend{Points::Zero(2, 3), blended.sites, {0, 1, 2, 4, 5}, {{0, 1}, {1, 1}, {0, 0.5f}, {1, 0.25f}, {1, 1}}};
    ShellBase shell{Points::Zero(2, 3), shelled.sites, Eigen::MatrixXf(4, 2)};
    shell.response << 1, 0, 0, 1, 0.5f, 0.25f, 0, 1;
    blended.face.base = blend;
    shelled.face.base = shell;
    add_lid(blended.face, blended.lid);
    add_lid(shelled.face, shelled.lid);
    const auto& terms = std::get<BlendBase>(blended.face.base).terms;
    const auto& rows = std::get<ShellBase>(shelled.face.base).response;
    // Marker 0 has share 0.5, marker 1 none; vertex 2 shows 0.25 of the way and is to go all of it, by 0.8.
    const float expected[] = {1, 1, 0.5f * (0.2f + 0.8f / 0.25f), 0.25f, 1};
    for (int i = 0; i < 5; ++i) EXPECT_NEAR(terms[std::size_t(i)].weight, expected[i], 1e-6f) << i;
    EXPECT_NEAR(rows(2, 0), expected[2], 1e-6f);
    EXPECT_EQ(rows(2, 1), 0.25f);
    EXPECT_EQ(rows(3, 1), 1) << "a vertex that no marker of the lid is in keeps its parts";
    EXPECT_EQ(blended.face.lids.size(), 1u);
}

TEST(Lid, GoesBackToItsDistanceFromTheEyeballByItsHold) {
    const Sheet sheet;
    Points points = sheet.face.neutral.positions;
    keep_on_eyeball(sheet.lid, sheet.face.neutral.positions, points);
    EXPECT_LT((points - sheet.face.neutral.positions).cwiseAbs().maxCoeff(), 1e-5f) << "at rest";
    points.rowwise() += Eigen::RowVector3f(0, -9, 2);
    const Points moved = points;
    keep_on_eyeball(sheet.lid, sheet.face.neutral.positions, points);
    for (const int v : {0, 2}) {
        EXPECT_NEAR(points.row(v).norm(), sheet.face.neutral.positions.row(v).norm(), 1e-4f);
        EXPECT_NEAR(points.row(v).normalized().dot(moved.row(v).normalized()), 1, 1e-6f) << "towards the centre alone";
    }
    EXPECT_EQ(points.row(1), moved.row(1)) << "no member";
    EXPECT_EQ(points.row(3), moved.row(3)) << "held by nothing";
}

}  // namespace
}  // namespace mien::model
