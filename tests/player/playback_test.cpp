#include "player/playback.hpp"

#include <gtest/gtest.h>

#include <thread>

#include "small_stream.hpp"

namespace mien::player {
namespace {

/// A playback of the small stream whose time is ours: it goes on only when the decode thread has done what it can.
class PlaybackTest : public testing::Test {
protected:
    void open(bool loop = false) {
        SessionOptions options;
        options.sound = false;
        auto session = open_session(store(small_stream(true, false), folder_), options);
        ASSERT_TRUE(session.ok()) << session.error().message;
        playback_ = std::make_unique<Playback>(std::move(*session), nullptr, loop);
    }
    /// Waits until the decoder cannot get further by itself.
    void settle() {
        const DecodeThread& decode = *playback_->session().decode;
        for (int i = 0; i < 5000 && !decode.ready() && !decode.drained(); ++i)
            std::this_thread::sleep_for(std::chrono::milliseconds(1));
    }
    /// Goes on in steps of a 60 Hz screen; the frames shown.
    std::vector<std::int64_t> play(double seconds) {
        std::vector<std::int64_t> shown;
        for (const double end = now_ + seconds; now_ < end; now_ += 1 / 60.0) {
            settle();
            if (const auto frame = playback_->tick(now_)) shown.push_back(frame->frame);
        }
        return shown;
    }
    static std::vector<std::int64_t> range(std::int64_t first, std::int64_t end) {
        std::vector<std::int64_t> numbers;
        for (; first < end; ++first) numbers.push_back(first);
        return numbers;
    }

    TemporaryFolder folder_;
    std::unique_ptr<Playback> playback_;
    double now_ = 1000;
};

TEST_F(PlaybackTest, ShowsEveryFrameInOrderAndStopsAtTheEnd) {
    open();
    EXPECT_EQ(play(2.5), range(0, kFrames));
    EXPECT_TRUE(playback_->ended());
    EXPECT_EQ(playback_->stalls(), 0u);
}

TEST_F(PlaybackTest, WithoutAnyMotionItIsOverAndNobodyWaits) {
    encoder::EncodedStream stream = small_stream(true, false);
    const std::uint8_t motion = stream.header.tracks.front().rungs.front().slot;
    std::erase_if(stream.groups, [&](const protocol::Group& group) { return group.slot == motion; });
    auto session = open_session(store(stream, folder_), {});
    ASSERT_TRUE(session.ok()) << session.error().message;
    playback_ = std::make_unique<Playback>(std::move(*session), nullptr, false);
    EXPECT_TRUE(play(0.2).empty());
    EXPECT_TRUE(playback_->ended());
    EXPECT_FALSE(playback_->waiting());
    const auto stretches = playback_->session().decode->damage().stretches();
    ASSERT_EQ(stretches.size(), 1u);
    EXPECT_EQ(stretches[0].track, protocol::TrackKind::motion);
    EXPECT_DOUBLE_EQ(stretches[0].end, 2);
}

TEST_F(PlaybackTest, AFrameIsShownWhenItIsDueAndNotBefore) {
    open();
    EXPECT_EQ(play(0.55).back(), 5) << "at 10 frames a second";
}

TEST_F(PlaybackTest, ALateScreenDropsFramesInsteadOfLagging) {
    open();
    play(0.35);
    const DecodeThread& decode = *playback_->session().decode;
    for (int i = 0; i < 5000 && decode.buffered() < 5; ++i) std::this_thread::sleep_for(std::chrono::milliseconds(1));
    now_ += 0.4;   // the window was busy
    const auto frame = playback_->tick(now_);
    ASSERT_TRUE(frame);
    EXPECT_EQ(frame->frame, 7);
    EXPECT_GT(playback_->session().decode->dropped(), 0u);
}

TEST_F(PlaybackTest, APauseHoldsThePictureAndGoesOnFromThere) {
    open();
    const std::int64_t last = play(0.55).back();
    playback_->toggle_pause(now_);
    EXPECT_TRUE(play(3).empty());
    playback_->toggle_pause(now_);
    const auto shown = play(0.3);
    ASSERT_FALSE(shown.empty());
    EXPECT_EQ(shown.front(), last + 1);
}

TEST_F(PlaybackTest, ASeekShowsItsFrameEvenWhenPaused) {
    open();
    play(0.2);
    playback_->toggle_pause(now_);
    playback_->seek(now_, 1.3);
    EXPECT_EQ(play(0.2), range(13, 14));
    playback_->toggle_pause(now_);
    EXPECT_EQ(play(1.5), range(14, kFrames));
}

TEST_F(PlaybackTest, StepsGoByOneFrameBothWays) {
    open();
    play(0.55);
    playback_->step(now_, 1);
    EXPECT_TRUE(playback_->paused());
    EXPECT_EQ(play(0.2), range(6, 7));
    playback_->step(now_, 1);
    EXPECT_EQ(play(0.2), range(7, 8));
    playback_->step(now_, -1);
    EXPECT_EQ(play(0.2), range(6, 7));
    playback_->toggle_pause(now_);
    const auto shown = play(0.3);
    ASSERT_FALSE(shown.empty());
    EXPECT_LE(shown.front(), 7);
}

TEST_F(PlaybackTest, TwiceTheRateTakesHalfTheTime) {
    open();
    playback_->set_rate(now_, 2);
    EXPECT_EQ(play(0.55).back(), 10);
}

TEST_F(PlaybackTest, ALoopStartsAgain) {
    open(true);
    const auto shown = play(2.6);
    EXPECT_EQ(std::count(shown.begin(), shown.end(), 0), 2);
    EXPECT_FALSE(playback_->ended());
}

TEST_F(PlaybackTest, ASeekStormEndsWhereItWasSentLast) {
    open();
    for (int i = 0; i < 40; ++i) {
        playback_->seek(now_, (i * 7 % 20) / 10.0);
        if (i % 3 == 0) playback_->tick(now_);
    }
    playback_->seek(now_, 0.9);
    const auto shown = play(0.3);
    ASSERT_FALSE(shown.empty());
    EXPECT_EQ(shown.front(), 9);
}

TEST(OpenSession, SaysWhatIsWrongWithAFileThatIsNone) {
    const TemporaryFolder folder;
    std::ofstream(folder.path() / "x.mien") << "this is no stream";
    const auto session = open_session((folder.path() / "x.mien").string(), {});
    ASSERT_FALSE(session.ok());
    EXPECT_FALSE(session.error().message.empty());
    EXPECT_FALSE(open_session((folder.path() / "none.mien").string(), {}).ok());
}

}  // namespace
}  // namespace mien::player
