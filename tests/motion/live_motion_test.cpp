#include "encoder/live_motion.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <map>

#include "coding/motion_values.hpp"
#include "core/parallel.hpp"
#include "decoder/motion_decoder.hpp"
#include "encoder/motion_encoder.hpp"
#include "encoder/motion_groups.hpp"
#include "encoder/reference_points.hpp"
#include "motion_clips.hpp"
#include "training_takes.hpp"

/// Motion coded with a basis that was made of other frames.
namespace mien {
namespace {

using encoder::EncodedMotion;
using encoder::LiveMotion;
using encoder::MotionFrame;
using encoder::MotionOptions;
using encoder::MotionPreset;
using encoder::TrainingTake;
using protocol::MotionKind;

constexpr std::int64_t kTraining = 150, kOthers = 60;

/// One performance, cut into what is trained on and what is not.
Clip part(const Clip& whole, std::int64_t first, std::int64_t frames) {
    Clip clip;
    clip.frame_rate = whole.frame_rate;
    clip.markers.emplace(frames, whole.markers->points);
    for (std::int64_t f = 0; f < frames; ++f) clip.markers->frame(f) = whole.markers->frame(first + f);
    return clip;
}

struct Takes {
    Clip others;
    Points reference;
    TrainingTake take;
    Bytes basis;
};

/// Encoding is the long part, so each kind is encoded once.
const Takes& trained(bool nods, MotionPreset preset) {
    static std::map<std::pair<bool, MotionPreset>, Takes> all;
    const auto found = all.find({nods, preset});
    if (found != all.end()) return found->second;
    Takes& takes = all[{nods, preset}];
    const Clip whole = motion_test::marker_clip(kTraining + kOthers, 5, nods, 0);
    const Clip training = part(whole, 0, kTraining);
    takes.reference = encoder::reference_points(training, MotionKind::markers);
    takes.others = part(whole, kTraining, kOthers);
    MotionOptions options;
    options.kind = MotionKind::markers;
    options.preset = preset;
    options.rms = 0.06;
    options.reference = takes.reference;
    const auto encoded = encoder::encode_motion(training, options);
    EXPECT_TRUE(encoded.ok()) << encoded.error().message;
    takes.take = motion_test::take_of(*encoded);
    takes.basis = encoded->basis;
    return takes;
}

Takes make_takes(bool nods, double missing, MotionPreset preset = MotionPreset::live) {
    Takes takes = trained(nods, preset);
    std::mt19937 random(3);
    for (std::int64_t f = 0; f < kOthers; ++f)
        for (Eigen::Index p = 0; p < takes.others.markers->points; ++p)
            if (double(random()) / 4294967296.0 < missing) takes.others.markers->frame(f).row(p).setConstant(std::nanf(""));
    return takes;
}

MotionFrame frame_of(const Clip& clip, std::int64_t f) {
    return {Eigen::Map<const Eigen::VectorXf>(clip.markers->frame(f).data(), 3 * clip.markers->points), {}, {}};
}

/// RMS of a decode from the truth, mm, over present markers.
double error_of(const Clip& clip, const Points& reference, const std::vector<model::Motion>& motions, const model::LinearMotion& basis) {
    double sum = 0, count = 0;
    for (const model::Motion& motion : motions) {
        const Eigen::VectorXf offsets = basis.mean + basis.components * motion.coefficients;
        Points points = reference + Eigen::Map<const Points>(offsets.data(), reference.rows(), 3);
        apply_pose(motion.pose, points);
        const auto truth = clip.markers->frame(motion.frame);
        for (Eigen::Index p = 0; p < points.rows(); ++p) {
            EXPECT_EQ(motion.presence.empty() ? 1 : motion.presence[std::size_t(p)], !std::isnan(truth(p, 0)));
            if (std::isnan(truth(p, 0))) continue;
            sum += double((points.row(p) - truth.row(p)).squaredNorm());
            ++count;
        }
    }
    return std::sqrt(sum / count);
}

TEST(LiveMotion, DecodesToWhatTheEncoderHasFrameByFrame) {
    const Takes takes = make_takes(true, 0.1);
    LiveMotion live(takes.take, takes.reference);
    auto decoder = decoder::MotionDecoder::create(live.info(), live.basis());
    ASSERT_TRUE(decoder.ok()) << decoder.error().message;
    std::vector<model::Motion> all;
    for (std::int64_t f = 0; f < kOthers; ++f) {
        if (f % 25 == 0) live.begin_group(), decoder->begin_group();
        const auto object = live.encode(frame_of(takes.others, f));
        ASSERT_TRUE(object.ok()) << object.error().message;
        const auto motions = decoder->decode(*object, f);
        ASSERT_TRUE(motions.ok()) << motions.error().message;
        EXPECT_EQ(decoder->state_hash(), live.state_hash()) << f;
        const Eigen::VectorXf& w = motions->front().coefficients;
        for (Eigen::Index c = 0; c < w.size(); ++c) EXPECT_EQ(std::int64_t(w[c]), live.samples()[std::size_t(6 + c)]) << f;
        all.push_back(motions->front());
    }
    const auto figures = live.figures();
    EXPECT_EQ(figures.frames, kOthers);
    EXPECT_NEAR(error_of(takes.others, takes.reference, all, decoder->basis()), figures.rms, 1e-4);
    EXPECT_LT(figures.rms, 0.12) << "the take's own error is 0.06 mm";
}

TEST(LiveMotion, TakesTheTrainingTakesBasisByteForByte) {
    const Takes takes = make_takes(true, 0);
    EXPECT_EQ(LiveMotion(takes.take, takes.reference).basis(), takes.basis) << "so a viewer who has it need not fetch it again";
}

TEST(LiveMotion, MakesTheBitsOfThePresetLive) {
    // The same numbers through code_groups(), which the preset live uses, with what LiveMotion aims at.
    const Takes takes = make_takes(false, 0);
    ASSERT_FALSE(takes.take.info.has_pose);
    LiveMotion live(takes.take, takes.reference);
    const coding::MotionBasis basis = encoder::basis_for(takes.take, coding::MotionScheme::causal);
    encoder::FrameProjector projector(takes.take, basis, takes.reference);
    Eigen::MatrixXd targets(Eigen::Index(basis.size()), kOthers);
    std::vector<protocol::Object> objects;
    for (std::int64_t f = 0; f < kOthers; ++f) {
        if (f % 20 == 0) live.begin_group();
        objects.push_back(*live.encode(frame_of(takes.others, f)));
        targets.col(f) = projector.coefficients(frame_of(takes.others, f), {});
    }
    coding::MotionShape shape = takes.take.shape();
    shape.presence = true;
    const encoder::GroupPlan plan{.frames = kOthers, .group_frames = 20};
    const std::vector<std::uint8_t> presence(std::size_t(kOthers) * shape.points, 1);
    const encoder::CodedGroups coded = encoder::code_groups(basis, shape, plan, targets, presence, {.whole_bytes = true});
    for (std::int64_t f = 0; f < kOthers; ++f)
        EXPECT_EQ(coded.groups[std::size_t(f / 20)].objects[std::size_t(f % 20)].bytes, objects[std::size_t(f)].bytes) << f;
}

TEST(LiveMotion, ABasisOfThePresetFileServesToo) {
    const Takes takes = make_takes(true, 0, MotionPreset::file);
    LiveMotion live(takes.take, takes.reference);
    auto decoder = decoder::MotionDecoder::create(live.info(), live.basis());
    ASSERT_TRUE(decoder.ok()) << decoder.error().message;
    decoder->begin_group();
    for (std::int64_t f = 0; f < 20; ++f) {
        ASSERT_TRUE(decoder->decode(*live.encode(frame_of(takes.others, f)), f).ok());
        EXPECT_EQ(decoder->state_hash(), live.state_hash());
    }
    EXPECT_LT(live.figures().rms, 0.12);
}

TEST(LiveMotion, IsTheSameForAnyThreadCount) {
    // A take of the preset file: predictors and starting chances are learnt when LiveMotion is made.
    const Takes takes = make_takes(true, 0.05, MotionPreset::file);
    Bytes one;
    for (const int threads : {1, 2, 7}) {
        set_thread_count(threads);
        LiveMotion live(takes.take, takes.reference);
        Bytes all = live.basis();
        for (std::int64_t f = 0; f < 20; ++f) {
            if (f % 8 == 0) live.begin_group();
            const auto object = live.encode(frame_of(takes.others, f));
            EXPECT_TRUE(object.ok());
            all.insert(all.end(), object->bytes.begin(), object->bytes.end());
        }
        if (threads == 1) one = all;
        EXPECT_EQ(all, one) << threads << " threads";
    }
    set_thread_count(0);
}

TEST(LiveMotion, MissingMarkersAreHeldByTheOthers) {
    const Takes takes = make_takes(true, 0);
    LiveMotion live(takes.take, takes.reference);
    // All markers once, then a third of them is gone: what they do is still known from the others.
    ASSERT_TRUE(live.encode(frame_of(takes.others, 0)).ok());
    MotionFrame gap = frame_of(takes.others, 1);
    for (Eigen::Index p = 10; p < 20; ++p) gap.values.segment<3>(3 * p).setConstant(std::nanf(""));
    ASSERT_TRUE(live.encode(gap).ok());
    const coding::MotionBasis basis = encoder::basis_for(takes.take, coding::MotionScheme::causal);
    const encoder::FrameProjector projector(takes.take, basis, takes.reference);
    Eigen::VectorXd decoded(Eigen::Index(live.samples().size()));
    for (Eigen::Index c = 0; c < decoded.size(); ++c) decoded[c] = double(live.samples()[std::size_t(c)]) / 16;
    const auto errors = projector.errors(frame_of(takes.others, 1), decoded);   // of all markers, the missing ones too
    EXPECT_EQ(errors.points, 30);
    EXPECT_LT(std::sqrt(errors.squared / 30), 0.5);
}

TEST(LiveMotion, ATakeOfAHeadAtRestServesForOneThatMoves) {
    Takes takes = make_takes(false, 0);
    ASSERT_FALSE(takes.take.info.has_pose);
    const auto poses = motion_test::nodding(kOthers);
    for (std::int64_t f = 0; f < kOthers; ++f) apply_pose(poses[std::size_t(f)], takes.others.markers->frame(f));
    encoder::add_pose(takes.take, takes.reference);
    LiveMotion live(takes.take, takes.reference);
    auto decoder = decoder::MotionDecoder::create(live.info(), live.basis());
    ASSERT_TRUE(decoder.ok()) << decoder.error().message;
    std::vector<model::Motion> motions;
    decoder->begin_group();
    for (std::int64_t f = 0; f < kOthers; ++f) motions.push_back(decoder->decode(*live.encode(frame_of(takes.others, f)), f)->front());
    EXPECT_LT(error_of(takes.others, takes.reference, motions, decoder->basis()), 0.12);
}

TEST(LiveMotion, AFrameThatMakesNoSenseIsRefusedAndLeavesTheStreamAsItWas) {
    const Takes takes = make_takes(true, 0);
    LiveMotion live(takes.take, takes.reference), other(takes.take, takes.reference);
    MotionFrame bad = frame_of(takes.others, 0);
    bad.values.conservativeResize(bad.values.size() - 3);
    EXPECT_EQ(live.encode(bad).error().code, ErrorCode::mismatch);
    for (const float wrong : {std::numeric_limits<float>::infinity(), 1e9f, std::nanf("")}) {
        bad = frame_of(takes.others, 0);
        bad.values[4] = wrong;
        EXPECT_EQ(live.encode(bad).error().code, ErrorCode::invalid) << wrong;
    }
    bad = frame_of(takes.others, 0);
    bad.values *= 500;   // positions, but none of this head's
    (void)live.encode(bad);
    for (std::int64_t f = 0; f < 5; ++f) {
        const auto good = live.encode(frame_of(takes.others, f));
        ASSERT_TRUE(good.ok()) << good.error().message;
    }
    EXPECT_LT(live.figures().rms, 1e6);
}

TEST(TrainedMotion, MeetsTheAskedErrorOnFramesItWasNotTrainedOn) {
    const Takes takes = make_takes(true, 0.05);
    for (const MotionPreset preset : {MotionPreset::file, MotionPreset::live}) {
        MotionOptions options;
        options.kind = MotionKind::markers;
        options.preset = preset;
        options.rms = 0.15;
        options.reference = takes.reference;
        options.training = &takes.take;
        const auto encoded = encoder::encode_motion(takes.others, options);
        ASSERT_TRUE(encoded.ok()) << encoded.error().message;
        auto decoder = decoder::MotionDecoder::create(encoded->info, encoded->basis);
        ASSERT_TRUE(decoder.ok());
        std::vector<model::Motion> motions;
        for (const auto& group : encoded->groups) {
            decoder->begin_group();
            std::int64_t frame = group.first_time;
            for (const auto& object : group.objects) {
                const auto decoded = decoder->decode(object, frame);
                ASSERT_TRUE(decoded.ok());
                motions.insert(motions.end(), decoded->begin(), decoded->end());
                frame += object.frames;
            }
        }
        const double error = error_of(takes.others, takes.reference, motions, decoder->basis());
        EXPECT_LE(error, 0.15 + 1e-4);
        EXPECT_GT(error, 0.12) << "coarser would have done";
        EXPECT_NEAR(error, encoded->rms, 1e-4);
    }
}

TEST(TrainedMotion, SaysWhatTheBasisLeavesWhenTheErrorCannotBeMet) {
    Takes takes = make_takes(true, 0);
    MotionOptions options;
    options.kind = MotionKind::markers;
    options.rms = 0.1;
    options.reference = takes.reference;
    options.training = &takes.take;
    for (std::int64_t f = 0; f < kOthers; ++f) takes.others.markers->frame(f)(29, 2) += 8 * std::sin(0.9f * float(f));   // no such motion was trained on
    const auto refused = encoder::encode_motion(takes.others, options);
    ASSERT_FALSE(refused.ok());
    EXPECT_NE(refused.error().message.find("the training take's basis leaves"), std::string::npos) << refused.error().message;
    options.rms.reset();
    options.kbps = 4;
    EXPECT_EQ(encoder::encode_motion(takes.others, options).error().code, ErrorCode::invalid);
}

}  // namespace
}  // namespace mien
