#include <gtest/gtest.h>

#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <numbers>
#include <random>

#include "decoder/motion_decoder.hpp"
#include "encoder/live_motion.hpp"
#include "encoder/motion_encoder.hpp"
#include "encoder/reference_points.hpp"
#include "memory_in_use.hpp"
#include "motion_clips.hpp"
#include "protocol/stream_file.hpp"
#include "training_takes.hpp"

namespace mien {
namespace {

using encoder::MotionFrame;

constexpr int kRate = 60, kMarkers = 182;   // Hz; as many as Guenter et al. 1998 have

/// 182 markers on half an ellipsoid that four muscles move and a neck turns; one by one they are missed for half a second. Never the same
/// twice: the frequencies have no common multiple.
class EndlessHead {
public:
    EndlessHead() : rest_(kMarkers, 3) {
        std::mt19937 random(2);
        for (Eigen::Index m = 0; m < kMarkers; ++m) {
            const float up = std::acos(1 - 2 * (float(m) + 0.5f) / kMarkers), around = 2.39996f * float(m);
            rest_.row(m) << 70 * std::sin(up) * std::cos(around), 100 * std::cos(up), 80 * std::abs(std::sin(up) * std::sin(around));
        }
        for (Muscle& muscle : muscles_) {
            muscle.moves.setZero(kMarkers, 3);
            const Vec3 centre = rest_.row(Eigen::Index(random() % kMarkers)).transpose();
            const Vec3 direction(float(random() % 100) / 20 - 2.5f, float(random() % 100) / 20 - 2.5f, 2);
            for (Eigen::Index m = kMarkers / 4; m < kMarkers; ++m)
                muscle.moves.row(m) = direction.transpose() * std::exp(-(rest_.row(m).transpose() - centre).squaredNorm() / 1500);
        }
    }

    Points at(std::int64_t f) const {
        const double t = double(f) / kRate;
        Points points = rest_;
        for (std::size_t i = 0; i < muscles_.size(); ++i)
            points += float(std::sin(std::sqrt(double(3 + 2 * i)) * t) * std::sin(0.61 * double(i + 1) * t)) * muscles_[i].moves;
        RigidPose pose;
        pose.rotation = Eigen::AngleAxisf(float(0.2 * std::sin(std::numbers::sqrt2 * t)), Vec3(1, 0.3f, 0).normalized());
        pose.translation = Vec3(float(3 * std::sin(0.7 * t)), 10, float(-4 * std::cos(0.45 * t)));
        apply_pose(pose, points);
        points.row(f / (kRate / 2) % kMarkers).setConstant(std::nanf(""));
        return points;
    }

private:
    struct Muscle {
        Points moves;
    };
    Points rest_;
    std::array<Muscle, 4> muscles_;
};

protocol::StreamHeader header_of(const encoder::LiveMotion& live, std::vector<protocol::StaticBlob>& blobs) {
    const auto add = [&](protocol::BlobKind kind, Bytes bytes) {
        blobs.push_back({sha256(bytes), kind, std::move(bytes)});
        return blobs.back().hash;
    };
    protocol::StreamHeader header;
    header.name = "endless";
    header.frame_rate = {kRate, 1};
    header.group_frames = kRate;
    header.model = add(protocol::BlobKind::manifest, protocol::encode_manifest({"nobody", {}}));
    const Hash basis = add(protocol::BlobKind::motion_basis, live.basis());
    header.tracks.push_back({protocol::TrackKind::motion, "face", {1, kRate}, live.info(), {{.slot = 0, .codec = "motion", .basis = basis}}});
    return header;
}

// Five minutes of stream time; an hour with MIEN_FULL_SIZE=1.
TEST(LongStream, KeepsToTheMemoryOfItsFirstMinute) {
    const EndlessHead head;
    Clip training;
    training.frame_rate = {kRate, 1};
    constexpr std::int64_t kTraining = 120;
    training.markers.emplace(kTraining, kMarkers);
    for (std::int64_t f = 0; f < kTraining; ++f) training.markers->frame(f) = head.at(4 * f);
    encoder::MotionOptions options{.kind = protocol::MotionKind::markers, .preset = encoder::MotionPreset::live, .rms = 0.2, .peak = 10};
    options.reference = encoder::reference_points(training, protocol::MotionKind::markers);
    const auto trained = encoder::encode_motion(training, options);
    ASSERT_TRUE(trained.ok()) << trained.error().message;
    encoder::LiveMotion live(motion_test::take_of(*trained), *options.reference);
    auto decoder = decoder::MotionDecoder::create(live.info(), live.basis());
    ASSERT_TRUE(decoder.ok()) << decoder.error().message;

    std::vector<protocol::StaticBlob> blobs;
    const protocol::StreamHeader header = header_of(live, blobs);
    std::uint64_t written = 0;
    protocol::StreamFileWriter writer([&](ByteView bytes) { written += bytes.size(); }, header, blobs);

    const char* full_size = std::getenv("MIEN_FULL_SIZE");
    const std::int64_t minutes = full_size ? 60 : 5, frames = minutes * 60 * kRate;
    std::int64_t heap = 0, in_memory = 0;
    protocol::Group group;
    for (std::int64_t f = 0; f < frames; ++f) {
        if (f % kRate == 0) {
            live.begin_group();
            decoder->begin_group();
            group = {.slot = 0, .group = std::uint32_t(f / kRate), .first_time = f, .objects = {}};
        }
        const Points points = head.at(f);
        auto object = live.encode({Eigen::Map<const Eigen::VectorXf>(points.data(), points.size()), {}, {}});
        ASSERT_TRUE(object.ok()) << object.error().message;
        const auto motions = decoder->decode(*object, f);
        ASSERT_TRUE(motions.ok()) << motions.error().message;
        ASSERT_EQ(decoder->state_hash(), live.state_hash()) << f;
        group.objects.push_back(std::move(*object));
        if (f % kRate == kRate - 1) writer.add(group);
        if (f == 60 * kRate - 1) heap = motion_test::heap_in_use(), in_memory = motion_test::resident();
    }
    const std::int64_t heap_grown = motion_test::heap_in_use() - heap, resident_grown = motion_test::resident() - in_memory;
    writer.finish();
    const auto figures = live.figures();
    std::printf("%lld minutes, %d components, %.1f kbit/s, %.3f mm RMS: heap %.2f MB after the first minute and %+.3f MB since, "
                "resident %.2f MB and %+.3f MB\n",
                (long long)minutes, int(decoder->basis().size()), 8e-3 * double(written) / double(60 * minutes), figures.rms, double(heap) / 1e6,
                double(heap_grown) / 1e6, double(in_memory) / 1e6, double(resident_grown) / 1e6);
    EXPECT_LT(figures.rms, 0.5);
    EXPECT_GT(heap, 100'000) << "what measures the heap does not";
    EXPECT_GT(in_memory, heap);
    EXPECT_GT(written, std::uint64_t(frames));
    // The file's index grows by an entry a group, and a vector may have room for twice as many.
    EXPECT_LT(heap_grown, 2 * std::int64_t(sizeof(protocol::IndexEntry)) * frames / kRate + 65536);
    if (motion_test::kResidentTells) {
        EXPECT_LT(resident_grown, 4 << 20);
    }
}

}  // namespace
}  // namespace mien
