#include "bench/geometry_codec.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>

#include "bench/geometry_run.hpp"
#include "bench/short_clip.hpp"

namespace mien::bench {
namespace {

using protocol::MotionKind;

// What a uniform grid promises on average holds on a few thousand numbers within some percent.
constexpr double kGridTolerance = 1.05;

TEST(EveryGeometryCodec, MeetsTheErrorThatWasAsked) {
    const Clip clip = sheet_clip();
    const GeometryInput input(clip, MotionKind::vertices);
    for (const auto& codec : geometry_codecs().codecs) {
        ASSERT_EQ(codec->refuses(input), "") << codec->name;
        std::uint64_t coarser = 0;
        for (const double rms : {0.5, 0.1, 0.0001}) {                     // the last one needs more than 16 bits
            if (rms < 0.01 && codec->library == own_library()) continue;  // finer than the model's own grid
            const GeometryRun run = run_geometry(input, *codec, rms);
            ASSERT_EQ(run.row.failed, "") << codec->name << " at " << rms;
            EXPECT_LE(run.row.rms, rms * kGridTolerance) << codec->name;
            EXPECT_LE(run.row.rms, run.row.peak + 1e-12) << codec->name;
            EXPECT_NEAR(run.row.kbps, double(run.row.bytes) * 8 / 1000, 1e-9)
                << "twelve frames at 12 Hz are a second; " << codec->name;
            if (codec->lossless) {
                EXPECT_EQ(run.row.peak, 0);
                EXPECT_EQ(run.row.bytes, std::uint64_t(input.frames * input.numbers() * 4));
                continue;
            }
            EXPECT_LT(run.row.bytes, std::uint64_t(input.frames * input.numbers() * 4)) << codec->name;
            EXPECT_GE(run.row.bytes, coarser) << codec->name;
            coarser = run.row.bytes;
        }
    }
}

TEST(EveryGeometryCodec, DecodesTheSameAgain) {
    const Clip clip = sheet_clip();
    const GeometryInput input(clip, MotionKind::vertices);
    for (const auto& codec : geometry_codecs().codecs) {
        auto stream = codec->encode(input, 0.1);
        ASSERT_TRUE(stream.ok()) << codec->name;
        std::vector<std::vector<float>> first(std::size_t(input.frames), std::vector<float>(std::size_t(input.numbers())));
        ASSERT_TRUE((*stream)->start().ok());
        for (std::int64_t f = 0; f < input.frames; ++f)
            ASSERT_TRUE((*stream)->decode(f, first[std::size_t(f)]).ok()) << codec->name;
        ASSERT_TRUE((*stream)->start().ok());
        std::vector<float> again(std::size_t(input.numbers()));
        for (std::int64_t f = 0; f < input.frames; ++f) {
            ASSERT_TRUE((*stream)->decode(f, again).ok()) << codec->name;
            EXPECT_EQ(again, first[std::size_t(f)]) << codec->name << ", frame " << f;
        }
    }
}

TEST(EveryGeometryCodec, TakesMissingMarkersAndWeightsOrSaysWhyNot) {
    Clip markers = sheet_clip();
    markers.markers.emplace(std::move(*markers.vertices));
    markers.vertices.reset();
    markers.neutral.reset();
    for (std::int64_t f = 3; f < 7; ++f) markers.markers->frame(f).row(11).setConstant(std::numeric_limits<float>::quiet_NaN());
    Clip weights;
    weights.name = "weights";
    weights.weights.emplace(24, 5);
    for (std::size_t i = 0; i < weights.weights->values.size(); ++i)
        weights.weights->values[i] = 0.5f + 0.5f * std::sin(float(i) / 9);
    for (const auto& [clip, kind, rms] :
         {std::tuple{&markers, MotionKind::markers, 0.1}, std::tuple{&weights, MotionKind::weights, 0.005}}) {
        const GeometryInput input(*clip, kind);
        for (const float value : input.held) ASSERT_FALSE(std::isnan(value));
        int taken = 0;
        for (const auto& codec : geometry_codecs().codecs) {
            if (!codec->refuses(input).empty()) continue;
            const GeometryRun run = run_geometry(input, *codec, rms);
            EXPECT_EQ(run.row.failed, "") << codec->name;
            EXPECT_LE(run.row.rms, rms * 1.2) << codec->name;  // 120 weights are too few for an average
            ++taken;
        }
        EXPECT_GE(taken, 6);
    }
}

TEST(Measuring, SeesAKnownError) {
    // Raw floats of one clip against another that is 3, 4 and 0 mm away.
    const Clip clip = sheet_clip();
    Clip moved = clip;
    for (std::int64_t f = 0; f < moved.vertices->frames; ++f) {
        moved.vertices->frame(f).col(0).array() += 3;
        moved.vertices->frame(f).col(1).array() -= 4;
    }
    const GeometryInput truth(clip, MotionKind::vertices), received(moved, MotionKind::vertices);
    for (const auto& codec : geometry_codecs().codecs) {
        if (codec->name != "raw") continue;
        auto stream = codec->encode(received, 0);
        GeometryRow row;
        ASSERT_TRUE(measure(truth, **stream, row).ok());
        EXPECT_NEAR(row.rms, 5, 1e-5);
        EXPECT_NEAR(row.peak, 5, 1e-4);
    }
}

TEST(DracoConnectivity, IsSmallerWhenTheOrderMayChange) {
    const Clip clip = sheet_clip();
    const std::uint64_t sorted = draco_connectivity_bytes(*clip.neutral, false),
                        ordered = draco_connectivity_bytes(*clip.neutral, true);
    if (sorted == 0) GTEST_SKIP() << "skipped: no Draco in this build";
    EXPECT_LT(sorted, ordered);
    EXPECT_LT(ordered, clip.neutral->triangles.size() * 12);
}

}  // namespace
}  // namespace mien::bench
