#include "tools/stream_clip.hpp"

#include <gtest/gtest.h>

#include <map>

#include "tests/player/small_stream.hpp"
#include "tools/byte_split.hpp"

namespace mien::tools {
namespace {

using protocol::TrackKind;
constexpr std::int64_t kGroupFrames = 5;

/// A stored stream of four groups of five frames in memory, of which some messages are spoilt.
class SpoiltStream {
public:
    explicit SpoiltStream(int rungs = 1) {
        static std::map<int, Bytes> made;
        if (!made.contains(rungs)) made[rungs] = [&] {
            const encoder::EncodedStream stream = player::small_stream(true, true, 0.5, rungs);
            Bytes bytes;
            protocol::StreamFileWriter writer([&](ByteView part) { bytes.insert(bytes.end(), part.begin(), part.end()); }, stream.header, stream.blobs);
            for (const protocol::Group& group : stream.groups) writer.add(group);
            writer.finish();
            return bytes;
        }();
        bytes_ = made[rungs];
        whole_ = open();
    }
    StoredStream open() const {
        auto stream = StoredStream::from_bytes(std::make_shared<Bytes>(bytes_));
        EXPECT_TRUE(stream.ok()) << stream.error().message;
        return std::move(*stream);
    }
    /// Another byte in the middle of a group's message.
    void spoil(TrackKind kind, std::uint32_t group, std::size_t rung = 0) {
        const auto& index = whole_->reader().index();
        const std::uint8_t slot = whole_->track(kind)->rungs[rung].slot;
        const auto entry = std::ranges::find_if(index, [&](const auto& e) { return e.slot == slot && e.group == group; });
        ASSERT_NE(entry, index.end());
        bytes_[entry->offset + entry->size / 2] ^= std::byte(0x55);
    }
    void spoil_trailer() { bytes_.back() ^= std::byte(1); }
    void cut_before(TrackKind kind, std::uint32_t group) {
        bytes_.resize(whole_->reader().find(whole_->track(kind)->rungs.front().slot, group)->offset);
    }

private:
    Bytes bytes_;
    std::optional<StoredStream> whole_;
};

double mean(const Image& image) {
    double sum = 0;
    for (const std::uint8_t v : image.pixels) sum += v;
    return sum / double(image.pixels.size());
}

/// More than coding leaves of any vertex, and less than half of what two frames differ by, mm.
constexpr float kCoded = 0.245f;

/// How far the vertices are from those of frame `f` of the clip that was encoded, mm.
float distance(const Clip& got, std::int64_t frame, std::int64_t f) {
    static const Clip truth = player::small_clip(false, false);
    return (got.vertices->frame(frame) - truth.vertices->frame(f)).rowwise().norm().maxCoeff();
}

TEST(DecodeStream, RefusesADamagedGroupUnlessAskedToGoOn) {
    SpoiltStream spoilt;
    spoilt.spoil(TrackKind::motion, 1);
    const auto clip = decode_stream(spoilt.open());
    ASSERT_FALSE(clip.ok());
    EXPECT_EQ(clip.error().code, ErrorCode::damaged);
}

TEST(DecodeStream, AWholeStreamLosesNothing) {
    const auto losses = std::make_shared<Losses>();
    const auto clip = decode_stream(SpoiltStream().open(), {}, Keep::textured, losses);
    ASSERT_TRUE(clip.ok()) << clip.error().message;
    for (std::int64_t f = 0; f < player::kFrames; ++f) {
        EXPECT_LT(distance(*clip, f, f), kCoded);
        EXPECT_NEAR(mean(*clip->texture->read(f)), 40 + 8 * double(f), 3) << f;
    }
    EXPECT_TRUE(losses->empty());
}

/// Which group of the motion is lost, whether the index is lost too, and which frame stands in for the first lost one.
class LostMotion : public testing::TestWithParam<std::tuple<std::uint32_t, bool, std::int64_t>> {};

TEST_P(LostMotion, RepeatsAFrameAndEverythingElseKeepsItsPlace) {
    const auto [group, no_index, stand_in] = GetParam();
    SpoiltStream spoilt;
    spoilt.spoil(TrackKind::motion, group);
    if (no_index) spoilt.spoil_trailer();
    const auto losses = std::make_shared<Losses>();
    const auto clip = decode_stream(spoilt.open(), {}, Keep::textured, losses);
    ASSERT_TRUE(clip.ok()) << clip.error().message;
    ASSERT_EQ(clip->frame_count(), player::kFrames);
    const std::int64_t first = group * kGroupFrames, end = first + kGroupFrames;
    for (std::int64_t f = 0; f < player::kFrames; ++f) {
        EXPECT_LT(distance(*clip, f, f >= first && f < end ? stand_in : f), kCoded) << f;
        EXPECT_NEAR(mean(*clip->texture->read(f)), 40 + 8 * double(f), 3) << f;
    }
    ASSERT_EQ(losses->size(), 1u);
    EXPECT_EQ(losses->front().track, TrackKind::motion);
    EXPECT_EQ(losses->front().first, first);
    EXPECT_EQ(losses->front().end, end);
    EXPECT_NE(describe(losses->front(), spoilt.open().header()).find("frames " + std::to_string(first) + " to " + std::to_string(end - 1)), std::string::npos);
}
INSTANTIATE_TEST_SUITE_P(Groups, LostMotion,
                         testing::Values(std::tuple(0u, false, 5), std::tuple(1u, false, 4), std::tuple(3u, false, 14), std::tuple(0u, true, 5),
                                         std::tuple(2u, true, 9)));

TEST(DecodeStream, WithoutAFinerRungTheMotionIsCoarserAndThatIsSaid) {
    SpoiltStream spoilt(3);
    spoilt.spoil(TrackKind::motion, 1, 1);
    EXPECT_FALSE(decode_stream(spoilt.open()).ok());
    const auto losses = std::make_shared<Losses>();
    const auto clip = decode_stream(spoilt.open(), {}, Keep::textured, losses);
    ASSERT_TRUE(clip.ok()) << clip.error().message;
    const auto whole = decode_stream(SpoiltStream(3).open());
    ASSERT_TRUE(whole.ok());
    for (std::int64_t f = 0; f < player::kFrames; ++f) {
        const bool coarser = f >= 5 && f < 10;
        EXPECT_EQ(clip->vertices->frame(f) == whole->vertices->frame(f), !coarser) << f;
        EXPECT_LT(distance(*clip, f, f), coarser ? 1.2f : kCoded) << f;
    }
    ASSERT_EQ(losses->size(), 1u);
    EXPECT_EQ(losses->front().kind, Loss::Kind::coarser);
    EXPECT_NE(describe(losses->front(), spoilt.open().header()).find("frames 5 to 9 lack a finer rung"), std::string::npos);
}

TEST(DecodeStream, LostPicturesRepeatTheOneBeforeAndTheMotionGoesOn) {
    SpoiltStream spoilt;
    for (const std::uint32_t group : {0u, 2u, 3u}) spoilt.spoil(TrackKind::texture, group);
    const auto losses = std::make_shared<Losses>();
    const auto clip = decode_stream(spoilt.open(), {}, Keep::textured, losses);
    ASSERT_TRUE(clip.ok()) << clip.error().message;
    ASSERT_EQ(clip->frame_count(), player::kFrames);
    ASSERT_EQ(clip->texture->frames(), player::kFrames);
    for (std::int64_t f = 0; f < player::kFrames; ++f) {
        EXPECT_LT(distance(*clip, f, f), kCoded);
        EXPECT_NEAR(mean(*clip->texture->read(f)), 40 + 8 * double(f < 5 ? 5 : f < 10 ? f : 9), 3) << f;
    }
    ASSERT_EQ(losses->size(), 2u);
    EXPECT_EQ(losses->at(0).end, 5);
    EXPECT_EQ(losses->at(1).first, 10);
    EXPECT_EQ(losses->at(1).end, 20) << "two groups in a row are one loss";
}

TEST(DecodeStream, WithoutAnyPictureTheRestIsThereAndTheLossIsNamed) {
    SpoiltStream spoilt;
    for (std::uint32_t group = 0; group < 4; ++group) spoilt.spoil(TrackKind::texture, group);
    const auto losses = std::make_shared<Losses>();
    const auto clip = decode_stream(spoilt.open(), {}, Keep::textured, losses);
    ASSERT_TRUE(clip.ok()) << clip.error().message;
    EXPECT_EQ(clip->frame_count(), player::kFrames);
    EXPECT_FALSE(clip->texture);
    EXPECT_EQ(clip->sound->samples.size(), 96000u);
    ASSERT_EQ(losses->size(), 1u);
    EXPECT_EQ(losses->front().track, TrackKind::texture);
    EXPECT_EQ(losses->front().kind, Loss::Kind::whole);
    EXPECT_NE(describe(losses->front(), spoilt.open().header()).find("the clip has none"), std::string::npos);
    // Nobody who leaves the texture out is told of it.
    losses->clear();
    ASSERT_TRUE(decode_stream(spoilt.open(), {}, Keep::bare, losses).ok());
    EXPECT_TRUE(losses->empty());
}

TEST(StoredStream, ItsAccountCountsDamagedGroups) {
    SpoiltStream spoilt;
    spoilt.spoil(TrackKind::texture, 0);
    spoilt.spoil(TrackKind::texture, 2);
    spoilt.spoil(TrackKind::motion, 1);
    const StoredStream stream = spoilt.open();
    const auto account = stream.reader().account();
    ASSERT_TRUE(account.ok());
    const auto damaged = [&](TrackKind kind) { return account->slots.at(stream.track(kind)->rungs.front().slot).damaged; };
    EXPECT_EQ(damaged(TrackKind::texture), 2u);
    EXPECT_EQ(damaged(TrackKind::motion), 1u);
    EXPECT_EQ(damaged(TrackKind::sound), 0u);
    EXPECT_TRUE(split_bytes(stream).ok());
}

TEST(DecodeStream, LostSoundIsSilentAndTheRestStaysInTime) {
    SpoiltStream spoilt;
    spoilt.spoil(TrackKind::sound, 1);
    const auto losses = std::make_shared<Losses>();
    const auto clip = decode_stream(spoilt.open(), {}, Keep::textured, losses);
    ASSERT_TRUE(clip.ok()) << clip.error().message;
    ASSERT_EQ(clip->sound->samples.size(), 96000u);
    const auto loudest = [&](double from, double to) {
        float most = 0;
        for (auto i = std::size_t(from * 48000); i < std::size_t(to * 48000); ++i) most = std::max(most, std::abs(clip->sound->samples[i]));
        return most;
    };
    EXPECT_GT(loudest(0.1, 0.4), 0.2f);
    EXPECT_EQ(loudest(0.55, 0.95), 0.0f);
    EXPECT_GT(loudest(1.1, 1.9), 0.2f);
    ASSERT_EQ(losses->size(), 1u);
    EXPECT_NEAR(double(losses->front().first) / 48000, 0.5, 0.03);
    EXPECT_NEAR(double(losses->front().end) / 48000, 1.0, 0.03);
}

TEST(DecodeStream, ACutStreamGivesWhatItHoldsAndNothingIsInvented) {
    SpoiltStream spoilt;
    spoilt.cut_before(TrackKind::motion, 2);
    const auto losses = std::make_shared<Losses>();
    const auto clip = decode_stream(spoilt.open(), {}, Keep::textured, losses);
    ASSERT_TRUE(clip.ok()) << clip.error().message;
    EXPECT_EQ(clip->frame_count(), 10);
    EXPECT_EQ(clip->texture->frames(), 10);
    EXPECT_TRUE(losses->empty());
}

TEST(DecodeStream, ATextureThatIsCutBeforeTheMotionTakesNoneOfIt) {
    SpoiltStream spoilt;
    spoilt.cut_before(TrackKind::texture, 3);
    const auto bare = decode_stream(spoilt.open(), {}, Keep::bare, std::make_shared<Losses>());
    ASSERT_TRUE(bare.ok()) << bare.error().message;
    ASSERT_EQ(bare->frame_count(), 20) << "a group's motion lies before its texture";
    const auto losses = std::make_shared<Losses>();
    const auto clip = decode_stream(spoilt.open(), {}, Keep::textured, losses);
    ASSERT_TRUE(clip.ok()) << clip.error().message;
    EXPECT_EQ(clip->frame_count(), 20);
    ASSERT_EQ(clip->texture->frames(), 20);
    EXPECT_EQ(clip->texture->read(19)->pixels, clip->texture->read(14)->pixels);
    EXPECT_NE(clip->texture->read(13)->pixels, clip->texture->read(14)->pixels);
    ASSERT_EQ(losses->size(), 1u);
    EXPECT_EQ(losses->front().kind, Loss::Kind::cut);
    EXPECT_EQ(losses->front().first, 15);
    EXPECT_EQ(losses->front().end, 20);
    const auto strict = decode_stream(spoilt.open());
    ASSERT_TRUE(strict.ok()) << strict.error().message;
    EXPECT_EQ(strict->frame_count(), 20);
    EXPECT_EQ(strict->texture->frames(), 15) << "nothing is made up unless asked for";
}

TEST(DecodeStream, WithoutAnyMotionThereIsNoClip) {
    SpoiltStream spoilt;
    for (std::uint32_t group = 0; group < 4; ++group) spoilt.spoil(TrackKind::motion, group);
    EXPECT_FALSE(decode_stream(spoilt.open(), {}, Keep::textured, std::make_shared<Losses>()).ok());
}

}  // namespace
}  // namespace mien::tools
