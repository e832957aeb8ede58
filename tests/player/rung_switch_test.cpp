#include <gtest/gtest.h>

#include <random>
#include <thread>

#include "player/playback.hpp"
#include "small_stream.hpp"
#include "tests/net/harness.hpp"

/// The rung of texture changes while a stream plays: by hand, and by itself on a line that becomes slow and fast again.
namespace mien::player {
namespace {

using namespace std::chrono_literals;

/// Pictures that no codec makes small: noise of its own in each frame.
class NoisyTexture final : public TextureSource {
public:
    explicit NoisyTexture(std::int64_t frames) : frames_(frames) {}
    int width() const override { return 96; }
    int height() const override { return 96; }
    std::int64_t frames() const override { return frames_; }
    Result<Image> read(std::int64_t frame) override {
        Image image(96, 96, 3);
        std::minstd_rand random(std::uint32_t(frame + 1));
        for (std::size_t i = 0; i < image.pixels.size(); i += 3)
            image.pixels[i] = image.pixels[i + 1] = image.pixels[i + 2] = std::uint8_t(random() >> 20);
        return image;
    }

private:
    std::int64_t frames_;
};

constexpr double kSeconds = 24;

/// 25 frames a second, groups of half a second, rungs of about 60, 240 and 960 kbit/s.
const encoder::EncodedStream& laddered_stream() {
    static const encoder::EncodedStream stream = [] {
        Clip clip;
        clip.name = "ladder";
        clip.frame_rate = {25, 1};
        clip.neutral = render::make_ball(90, 6, 8);
        const auto frames = std::int64_t(kSeconds * 25);
        clip.vertices.emplace(frames, clip.neutral->vertex_count());
        for (std::int64_t f = 0; f < frames; ++f) clip.vertices->frame(f) = clip.neutral->positions * (1 + 0.0002f * float(f % 50));
        clip.texture = std::make_shared<NoisyTexture>(frames);
        encoder::StreamOptions options;
        options.group_seconds = 0.5;
        options.texture->rungs = {{60, 0}, {240, 0}, {960, 0}};
        options.texture->speed = "ultrafast";
        auto made = encoder::encode_stream(clip, options);
        if (!made.ok()) throw std::runtime_error(made.error().message);
        return std::move(*made);
    }();
    return stream;
}

double now() { return std::chrono::duration<double>(std::chrono::steady_clock::now().time_since_epoch()).count(); }

class RungSwitch : public testing::Test {
protected:
    void serve(double ahead) {
        store(laddered_stream(), folder_);
        net::ServerOptions serving;
        serving.folder = folder_.path();
        serving.port = 0;
        serving.ahead = ahead;
        server_.emplace(serving);
        server_->start();
        line_.emplace(server_->port());
    }
    void open(const TextureChoice& choice) {
        SessionOptions options;
        options.sound = false;
        options.texture = choice;
        options.wait = 30;
        auto session = open_session("mien://127.0.0.1:" + std::to_string(line_->port()) + "/ball", options);
        ASSERT_TRUE(session.ok()) << session.error().message;
        playback_ = std::make_unique<Playback>(std::move(*session), nullptr, false);
    }
    /// Plays in real time until a frame of this rung is shown; false at the end of the stream.
    bool shows(std::size_t rung) {
        for (const double end = now() + 60; now() < end && !playback_->ended(); std::this_thread::sleep_for(2ms)) {
            const auto frame = playback_->tick(now());
            if (!frame) continue;
            EXPECT_GT(frame->frame, last_) << "in order, each once";
            last_ = frame->frame;
            if (frame->texture_rung == rung) return true;
        }
        return false;
    }
    void expect_sound() {
        const DecodeThread& decode = *playback_->session().decode;
        EXPECT_EQ(decode.damaged_groups(), 0u);
        EXPECT_EQ(playback_->session().source->statistics().reconnects, 0u);
    }

    TemporaryFolder folder_;
    std::optional<net::Server> server_;
    std::optional<net::harness::Proxy> line_;
    std::unique_ptr<Playback> playback_;
    std::int64_t last_ = -1;
};

TEST_F(RungSwitch, ByHandItTakesEffectWithoutASeekAndNothingElseIsSent) {
    serve(1);
    open({.rung = 2});
    ASSERT_TRUE(shows(2));
    EXPECT_FALSE(playback_->follows_line());
    const StreamModel& stream = *playback_->session().stream;
    const DecodeThread& decode = *playback_->session().decode;
    playback_->set_rung(0);
    EXPECT_EQ(playback_->rung(), 0u);
    ASSERT_TRUE(shows(0));
    EXPECT_EQ(decode.bytes_of(stream.texture_rungs[1].slot), 0u);
    playback_->set_rung(9);
    ASSERT_TRUE(shows(2));
    EXPECT_EQ(decode.bytes_of(stream.texture_rungs[1].slot), 0u);
    expect_sound();
}

TEST_F(RungSwitch, ASlowLineGoesDownTheLadderAndAFastOneUpAgain) {
    serve(2);
    open({.automatic = true});
    EXPECT_TRUE(playback_->follows_line());
    ASSERT_TRUE(shows(2));
    line_->throttle(30'000);   // 240 kbit/s
    ASSERT_TRUE(shows(0)) << "rung " << playback_->rung();
    line_->throttle(0);
    ASSERT_TRUE(shows(1)) << "rung " << playback_->rung();
    EXPECT_TRUE(playback_->follows_line());
    expect_sound();
}

TEST_F(RungSwitch, AReconnectAfterAChangeShowsEachFrameOnce) {
    serve(1);
    open({.rung = 2});
    ASSERT_TRUE(shows(2));
    playback_->set_rung(1);
    line_->cut();
    ASSERT_TRUE(shows(1));
    EXPECT_EQ(playback_->session().decode->damaged_groups(), 0u);
    EXPECT_GE(playback_->session().source->statistics().reconnects, 1u);
}

}  // namespace
}  // namespace mien::player
