#include <arpa/inet.h>
#include <gtest/gtest.h>
#include <netinet/in.h>
#include <sys/socket.h>
#include <unistd.h>

#include <cmath>
#include <fstream>

#include "core/environment_error.hpp"
#include "encoder/stream_encoder.hpp"
#include "io/frame_packet.hpp"
#include "tests/temporary_folder.hpp"
#include "tools/live_session.hpp"
#include "tools/stream_clip.hpp"

namespace mien::tools {
namespace {

using namespace std::chrono_literals;
using Got = LiveInput::Got;

constexpr std::int64_t kMarkers = 12, kFrames = 90;

TEST(FrameCounter, CountsWhatIsLostAndDropsWhatIsLate) {
    FrameCounter counter(60);
    EXPECT_EQ(counter.step(0xfffffffe), 1);
    EXPECT_EQ(counter.step(0xffffffff), 1);
    EXPECT_EQ(counter.step(2), 3) << "past the largest number, with two lost";
    EXPECT_EQ(counter.step(2), std::nullopt) << "twice";
    EXPECT_EQ(counter.step(1), std::nullopt) << "late";
    EXPECT_EQ(counter.step(3), 1);
    EXPECT_EQ(counter.step(63), 60);
    EXPECT_EQ(counter.step(500), 1) << "too far: the sender has begun anew";
    EXPECT_EQ(counter.step(0), 1) << "and here again";
    EXPECT_EQ(counter.step(1), 1);
}

protocol::MotionInfo markers_of(std::uint32_t count) { return {protocol::MotionKind::markers, count, false, false, false}; }

TEST(LineInput, TakesALineForEachFrame) {
    int ends[2];
    ASSERT_EQ(::pipe(ends), 0);
    const std::string text = "x0,y0,z0,x1,y1,z1\n1,2,3,nan,nan,nan\r\n\n4, 5 ,6e1,,,\n7,8\n1,2,3,x,5,6\n9,9,9,9,9,9";
    ASSERT_EQ(::write(ends[1], text.data(), text.size()), ssize_t(text.size()));
    ::close(ends[1]);
    const auto input = line_input(ends[0], markers_of(2));
    Captured captured;
    ASSERT_EQ(input->next(captured, 1s), Got::frame);
    EXPECT_EQ(captured.frame.values.head<3>(), Eigen::Vector3f(1, 2, 3));
    EXPECT_TRUE(captured.frame.values.tail<3>().array().isNaN().all());
    EXPECT_FALSE(captured.sequence.has_value());
    ASSERT_EQ(input->next(captured, 1s), Got::frame);
    EXPECT_EQ(captured.frame.values.head<3>(), Eigen::Vector3f(4, 5, 60));
    EXPECT_TRUE(captured.frame.values.tail<3>().array().isNaN().all()) << "empty fields";
    ASSERT_EQ(input->next(captured, 1s), Got::frame) << "past two lines that are none, and without a line's end";
    EXPECT_EQ(captured.frame.values, Eigen::VectorXf::Constant(6, 9));
    EXPECT_EQ(input->refused(), 2u);
    EXPECT_EQ(input->last_refusal(), "'x' is no number");
    EXPECT_EQ(input->next(captured, 1s), Got::end);
    ::close(ends[0]);
}

class UdpSender {
public:
    UdpSender() : socket_(::socket(AF_INET, SOCK_DGRAM | SOCK_CLOEXEC, 0)) {}
    ~UdpSender() { ::close(socket_); }
    void send(std::uint16_t port, ByteView bytes) const {
        sockaddr_in to{};
        to.sin_family = AF_INET;
        to.sin_port = htons(port);
        to.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
        ASSERT_EQ(::sendto(socket_, bytes.data(), bytes.size(), 0, reinterpret_cast<const sockaddr*>(&to), sizeof to), ssize_t(bytes.size()));
    }

private:
    int socket_;
};

/// A free UDP port, for as long as nobody takes it.
std::uint16_t free_port() {
    const int s = ::socket(AF_INET, SOCK_DGRAM | SOCK_CLOEXEC, 0);
    sockaddr_in address{};
    address.sin_family = AF_INET;
    address.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
    socklen_t size = sizeof address;
    ::bind(s, reinterpret_cast<const sockaddr*>(&address), size);
    ::getsockname(s, reinterpret_cast<sockaddr*>(&address), &size);
    ::close(s);
    return ntohs(address.sin_port);
}

TEST(UdpInput, TakesWholePacketsOfOneSender) {
    const std::uint16_t port = free_port();
    const auto input = udp_input("127.0.0.1", port, markers_of(2), {60, 1});
    UdpSender sender, other;
    Points at(2, 3);
    at << 1, 2, 3, 4, 5, 6;
    const Bytes good = io::encode(io::MarkerPacket{41, 0, at});
    Captured captured;
    EXPECT_EQ(input->next(captured, 1ms), Got::nothing);
    sender.send(port, good);
    ASSERT_EQ(input->next(captured, 5s), Got::frame);
    EXPECT_EQ(captured.sequence, 41u);
    EXPECT_EQ(captured.frame.values[5], 6);
    other.send(port, good);
    EXPECT_EQ(input->next(captured, 5s), Got::nothing);
    EXPECT_EQ(input->last_refusal(), "another sender sends here too");
    sender.send(port, ByteView(good).first(30));
    sender.send(port, io::encode(io::MarkerPacket{42, 0, at.topRows(1)}));
    sender.send(port, io::encode(io::LiveLinkPacket{}));
    for (int i = 0; i < 3; ++i) EXPECT_EQ(input->next(captured, 5s), Got::nothing);
    EXPECT_EQ(input->refused(), 4u);
    sender.send(port, good);
    EXPECT_EQ(input->next(captured, 5s), Got::frame);
    EXPECT_THROW(udp_input("127.0.0.1", port, markers_of(2), {60, 1}), EnvironmentError) << "the port is taken";
    EXPECT_THROW(udp_input("here", 1, markers_of(2), {60, 1}), EnvironmentError);
}

TEST(UdpInput, TakesTheFacesOfLiveLink) {
    const std::uint16_t port = free_port();
    const auto input = udp_input("127.0.0.1", port, {protocol::MotionKind::weights, 52, true, true, false}, {30, 1});
    io::LiveLinkPacket packet{.frame = 600, .subframe = 0.1f};
    for (std::size_t i = 0; i < packet.values.size(); ++i) packet.values[i] = float(i) / 100;
    const UdpSender sender;
    sender.send(port, io::encode(packet));
    Captured captured;
    ASSERT_EQ(input->next(captured, 5s), Got::frame);
    EXPECT_EQ(captured.sequence, 300u) << "frame 600 at 60 Hz is frame 300 at 30";
    ASSERT_EQ(captured.frame.values.size(), 52);
    EXPECT_FLOAT_EQ(captured.frame.values[51], 0.51f);
    ASSERT_TRUE(captured.frame.pose && captured.frame.gaze);
    EXPECT_FLOAT_EQ(captured.frame.gaze->yaw[1], -0.55f);
}

/// Twelve markers on a slowly changing surface.
Clip marker_clip(double phase) {
    Clip clip;
    clip.name = "training";
    clip.markers.emplace(kFrames, kMarkers);
    for (std::int64_t f = 0; f < kFrames; ++f)
        for (std::int64_t m = 0; m < kMarkers; ++m) {
            const double t = double(f) / 15 + phase, at = double(m);
            clip.markers->frame(f).row(m) << float(10 * at), float(3 * std::sin(t + 0.4 * at)), float(2 * std::cos(1.7 * t) * std::sin(at));
        }
    return clip;
}

class LiveSessionTest : public testing::Test {
protected:
    static void SetUpTestSuite() {
        encoder::StreamOptions options;
        options.motion.kind = protocol::MotionKind::markers;
        options.motion.preset = encoder::MotionPreset::live;
        options.motion.rms = 0.02;
        const auto encoded = encoder::encode_stream(marker_clip(0), options);
        ASSERT_TRUE(encoded.ok()) << encoded.error().message;
        const tests::TemporaryFolder folder;
        std::ofstream file(folder / "training.mien", std::ios::binary);
        protocol::StreamFileWriter writer([&](ByteView bytes) { file.write(reinterpret_cast<const char*>(bytes.data()), std::streamsize(bytes.size())); },
                                          encoded->header, encoded->blobs);
        for (const auto& group : encoded->groups) writer.add(group);
        writer.finish();
        file.close();
        auto take = read_take((folder / "training.mien").string());
        ASSERT_TRUE(take.ok()) << take.error().message;
        take_ = std::move(*take);
    }
    Captured captured(const Clip& clip, std::int64_t f, std::optional<std::uint32_t> sequence) const {
        return {{Eigen::Map<const Eigen::VectorXf>(clip.markers->frame(f).data(), 3 * kMarkers), {}, {}}, sequence};
    }
    Clip decoded(const std::filesystem::path& path) const {
        const auto stream = StoredStream::open(path);
        EXPECT_TRUE(stream.ok() && stream->reader().complete());
        auto clip = decode_stream(*stream);
        if (!clip) throw std::runtime_error(clip.error().message);
        return std::move(*clip);
    }

    tests::TemporaryFolder folder_;
    static inline StoredTake take_;
};

TEST_F(LiveSessionTest, RecordsWhatComesAndHoldsWhatDoesNot) {
    const Clip clip = marker_clip(0.5);
    LiveOptions options;
    options.recording = folder_ / "live.mien";
    auto session = LiveSession::start(take_, options);
    ASSERT_TRUE(session.ok()) << session.error().message;
    for (std::int64_t f = 0; f < kFrames; ++f) {
        if (f >= 40 && f < 43) continue;                                     // lost
        ASSERT_TRUE((*session)->add(captured(clip, f, std::uint32_t(f + 7)), double(f) / 30).ok());
        if (f != 50) continue;
        ASSERT_TRUE((*session)->add(captured(clip, 48, 48 + 7), double(f) / 30).ok());       // late: dropped
    }
    EXPECT_TRUE(std::filesystem::exists(folder_ / "live.mien.recording")) << "what there is so far is safe";
    EXPECT_EQ((*session)->lost(), 3u);
    EXPECT_EQ((*session)->late(), 1u);
    const auto figures = (*session)->figures();
    (*session)->finish();
    EXPECT_FALSE(std::filesystem::exists(folder_ / "live.mien.recording"));
    EXPECT_EQ(figures.frames, kFrames);
    EXPECT_LT(figures.rms, 0.1);

    const Clip back = decoded(folder_ / "live.mien");
    ASSERT_EQ(back.frame_count(), kFrames);
    double worst = 0;
    for (std::int64_t f = 0; f < kFrames; ++f) {
        const std::int64_t truth = f >= 40 && f < 43 ? 39 : f;
        worst = std::max(worst, double((back.markers->frame(f) - clip.markers->frame(truth)).rowwise().norm().maxCoeff()));
    }
    EXPECT_LT(worst, 0.5) << "every frame at its own time, lost ones held";
}

/// Clicks, one in each tenth of a second, so that time can be heard.
Sound clicks(double seconds) {
    Sound sound{48000, 1, std::vector<float>(std::size_t(seconds * 48000))};
    for (std::size_t at = 2400; at + 48 < sound.samples.size(); at += 4800)
        for (std::size_t i = 0; i < 48; ++i) sound.samples[at + i] = 0.8f * std::sin(float(i) * 0.4f);
    return sound;
}

TEST_F(LiveSessionTest, SoundStaysWithThePicturesItCameWith) {
    const Clip clip = marker_clip(0.5);
    const Sound sound = clicks(3);
    LiveOptions options;
    options.recording = folder_ / "live.mien";
    options.sound = encoder::LiveSoundOptions{48000, 1, 64};
    auto session = LiveSession::start(take_, options);
    ASSERT_TRUE(session.ok()) << session.error().message;
    const double begin = 1000;   // when frame 0 is captured
    const auto packet = [&](int p) {   // of 10 ms, when its last sample has been captured; the sender counts from anywhere
        CapturedSound captured{777'777 + 480 * p, {48000, 1, {sound.samples.begin() + 480 * p, sound.samples.begin() + 480 * (p + 1)}}};
        return (*session)->add_sound(captured, begin + 0.01 * (p + 1) + (p % 7 == 0 ? 0.004 : 0));   // late, some of them
    };
    int p = 0;
    for (; p < 10; ++p) ASSERT_TRUE(packet(p).ok()) << "before there is a picture: heard by nobody";
    for (std::int64_t f = 3; f < kFrames; ++f) {   // the first picture is 0.1 s after the first sound
        const double now = begin + double(f) / 30;
        for (; p < 290 && 0.01 * (p + 1) <= now - begin; ++p)
            if (p < 150 || p >= 155) {   // 50 ms lost
                ASSERT_TRUE(packet(p).ok());
            }
        ASSERT_TRUE((*session)->add(captured(clip, f, std::uint32_t(f)), now).ok());
    }
    (*session)->finish();

    const auto stream = StoredStream::open(folder_ / "live.mien");
    ASSERT_TRUE(stream.ok() && stream->reader().complete());
    const Clip back = decoded(folder_ / "live.mien");
    ASSERT_TRUE(back.sound);
    EXPECT_EQ(back.frame_count(), kFrames - 3);
    // Stream time 0 is frame 3, 0.1 s after the sound's own zero: a click then lies 0.05 s after every tenth as it did.
    const auto loudness = [&](double from, double to) {
        double most = 0;
        for (auto i = std::int64_t(from * 48000); i < std::min(back.sound->length(), std::int64_t(to * 48000)); ++i) most = std::max(most, double(std::abs(back.sound->samples[std::size_t(i)])));
        return most;
    };
    for (int click = 1; click < 26; ++click) {
        const double at = 0.05 + 0.1 * click;   // in the stream
        if (at + 0.1 > 1.49 && at + 0.1 < 1.56) continue;   // lost
        EXPECT_GT(loudness(at - 0.004, at + 0.006), 0.3) << click;
        EXPECT_LT(loudness(at - 0.045, at - 0.006), 0.2) << click;
    }
    EXPECT_NEAR(back.sound->seconds(), 2.8, 0.05);
    const auto& tracks = stream->reader().header().tracks;
    ASSERT_EQ(tracks.size(), 2u);
    EXPECT_NEAR(double(tracks[1].rungs[0].bits_per_second), 64'000, 20'000);
    EXPECT_LT(tracks[0].rungs[0].bits_per_second, 20'000u);
}

TEST_F(LiveSessionTest, SoundWithoutPicturesDoesNotPileUp) {
    const Clip clip = marker_clip(0.5);
    const Sound sound = clicks(1);
    LiveOptions options;
    options.recording = folder_ / "live.mien";
    options.sound = encoder::LiveSoundOptions{48000, 1, 64};
    auto session = LiveSession::start(take_, options);
    ASSERT_TRUE(session.ok());
    const auto sounds = [&](int from, int to) {
        for (int p = from; p < to; ++p)
            ASSERT_TRUE((*session)->add_sound({480 * p, {48000, 1, {sound.samples.begin() + 480 * (p % 90), sound.samples.begin() + 480 * (p % 90 + 1)}}}, 5 + 0.01 * (p + 1)).ok());
    };
    ASSERT_TRUE((*session)->add(captured(clip, 0, 0), 5).ok());
    sounds(0, 1000);                                                   // ten seconds, and no picture
    for (int f = 1; f < 60; ++f) ASSERT_TRUE((*session)->add(captured(clip, f, std::uint32_t(f)), 15 + f / 30.0).ok());
    sounds(1000, 1200);
    (*session)->finish();
    const Clip back = decoded(folder_ / "live.mien");
    ASSERT_TRUE(back.sound);
    EXPECT_LT(back.sound->seconds(), 4.5);
    EXPECT_GT(back.sound->seconds(), 1.5);
}

TEST_F(LiveSessionTest, SoundIsRightAgainAtOnceAfterItsSenderOrThePicturesWereAway) {
    const Clip clip = marker_clip(0.5);
    const Sound sound = clicks(6);
    LiveOptions options;
    options.recording = folder_ / "live.mien";
    options.sound = encoder::LiveSoundOptions{48000, 1, 64};
    auto session = LiveSession::start(take_, options);
    ASSERT_TRUE(session.ok());
    const double begin = 50;
    std::int64_t sent = 0;
    double away = 0;   // seconds for which nothing came, pictures and sound
    const auto run = [&](std::int64_t first, std::int64_t end, std::int64_t sound_offset) {
        for (std::int64_t f = first; f < end; ++f) {
            const double now = begin + away + double(f) / 30;
            for (; 0.01 * double(sent + 1) <= double(f) / 30; ++sent)
                ASSERT_TRUE((*session)->add_sound({480 * sent + sound_offset, {48000, 1, {sound.samples.begin() + 480 * sent, sound.samples.begin() + 480 * (sent + 1)}}},
                                                  begin + away + 0.01 * double(sent + 1)).ok());
            ASSERT_TRUE((*session)->add(captured(clip, f % kFrames, std::uint32_t(f)), now).ok());
        }
    };
    run(0, 60, 0);
    away = 7;              // both go on seven seconds later; frames count on, and another sender's samples from elsewhere
    run(60, 150, 200'000);
    (*session)->finish();
    const Clip back = decoded(folder_ / "live.mien");
    ASSERT_TRUE(back.sound);
    EXPECT_EQ(back.frame_count(), 150);
    for (int click = 30; click < 48; ++click) {   // from the first group on that is whole after it
        double most = 0;
        for (auto i = std::int64_t((0.05 + 0.1 * click - 0.004) * 48000); i < std::int64_t((0.05 + 0.1 * click + 0.006) * 48000); ++i) most = std::max(most, double(std::abs(back.sound->samples[std::size_t(i)])));
        EXPECT_GT(most, 0.3) << click;
    }
}

TEST(SampleCounter, CountsOnThroughWrapsAndNewSenders) {
    SampleCounter counter(48000);
    const auto at = [&](std::uint32_t timestamp, std::uint32_t source) { return counter.count({.timestamp = timestamp, .source = source}, 480); };
    EXPECT_EQ(at(0xffffff00, 1), 0);
    EXPECT_EQ(at(0xffffff00 + 480, 1), 480) << "past the largest number";
    EXPECT_EQ(at(0xffffff00, 1), 0) << "late";
    EXPECT_EQ(at(0xffffff00 + 1440, 1), 1440) << "one lost";
    EXPECT_EQ(at(7, 2), 1920 + 96000) << "another sender";
    EXPECT_EQ(at(487, 2), 2400 + 96000);
    EXPECT_EQ(at(487 + 48000 * 20, 2), 2880 + 2 * 96000) << "begun anew";
}

TEST(SoundFormat, IsARateAndPerhapsChannels) {
    EXPECT_EQ(parse_sound_format("48000")->channels, 1);
    EXPECT_EQ(parse_sound_format("44100x2")->sample_rate, 44100);
    EXPECT_EQ(parse_sound_format("44100x2")->channels, 2);
    for (const char* wrong : {"", "x", "48k", "48000x3", "48000x0", "100", "1e9", "48000x2x2", "-48000"}) EXPECT_FALSE(parse_sound_format(wrong).ok()) << wrong;
}

TEST(SoundInput, TakesL16AndNothingElse) {
    const std::uint16_t port = free_port();
    SoundInput input("127.0.0.1", port, {44100, 2});
    const UdpSender sender;
    const Bytes payload = io::encode_l16({44100, 2, {0.5f, -0.5f}});
    sender.send(port, io::encode(io::RtpPacket{10, 1, 100, 9, payload}));
    const auto first = input.next(5s);
    ASSERT_TRUE(first);
    EXPECT_EQ(first->first, 0);
    EXPECT_EQ(first->sound.samples, (std::vector<float>{0.5f, -0.5f}));
    sender.send(port, io::encode(io::RtpPacket{97, 2, 101, 9, payload}));
    const auto second = input.next(5s);
    ASSERT_TRUE(second);
    EXPECT_EQ(second->first, 1);
    sender.send(port, io::encode(io::RtpPacket{0, 3, 102, 9, payload}));
    EXPECT_FALSE(input.next(5s));
    EXPECT_EQ(input.last_refusal(), "RTP of payload type 0 is no L16 sound");
    sender.send(port, io::encode(io::RtpPacket{11, 3, 102, 9, payload}));
    EXPECT_FALSE(input.next(5s));
    EXPECT_EQ(input.last_refusal(), "RTP of payload type 11 is sound of 44100x1; --sound-format says 44100x2");
    sender.send(port, Bytes(3));
    EXPECT_FALSE(input.next(5s));
    EXPECT_EQ(input.refused(), 3u);
}

TEST_F(LiveSessionTest, ARecordingThatIsBrokenOffStillPlays) {
    const Clip clip = marker_clip(0.5);
    LiveOptions options;
    options.recording = folder_ / "live.mien";
    {
        auto session = LiveSession::start(take_, options);
        ASSERT_TRUE(session.ok());
        for (std::int64_t f = 0; f < 75; ++f) ASSERT_TRUE((*session)->add(captured(clip, f, {}), double(f) / 30).ok());
    }
    EXPECT_FALSE(std::filesystem::exists(folder_ / "live.mien"));
    const auto stream = StoredStream::open(folder_ / "live.mien.recording");
    ASSERT_TRUE(stream.ok());
    EXPECT_EQ(stream->reader().groups().size(), 2u) << "the groups that were whole";
    EXPECT_THROW((void)LiveSession::start(take_, options), EnvironmentError) << "it is not overwritten";
}

TEST_F(LiveSessionTest, ARecordingOfNothingIsNone) {
    LiveOptions options;
    options.recording = folder_ / "live.mien";
    auto session = LiveSession::start(take_, options);
    ASSERT_TRUE(session.ok());
    EXPECT_THROW((*session)->finish(), EnvironmentError);
    EXPECT_FALSE(std::filesystem::exists(folder_ / "live.mien"));
    EXPECT_FALSE(std::filesystem::exists(folder_ / "live.mien.recording"));
}

}  // namespace
}  // namespace mien::tools
