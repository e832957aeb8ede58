#include <gtest/gtest.h>

#include <cmath>
#include <mutex>
#include <thread>

#include "net/publisher.hpp"
#include "net/server.hpp"
#include "player/live_clock.hpp"
#include "player/playback.hpp"
#include "small_stream.hpp"

namespace mien::player {
namespace {

using namespace std::chrono_literals;

TEST(LiveClock, WithoutADelayEveryFrameIsDueWhenItComes) {
    LiveClock clock(60, 0);
    EXPECT_EQ(clock.due(1000), -1);
    for (std::int64_t f = 0; f < 200; ++f) {
        const double now = 1000 + double(f) / 60 + 0.003 * double(f * 7 % 5);   // up to 12 ms late, never early
        clock.arrived(f, now);
        EXPECT_GE(clock.due(now), f);
        EXPECT_LE(clock.due(now), f + 1);
    }
}

TEST(LiveClock, ADelayAboveTheJitterMakesTheBeatEven) {
    LiveClock clock(50, 0.02);
    std::int64_t last = -1;
    for (int ms = 0; ms < 4000; ++ms) {
        const double now = 500 + ms / 1000.0;
        if (ms % 20 == 13 || ms % 20 == 4) clock.arrived(ms / 20, now);   // frame by frame, some 4 and some 13 ms after their time
        if (ms < 100) continue;
        const std::int64_t due = clock.due(now);
        EXPECT_EQ(due, std::int64_t(std::floor((ms - 4 - 20) / 20.0 + 1e-6))) << ms;
        EXPECT_GE(due, last);
        last = due;
    }
}

TEST(LiveClock, FollowsAStreamThatGoesOnLater) {
    LiveClock clock(30, 0.1);
    clock.arrived(10, 100);
    for (int f = 11; f < 120; ++f) clock.arrived(f, 160 + f / 30.0);   // a minute's pause: its first frames say when the rest is due
    const double now = 160 + 119 / 30.0;
    EXPECT_EQ(clock.due(now), 119 - 3);
}

TEST(LiveClock, PicturesWaitForTheirSound) {
    LiveClock clock(50, 0.02), at_once(50, 0);
    for (int f = 0; f < 100; ++f) clock.arrived(f, 10 + f / 50.0), at_once.arrived(f, 10 + f / 50.0);
    const double now = 10 + 99 / 50.0;
    EXPECT_EQ(clock.due(now), 98);
    for (int i = 0; i < 200; ++i) clock.follow_sound(now - 10 - 0.12, now), at_once.follow_sound(now - 10 - 0.12, now);   // heard 0.12 s after it came
    EXPECT_EQ(clock.due(now), 93);
    EXPECT_EQ(at_once.due(now), 99) << "without a delay nothing waits";
    for (int i = 0; i < 200; ++i) clock.follow_sound(now - 10 - 5, now);
    EXPECT_EQ(clock.due(now), 99 - 15) << "0.3 s at most";
    for (int i = 0; i < 400; ++i) clock.follow_sound(now - 10, now);
    EXPECT_EQ(clock.due(now), 98) << "never less than the delay";
}

/// The small stream, live: its server, and a publisher that sends frames when told.
class LivePlayback : public testing::Test {
protected:
    explicit LivePlayback(bool sound = false) {
        encoder::StreamOptions options;
        options.group_seconds = 0.5;
        options.motion.preset = encoder::MotionPreset::live;
        options.texture.reset();
        auto made = encoder::encode_stream(small_clip(false, sound), options);
        if (!made.ok()) throw std::runtime_error(made.error().message);
        encoded_ = std::move(*made);
        encoded_.header.frames = 0;
        for (protocol::Track& track : encoded_.header.tracks)
            if (auto* info = std::get_if<protocol::SoundInfo>(&track.info)) info->samples = 0;
        start_server(0);
        publish();
    }
    void start_server(std::uint16_t port) {
        net::ServerOptions serving;
        serving.folder = folder_.path();
        serving.port = port;
        serving.publish = true;
        server_ = std::make_unique<net::Server>(serving);
        server_->start();
    }
    /// Another one on its port; our publisher goes with the old one.
    void restart_server() {
        const std::uint16_t port = server_->port();
        server_.reset();
        publisher_.reset();
        start_server(port);
    }
    net::Url url() const { return {"127.0.0.1", server_->port(), "ball"}; }
    void publish() {
        publisher_ = std::make_unique<net::Publisher>(url(), encoded_.header, encoded_.blobs);
        ASSERT_TRUE(publisher_->wait_ready(20s).ok());
    }
    /// Frames of the clip, each once.
    void send(std::int64_t first, std::int64_t end) {
        for (std::int64_t f = first; f < end; ++f) {
            const protocol::Group& group = encoded_.groups[std::size_t(f / 5)];
            if (f % 5 == 0) publisher_->start_group({0, group.group, group.first_time, 1});
            publisher_->send({0, group.objects[std::size_t(f % 5)].bytes});
        }
    }
    void open(double delay = 0) {
        SessionOptions options;
        options.delay = delay;
        options.source.first_backoff = 10ms;
        options.source.last_backoff = 100ms;
        auto session = open_session(net::to_string(url()), options);
        ASSERT_TRUE(session.ok()) << session.error().message;
        playback_ = std::make_unique<Playback>(std::move(*session), nullptr, false);
    }
    double now() const { return std::chrono::duration<double>(std::chrono::steady_clock::now().time_since_epoch()).count(); }
    /// Ticks until `done`; the frames shown meanwhile.
    std::vector<std::int64_t> tick_until(const std::function<bool(const std::vector<std::int64_t>&)>& done) {
        std::vector<std::int64_t> shown;
        for (const double end = now() + 20; now() < end && !done(shown);) {
            if (const auto frame = playback_->tick(now())) shown.push_back(frame->frame);
            else std::this_thread::sleep_for(1ms);
        }
        return shown;
    }
    std::vector<std::int64_t> shown_until(std::int64_t frame) {
        return tick_until([&](const auto& shown) { return !shown.empty() && shown.back() >= frame; });
    }

    TemporaryFolder folder_;
    encoder::EncodedStream encoded_;
    std::unique_ptr<net::Server> server_;
    std::unique_ptr<net::Publisher> publisher_;
    std::unique_ptr<Playback> playback_;
};

TEST_F(LivePlayback, ShowsTheNewestFrameAndSaysThatItIsLive) {
    send(0, 13);
    std::this_thread::sleep_for(50ms);
    open();
    EXPECT_TRUE(playback_->live());
    EXPECT_EQ(shown_until(12).back(), 12);
    EXPECT_FALSE(playback_->waiting());
    send(13, 15);
    EXPECT_EQ(shown_until(14).back(), 14);
    // There is nothing to seek in, and no other speed.
    playback_->seek(now(), 0);
    playback_->step(now(), -1);
    playback_->set_rate(now(), 2);
    EXPECT_EQ(playback_->rate(), 1);
    EXPECT_FALSE(playback_->paused());
    send(15, 16);
    EXPECT_EQ(shown_until(15).back(), 15);
}

TEST_F(LivePlayback, EndsWithItsPublisherAndGoesOnWithTheNext) {
    open();
    send(0, 7);
    EXPECT_EQ(shown_until(6).back(), 6);
    publisher_.reset();
    tick_until([&](const auto&) { return playback_->ended(); });
    EXPECT_TRUE(playback_->ended());
    EXPECT_FALSE(playback_->waiting());
    publish();
    send(0, 4);
    const auto shown = shown_until(7 + 3);
    ASSERT_FALSE(shown.empty());
    EXPECT_EQ(shown.back(), 10) << "its frames follow those before";
    EXPECT_FALSE(playback_->ended());
    EXPECT_EQ(playback_->session().decode->damaged_groups(), 0u);
}

TEST_F(LivePlayback, APauseGoesOnWithWhatIsNew) {
    open();
    send(0, 3);
    EXPECT_EQ(shown_until(2).back(), 2);
    playback_->toggle_pause(now());
    std::this_thread::sleep_for(100ms);
    send(3, 18);
    EXPECT_FALSE(playback_->tick(now()).has_value());
    playback_->toggle_pause(now());
    EXPECT_EQ(shown_until(17).back(), 17);
}

TEST_F(LivePlayback, ADamagedObjectCostsItsGroupAndNoMore) {
    open();
    send(0, 2);
    EXPECT_EQ(shown_until(1).back(), 1);
    publisher_->send({0, Bytes(100, std::byte(0x5a))});
    send(5, 8);
    const auto shown = shown_until(7);
    EXPECT_EQ(shown.back(), 7);
    EXPECT_EQ(playback_->session().decode->damaged_groups(), 1u);
}

TEST_F(LivePlayback, GoesOnWhenItsServerHasBeenStartedAgain) {
    open();
    send(0, 7);
    EXPECT_EQ(shown_until(6).back(), 6);
    const net::StreamSource& source = *playback_->session().source;
    restart_server();
    publish();   // a new publisher of a new server counts from 0 again
    tick_until([&](const auto&) { return source.status().state == net::SourceState::playing; });
    send(0, 4);
    const auto shown = shown_until(3);
    ASSERT_FALSE(shown.empty()) << source.status().reason;
    EXPECT_EQ(shown.back(), 3);
    EXPECT_FALSE(playback_->ended());
    EXPECT_EQ(playback_->session().decode->damaged_groups(), 0u);
    EXPECT_GE(source.statistics().reconnects, 1u);
}

/// The same with its sound.
class LiveWithSound : public LivePlayback {
protected:
    LiveWithSound() : LivePlayback(true) {
        for (const protocol::Track& track : encoded_.header.tracks)
            if (track.kind == protocol::TrackKind::sound) slot_ = track.rungs[0].slot;
        for (const protocol::Group& group : encoded_.groups) (group.slot == slot_ ? voice_ : motion_).push_back(group);
    }
    void send_group(std::size_t g, std::optional<std::size_t> damaged = {}) {
        for (const protocol::Group* group : {&motion_[g], &voice_[g]}) {
            publisher_->start_group({group->slot, group->group, group->first_time, 1});
            for (std::size_t i = 0; i < group->objects.size(); ++i)
                publisher_->send({group->slot, group->slot == slot_ && damaged == i ? Bytes(3, std::byte(0xff)) : group->objects[i].bytes});
        }
    }
    void listen() {
        SessionOptions options;
        options.sound_sink = [this](const StreamModel& stream) {
            EXPECT_TRUE(stream.sound.has_value());
            return [this](decoder::SoundDecoder::Block block) {
                const std::lock_guard lock(mutex_);
                blocks_.push_back(std::move(block));
            };
        };
        auto session = open_session(net::to_string(url()), options);
        ASSERT_TRUE(session.ok()) << session.error().message;
        playback_ = std::make_unique<Playback>(std::move(*session), nullptr, false);
    }
    /// Sample after the last one heard, once it is at least `sample`.
    std::int64_t heard_until(std::int64_t sample) {
        for (const double end = now() + 20; now() < end; std::this_thread::sleep_for(1ms)) {
            const std::lock_guard lock(mutex_);
            if (!blocks_.empty() && blocks_.back().first_sample + blocks_.back().sound.length() >= sample) return blocks_.back().first_sample + blocks_.back().sound.length();
        }
        return -1;
    }

    std::uint8_t slot_ = 0;
    std::vector<protocol::Group> motion_, voice_;
    std::mutex mutex_;
    std::vector<decoder::SoundDecoder::Block> blocks_;
};

TEST_F(LiveWithSound, IsHeardWithoutGapsFromTheGroupWhereOneJoins) {
    send_group(0);
    std::this_thread::sleep_for(50ms);
    listen();
    send_group(1);
    send_group(2);
    EXPECT_EQ(heard_until(72'000), 72'000);
    ASSERT_FALSE(blocks_.empty());
    std::int64_t next = blocks_.front().first_sample;
    EXPECT_LE(next, 24'000) << "of the group that was under way, or the next";
    double worst = 0;
    for (const auto& block : blocks_) {
        EXPECT_EQ(block.first_sample, next);
        EXPECT_EQ(block.sound.length(), 960);
        next += block.sound.length();
        if (block.first_sample < blocks_.front().first_sample + 4800) continue;
        for (std::int64_t i = 0; i < 960; ++i)
            worst = std::max(worst, std::abs(double(block.sound.samples[std::size_t(i)]) - 0.3 * std::sin(0.05 * double(block.first_sample + i))));
    }
    EXPECT_LT(worst, 0.1) << "the sine goes on across groups";
}

TEST_F(LiveWithSound, ADamagedPacketIsSilentUpToTheNextGroup) {
    listen();
    send_group(0, 10);
    send_group(1);
    EXPECT_EQ(heard_until(48'000), 48'000);
    bool in_gap = false, after = false;
    const std::int64_t lost = (10 - 4) * 960;   // four packets warm a decoder up
    for (const auto& block : blocks_) {
        in_gap = in_gap || (block.first_sample >= lost && block.first_sample < 24'000);
        after = after || block.first_sample == 24'000;
    }
    EXPECT_FALSE(in_gap);
    EXPECT_TRUE(after);
    EXPECT_EQ(playback_->session().decode->damaged_groups(), 1u);
    EXPECT_EQ(shown_until(9).back(), 9) << "pictures go on";
}

}  // namespace
}  // namespace mien::player
