#include <gtest/gtest.h>
#include <sys/resource.h>

#include <cmath>
#include <random>

#include "coding/vector_coder.hpp"
#include "decoder/motion_decoder.hpp"
#include "encoder/motion_encoder.hpp"
#include "motion_clips.hpp"
#include "object_walk.hpp"

/// What a decoder does with bytes that nobody honest wrote is bounded by their number: counted in decisions, which are the same on every
/// machine.
namespace mien {
namespace {

using coding::MotionBasis;
using coding::MotionScheme;
using coding::MotionShape;

constexpr std::uint64_t kMostPerNumber = 2 + coding::Binarisation::kMaxClass + 1 + coding::Binarisation::kMaxClass;

/// A range decoder that counts, and holds models to the chances that most_decisions() relies on.
class CountingDecoder {
public:
    static constexpr bool kDecodes = true;
    explicit CountingDecoder(ByteView bytes) : decoder_(bytes) {}
    void code(int& bit, coding::Probability set) {
        ++decisions_;
        least_chance_ = std::min({least_chance_, set, 65536 - set});
        decoder_.code(bit, set);
    }
    void enter(bool) {}
    void fail() { decoder_.fail(); }
    bool failed() const { return decoder_.failed(); }
    bool complete() const { return decoder_.complete(); }
    std::uint64_t decisions() const { return decisions_; }
    coding::Probability least_chance() const { return least_chance_; }

private:
    coding::RangeDecoder decoder_;
    std::uint64_t decisions_ = 0;
    coding::Probability least_chance_ = coding::kHalf;
};

Bytes noise(std::mt19937& random, std::size_t size) {
    Bytes bytes(size);
    for (std::byte& b : bytes) b = std::byte(random());
    return bytes;
}

/// One of many ways to spoil bytes: bits turned, a cut, a run of one value, noise, or something else altogether.
Bytes spoilt(Bytes bytes, std::mt19937& random) {
    switch (random() % 5) {
        case 0:
            for (int i = 0; i < 3 && !bytes.empty(); ++i) bytes[random() % bytes.size()] ^= std::byte(1 << random() % 8);
            return bytes;
        case 1: bytes.resize(bytes.empty() ? 0 : random() % bytes.size()); return bytes;
        case 2: {
            const std::byte value = random() % 2 ? std::byte(0) : std::byte(0xff);
            for (std::size_t i = bytes.empty() ? 0 : random() % bytes.size(); i < bytes.size(); ++i) bytes[i] = value;
            return bytes;
        }
        case 3: {
            const Bytes more = noise(random, 1 + random() % 20);
            bytes.insert(bytes.begin() + std::ptrdiff_t(random() % (bytes.size() + 1)), more.begin(), more.end());
            return bytes;
        }
        default: return noise(random, random() % 60);
    }
}

constexpr MotionShape kShape{.points = 40, .pose = true, .presence = true};

/// A basis whose models are as sure of themselves as one can be told to be.
MotionBasis sure_basis(MotionScheme scheme, std::mt19937& random) {
    MotionBasis basis;
    basis.scheme = scheme;
    basis.mean.assign(kShape.dimension(), 0);
    basis.components.assign(8, std::vector<std::int32_t>(kShape.dimension(), 0));
    basis.block = std::uint8_t(1 + random() % 128);
    basis.corrected = {0, 7, 39};
    if (scheme == MotionScheme::causal)
        for (int c = 0; c < basis.channels(kShape); ++c) basis.predictors.push_back({std::int16_t(random() % 600), -60, 10});
    if (scheme == MotionScheme::guenter98) {
        basis.static_codes.resize(std::size_t(basis.channels(kShape)) + 9);
        for (auto& row : basis.static_codes)
            for (std::int8_t& level : row) level = std::int8_t(random() % 2 ? -32 : 31);
        return basis;
    }
    const coding::MotionChannels layout(kShape, basis);
    basis.start.confidence = 255;
    const int kind = int(random() % 3);
    for (std::uint32_t at = 0; kind < 2 && at < layout.model_entries(); ++at)
        basis.start.chances.push_back({at, std::int8_t(random() % 4 ? -30 : 30)});
    if (kind == 1) basis.start.weights.assign(layout.model_weights(), 127);
    return basis;
}

TEST(HostileMotion, ObjectsTakeNoMoreDecisionsThanTheirBytesHoldOrTheirFramesAnnounce) {
    std::mt19937 random(17);
    // Between two looks at whether bytes are left: a frame's presence, a block's numbers, a corrected point.
    const std::uint64_t unseen = kShape.points + 1 + 128 * kMostPerNumber + 3 * kMostPerNumber + 1;
    std::uint64_t most = 0;
    coding::Probability least_chance = coding::kHalf;
    for (int round = 0; round < 300; ++round) {
        const MotionBasis basis = sure_basis(MotionScheme(1 + round % 3), random);
        motion_test::ObjectWalk walk(basis, kShape);
        Bytes bytes(random() % 40, round % 4 ? std::byte(random()) : std::byte(0));
        for (int object = 0; object < 3; ++object) {
            bytes = spoilt(std::move(bytes), random);
            // So many frames that a walk which does not notice the end of few bytes goes far beyond them.
            const std::uint32_t frames = 1 + random() % (object == 2 ? 1 << 17 : 100);
            CountingDecoder coder(bytes);
            walk.decode(coder, frames);
            EXPECT_LE(coder.decisions(), coding::most_decisions(bytes.size()) + unseen) << round;
            const std::uint64_t announced = frames * (1 + kShape.points + std::uint64_t(basis.channels(kShape)) * (kMostPerNumber + 2) +
                                                      1 + basis.corrected.size() * (1 + 3 * kMostPerNumber));
            EXPECT_LE(coder.decisions(), announced) << round;
            least_chance = std::min(least_chance, coder.least_chance());
            most = std::max(most, coder.decisions());
            if (!coder.complete()) walk.begin_group();
        }
    }
    EXPECT_EQ(least_chance, coding::kLeastChance) << "what most_decisions() relies on, and no less";
    EXPECT_GT(most, 10000u) << "none of these objects came near to being long";
}

TEST(HostileMotion, VectorsOfABasisTakeNoMoreDecisionsThanTheirBytesHold) {
    std::mt19937 random(19);
    const MotionShape shape{.points = 60000};   // a vector alone is more decisions than a few bytes hold
    const coding::PointOrder order = coding::plain_order(shape.points);
    const std::uint64_t unseen = 256 * 3 * kMostPerNumber;   // the walk looks every 256 points
    for (int round = 0; round < 60; ++round) {
        const Bytes bytes = round % 3 ? spoilt(noise(random, 200), random) : Bytes(random() % 3, std::byte(0xff * (round % 2)));
        CountingDecoder coder(bytes);
        coding::VectorCoder vectors(shape, order, MotionBasis::kEvenSteps);
        std::vector<std::int32_t> walk(shape.dimension(), 0);
        for (std::uint32_t j = 0; j < MotionBasis::kMaxComponents && !coder.failed(); ++j)
            vectors.code(coder, walk, [](const auto&, const auto&, auto&) { return 0; });
        EXPECT_TRUE(coder.failed());
        EXPECT_LE(coder.decisions(), coding::most_decisions(bytes.size()) + unseen);
        EXPECT_GE(coder.least_chance(), coding::kLeastChance);
    }
}

TEST(HostileMotion, SpoiltBasesAndObjectsHoldNoMoreThanTheirBytes) {
    std::mt19937 random(23);
    const Clip clip = motion_test::marker_clip(20, 4, true, 0.05);
    int taken = 0, refused = 0, decoded = 0;
    for (const auto preset : {encoder::MotionPreset::file, encoder::MotionPreset::live, encoder::MotionPreset::guenter98}) {
        const auto motion = encoder::encode_motion(clip, {.kind = protocol::MotionKind::markers, .preset = preset, .rms = 0.3, .group_frames = 10});
        ASSERT_TRUE(motion.ok()) << motion.error().message;
        const protocol::Object& object = motion->groups.front().objects.front();
        for (int round = 0; round < 200; ++round) {
            // Half of the damage goes to the head, whose fields steer the rest.
            Bytes basis = motion->basis;
            if (round % 2) basis[random() % std::min<std::size_t>(basis.size(), 60)] ^= std::byte(1 << random() % 8);
            else basis = spoilt(std::move(basis), random);
            auto decoder = decoder::MotionDecoder::create(motion->info, basis);
            if (!decoder.ok()) {
                ++refused;
                continue;
            }
            ++taken;
            const std::uint64_t numbers = std::uint64_t(decoder->basis().size() + 1) * std::uint64_t(decoder->basis().dimension());
            EXPECT_LE(numbers, coding::most_decisions(basis.size()));
            for (int other = 0; other < 4; ++other) {
                decoder->begin_group();
                const std::uint32_t frames = other % 2 ? object.frames : std::uint32_t(1 + random() % 5000);
                const protocol::Object bad{.frames = frames, .bytes = spoilt(object.bytes, random)};
                const auto motions = decoder->decode(bad, 0);
                if (!motions.ok()) continue;
                ++decoded;
                for (const model::Motion& m : *motions) EXPECT_TRUE(m.coefficients.allFinite());
                EXPECT_LE(motions->size() * std::size_t(decoder->basis().size()), coding::most_decisions(bad.bytes.size()));
            }
        }
    }
    EXPECT_GT(taken, 20);
    EXPECT_GT(refused, 20);
    EXPECT_GT(decoded, 20);
}

long peak_memory_kb() {
    rusage usage{};
    getrusage(RUSAGE_SELF, &usage);
    return usage.ru_maxrss;
}

TEST(HostileMotion, AShortObjectOfManyFramesIsRefusedBeforeRoomIsMadeForThem) {
    std::mt19937 random(29);
    MotionBasis basis = sure_basis(MotionScheme::transform, random);
    basis.start = {};
    basis.corrected.clear();
    constexpr MotionShape shape{.points = 40};
    const protocol::MotionInfo info{.kind = protocol::MotionKind::markers, .count = 40};
    auto decoder = decoder::MotionDecoder::create(info, write_motion_basis(basis, shape, coding::plain_order(40)).bytes);
    ASSERT_TRUE(decoder.ok()) << decoder.error().message;
    const long before = peak_memory_kb();
    for (std::size_t size = 0; size < 10; ++size) {
        decoder->begin_group();
        const auto motions = decoder->decode({.frames = coding::MotionFrames::kMaxFrames, .bytes = noise(random, size)}, 0);
        ASSERT_FALSE(motions.ok());
        EXPECT_EQ(motions.error().code, ErrorCode::limit_exceeded);
    }
    EXPECT_LT(peak_memory_kb() - before, 50000) << "kB; 8 channels of 2^20 frames are 100 MB";

    // A head at rest is as short as an object can be, and is taken.
    constexpr std::uint32_t kFrames = 100000;
    coding::MotionFrames frames(basis, shape);
    coding::RangeEncoder coder;
    frames.begin_object(kFrames);
    for (int c = 0, split = 0; c < 8; ++c)
        frames.code_channel(coder, c, kFrames, split, [](const auto&) {}, [](int, const auto&, auto&) { return 0; });
    const protocol::Object rest{.frames = kFrames, .bytes = coder.finish()};
    EXPECT_LT(rest.bytes.size(), 200u);
    decoder->begin_group();
    const auto motions = decoder->decode(rest, 0);
    ASSERT_TRUE(motions.ok()) << motions.error().message;
    EXPECT_EQ(motions->size(), kFrames);
}

}  // namespace
}  // namespace mien
