#include "samples/ict_actor.hpp"

#include <gtest/gtest.h>

#include <set>

#include "io/obj.hpp"
#include "tests/recordings.hpp"

namespace mien::samples {
namespace {

class IctHead : public testing::Test {
protected:
    void SetUp() override {
        folder_ = tests::recordings() / "ict_facekit";
        if (!std::filesystem::exists(folder_ / "generic_neutral_mesh.obj")) GTEST_SKIP() << "skipped: no ICT-FaceKit here";
        if (actor_) return;
        auto made = make_ict_actor(folder_);
        ASSERT_TRUE(made.ok()) << made.error().message;
        actor_ = std::move(*made);
    }
    static Instant with(std::string_view name, float weight) {
        Instant instant;
        instant.weights[std::size_t(arkit_index(name))] = weight;
        return instant;
    }
    std::filesystem::path folder_;
    static inline std::shared_ptr<IctActor> actor_;
};

TEST_F(IctHead, IsTheFilesMeshInMillimetres) {
    const auto file = io::read_obj(folder_ / "generic_neutral_mesh.obj");
    ASSERT_TRUE(file.ok());
    EXPECT_LT((actor_->neutral().positions - 10 * file->positions).cwiseAbs().maxCoeff(), 1e-4f);
    EXPECT_EQ(actor_->deform({}), actor_->neutral().positions);
    for (const Vec2& uv : actor_->neutral().texcoords) ASSERT_TRUE(uv.minCoeff() >= 0 && uv.maxCoeff() <= 1);
    EXPECT_GT(actor_->rigid_vertices().size(), 100u);
}

TEST_F(IctHead, OpensItsJawAsTheFileSays) {
    const auto file = io::read_obj(folder_ / "jawOpen.obj");
    ASSERT_TRUE(file.ok());
    EXPECT_LT((actor_->deform(with("JawOpen", 1)) - 10 * file->positions).cwiseAbs().maxCoeff(), 1e-4f);
}

TEST_F(IctHead, EveryWeightButTheTongueMovesTheSideItNames) {
    for (std::string_view name : kArkitNames) {
        const Points moved = actor_->deform(with(name, 1)) - actor_->neutral().positions;
        if (name == "TongueOut") {
            EXPECT_EQ(moved.cwiseAbs().maxCoeff(), 0);
            continue;
        }
        EXPECT_GT(moved.rowwise().norm().maxCoeff(), 0.5f) << name;
        double left = 0, right = 0;
        for (Eigen::Index v = 0; v < moved.rows(); ++v)
            (actor_->neutral().positions(v, 0) > 0 ? left : right) += moved.row(v).norm();
        const bool moves_aside = name.starts_with("Jaw") || name == "MouthLeft" || name == "MouthRight";
        if (name.ends_with("Left") && !moves_aside) {
            EXPECT_GT(left, 3 * right) << name;
        } else if (name.ends_with("Right") && !moves_aside) {
            EXPECT_GT(right, 3 * left) << name;
        } else if (name == "MouthLeft" || name == "JawLeft") {
            EXPECT_GT(moved.col(0).sum(), 0) << name;
        } else if (name == "BrowInnerUp" || name == "CheekPuff") {
            EXPECT_NEAR(left / right, 1, 0.1) << name;
        }
    }
}

TEST_F(IctHead, GazeTurnsTheEyeballsAboutTheirCentres) {
    Instant instant;
    instant.gaze.yaw[1] = 0.3f;
    const Points moved = actor_->deform(instant);
    const Vec3 centre = actor_->landmarks().eye_centre[1];
    std::set<std::uint32_t> turned;
    for (Eigen::Index v = 0; v < moved.rows(); ++v) {
        if (moved.row(v) == actor_->neutral().positions.row(v)) continue;
        turned.insert(std::uint32_t(v));
        const float before = (actor_->neutral().positions.row(v).transpose() - centre).norm();
        ASSERT_NEAR((moved.row(v).transpose() - centre).norm(), before, 1e-3f);
        ASSERT_LT(before, 20);
    }
    EXPECT_GT(turned.size(), 1500u);
    float pupil_before = 0, pupil_after = 0, front = 0;
    for (std::uint32_t v : turned)
        if (actor_->neutral().positions(v, 2) > front) {
            front = actor_->neutral().positions(v, 2);
            pupil_before = actor_->neutral().positions(v, 0);
            pupil_after = moved(v, 0);
        }
    EXPECT_GT(pupil_after, pupil_before + 3);  // to the actor's left
}

TEST_F(IctHead, BlendshapesAddUpToTheDeformation) {
    Instant instant;
    for (std::size_t i = 0; i < kArkitCount; ++i) instant.weights[i] = float(i % 7) / 10;
    Points sum = actor_->neutral().positions;
    const auto targets = actor_->blendshapes();
    ASSERT_EQ(targets.size(), std::size_t(kArkitCount));
    for (std::size_t i = 0; i < kArkitCount; ++i) sum += instant.weights[i] * targets[i].offsets;
    EXPECT_LT((sum - actor_->deform(instant)).cwiseAbs().maxCoeff(), 1e-3f);
}

TEST_F(IctHead, LandmarksLieWhereFacesHaveThem) {
    const Landmarks& marks = actor_->landmarks();
    EXPECT_NEAR(marks.eye_radius, 14, 2.5);
    EXPECT_NEAR(marks.eye_centre[1].x(), -marks.eye_centre[0].x(), 0.5f);
    EXPECT_GT(marks.glabella.y(), marks.eye_centre[0].y());
    EXPECT_GT(marks.nose_tip.z(), marks.glabella.z() + 10);
    EXPECT_LT(marks.upper_lip_outline.front().x(), -20);
    EXPECT_GT(marks.upper_lip_outline.back().x(), 20);
    const auto middle = [](const Landmarks::Line& line) { return line[line.size() / 2].y(); };
    EXPECT_GT(middle(marks.upper_lip_outline), middle(marks.upper_lip_line) + 4);
    EXPECT_NEAR(middle(marks.upper_lip_line), middle(marks.lower_lip_line), 2);
    EXPECT_GT(middle(marks.lower_lip_line), middle(marks.lower_lip_outline) + 5);
    for (int side : {0, 1}) EXPECT_GT(middle(marks.upper_lid[side]), middle(marks.lower_lid[side]) + 5);
}

TEST_F(IctHead, OtherIdentitiesAreOtherPeople) {
    const auto other = make_ict_actor(folder_, {0.5f, -1.f});
    ASSERT_TRUE(other.ok()) << other.error().message;
    EXPECT_GT(((*other)->neutral().positions - actor_->neutral().positions).rowwise().norm().maxCoeff(), 2);
    EXPECT_EQ(make_ict_actor(folder_, std::vector<float>(200, 0.1f)).error().code, ErrorCode::mismatch);
}

TEST(IctFolder, NamesTheFileThatIsMissing) {
    const auto made = make_ict_actor("no-such-folder");
    ASSERT_FALSE(made.ok());
    EXPECT_EQ(made.error().code, ErrorCode::missing);
    EXPECT_NE(made.error().message.find("generic_neutral_mesh.obj"), std::string::npos);
}

}  // namespace
}  // namespace mien::samples
