#include <fmt/format.h>
#include <gtest/gtest.h>
#include <sys/resource.h>

#include <cmath>
#include <map>
#include <random>

#include "encoder/texture_encoder.hpp"
#include "player/group_decoder.hpp"
#include "player/session.hpp"
#include "tests/player/small_stream.hpp"

/// Damage that no checksum notices, because the stream was written with it: every payload through the player's own way
/// from a file to pictures and sound. Each must end in an error or in pictures, and cost at most its own group.
namespace mien::player {
namespace {

constexpr std::int64_t kGroupFrames = 5;

/// What a stream gave, in a form that compares.
struct Played {
    std::string refused;                           ///< why it did not open; empty: it did
    struct Frame {
        Hash motion;
        std::optional<Hash> picture;               ///< none: damaged
        bool operator==(const Frame&) const = default;
    };
    std::map<std::int64_t, Frame> frames;
    std::map<std::int64_t, Hash> sound;            ///< blocks by their first sample
    std::uint64_t damaged = 0;
};

Played::Frame hashes_of(const PlayFrame& frame) {
    const auto hash = [&](const auto& values) { return sha256(std::as_bytes(std::span(values.data(), std::size_t(values.size())))); };
    Played::Frame hashes{hash(frame.motion.coefficients), {}};
    if (frame.texture) hashes.picture = hash(decoder::to_rgb(frame.texture->picture).pixels);
    return hashes;
}

/// Everything a stored stream gives, checked for being what its header says as far as a player relies on it.
Played play(const std::string& file) {
    Played played;
    net::SourceOptions options;
    options.rate = 0;
    auto source = net::open_source(file, options);
    if (!source.ok()) return played.refused = source.error().message, played;
    auto stream = open_stream_model(**source, true);
    if (!stream.ok()) return played.refused = stream.error().message, played;
    DamageLog log;
    GroupDecoder groups(*stream, log);
    groups.restart(0);
    const auto decode = [&] {
        while (groups.has_work())
            for (const PlayFrame& frame : groups.step()) {
                EXPECT_TRUE(played.frames.emplace(frame.frame, hashes_of(frame)).second) << "frame " << frame.frame << " came twice";
                if (frame.texture) {
                    EXPECT_EQ(frame.texture->picture.width, stream->texture_rungs[stream->first_texture_rung].width);
                    EXPECT_EQ(frame.texture->picture.height, stream->texture_rungs[stream->first_texture_rung].height);
                }
                EXPECT_EQ(frame.motion.coefficients.size(), stream->composed.size());
                EXPECT_TRUE(model::evaluate(stream->model, stream->composed, frame.motion).allFinite());
            }
    };
    while (auto arrival = (*source)->next(std::chrono::milliseconds(0))) {
        if (!arrival->group) break;
        if (stream->sound && arrival->group->slot == stream->sound_slot) {
            const auto block = stream->sound->decode(*arrival->group);
            if (!block.ok()) continue;
            const auto& samples = block->sound.samples;
            EXPECT_TRUE(std::ranges::all_of(samples, [](float s) { return std::isfinite(s); }));
            played.sound.emplace(block->first_sample, sha256(std::as_bytes(std::span(samples))));
        } else {
            groups.add(std::move(*arrival->group));
            decode();
        }
    }
    groups.finish();
    decode();
    played.damaged = groups.damaged_groups();
    return played;
}

long peak_memory_kb() {
    rusage usage{};
    getrusage(RUSAGE_SELF, &usage);
    return usage.ru_maxrss;
}

/// One stream, and what it gives undamaged.
class Damage : public testing::TestWithParam<std::tuple<const char*, const char*>> {
protected:
    void SetUp() override {
        const auto [texture, sound] = GetParam();
        const auto codecs = encoder::texture_codecs();
        if (std::ranges::find(codecs, texture) == codecs.end()) GTEST_SKIP() << "skipped: no encoder for " << texture << " here";
        Clip clip = small_clip(true, true);
        clip.vertices->frames = 3 * kGroupFrames;
        clip.vertices->xyz.resize(std::size_t(clip.vertices->frames * clip.vertices->points) * 3);
        clip.texture = std::make_shared<NumberedTexture>(clip.vertices->frames);
        clip.sound->samples.resize(48000 * 3 / 2);
        encoder::StreamOptions options;
        options.group_seconds = 0.5;
        options.texture->codec = texture;
        options.sound->codec = sound;
        auto encoded = encoder::encode_stream(clip, options);
        ASSERT_TRUE(encoded.ok()) << encoded.error().message;
        stream_ = std::move(*encoded);
        whole_ = play(store(stream_, folder_));
        ASSERT_EQ(whole_.refused, "");
        ASSERT_EQ(std::int64_t(whole_.frames.size()), clip.vertices->frames);
        ASSERT_EQ(whole_.sound.size(), 3u);
        ASSERT_EQ(whole_.damaged, 0u);
    }

    protocol::TrackKind kind_of(std::uint8_t slot) const {
        for (const protocol::Track& track : stream_.header.tracks)
            if (track.rungs.front().slot == slot) return track.kind;
        return protocol::TrackKind::motion;
    }

    /// Plays the stream with one payload exchanged and signed anew; nothing outside its group and track may differ.
    void play_with(std::size_t group, std::size_t object, Bytes bytes, const std::string& what) {
        encoder::EncodedStream damaged = stream_;
        damaged.groups[group].objects[object].bytes = std::move(bytes);
        const Played played = play(store(damaged, folder_));
        SCOPED_TRACE(what);
        ASSERT_EQ(played.refused, "") << "payloads are looked at when their group is due";
        EXPECT_LE(played.damaged, 1u);
        const bool sound = kind_of(stream_.groups[group].slot) == protocol::TrackKind::sound;
        const auto number = std::int64_t(stream_.groups[group].group);
        std::int64_t whole_frames = 0;
        for (const auto& [frame, hash] : whole_.frames) {
            if (!sound && frame / kGroupFrames == number) continue;
            const auto found = played.frames.find(frame);
            ASSERT_NE(found, played.frames.end()) << "frame " << frame << " was lost";
            EXPECT_TRUE(found->second == hash) << "frame " << frame << " changed";
            ++whole_frames;
        }
        EXPECT_EQ(whole_frames, sound ? 3 * kGroupFrames : 2 * kGroupFrames);
        for (const auto& [first, hash] : whole_.sound) {
            if (sound && first == stream_.groups[group].first_time) continue;
            const auto found = played.sound.find(first);
            ASSERT_NE(found, played.sound.end()) << "the sound at sample " << first << " was lost";
            EXPECT_EQ(found->second, hash) << "the sound at sample " << first << " changed";
        }
    }

    TemporaryFolder folder_;
    encoder::EncodedStream stream_;
    Played whole_;
};

TEST_P(Damage, OfAnyPayloadCostsAtMostItsGroup) {
    const long before = peak_memory_kb();
    std::mt19937 random(5);
    for (const protocol::TrackKind kind : {protocol::TrackKind::motion, protocol::TrackKind::texture, protocol::TrackKind::sound}) {
        std::vector<std::size_t> groups;
        for (std::size_t g = 0; g < stream_.groups.size(); ++g)
            if (kind_of(stream_.groups[g].slot) == kind) groups.push_back(g);
        ASSERT_EQ(groups.size(), 3u);
        for (int sample = 0; sample < 8; ++sample) {
            const std::size_t group = groups[random() % groups.size()];
            const auto& objects = stream_.groups[group].objects;
            const std::size_t object = random() % objects.size();
            Bytes bytes = objects[object].bytes;
            // The start of a packet steers its decoder: half of the damage goes there.
            const std::size_t at = random() % (sample % 2 ? bytes.size() : std::min<std::size_t>(bytes.size(), 24));
            const std::string where = fmt::format("track {}, group {}, object {}, byte {}", int(kind), group, object, at);
            for (const int value : {0x00, 0xff, int(bytes[at]) ^ 1 << random() % 8}) {
                if (int(bytes[at]) == value) continue;
                Bytes damaged = bytes;
                damaged[at] = std::byte(value);
                play_with(group, object, std::move(damaged), fmt::format("{} := {}", where, value));
            }
            bytes.resize(at);
            play_with(group, object, std::move(bytes), where + ": cut");
        }
    }
    EXPECT_LT(peak_memory_kb() - before, 1 << 20) << "kB that damage made it take";
}

TEST_P(Damage, OfTheCodecHeadersIsRefusedOrPlays) {
    for (std::size_t t = 1; t < stream_.header.tracks.size(); ++t) {
        const Bytes& config = stream_.header.tracks[t].rungs.front().codec_config;
        for (std::size_t at = 0; at < config.size(); at += 1 + config.size() / 12)
            for (const int value : {0x00, 0xff, int(config[at]) ^ 0x10}) {
                encoder::EncodedStream damaged = stream_;
                damaged.header.tracks[t].rungs.front().codec_config[at] = std::byte(value);
                const Played played = play(store(damaged, folder_));
                EXPECT_LE(played.frames.size(), whole_.frames.size());
                EXPECT_LE(played.sound.size(), whole_.sound.size());
            }
    }
}

TEST_P(Damage, OfTheFileItselfIsRefusedOrPlays) {
    std::ifstream in(store(stream_, folder_), std::ios::binary);
    const std::string file{std::istreambuf_iterator<char>(in), {}};
    const std::string damaged = folder_ / "damaged.mien";
    const auto play_bytes = [&](const std::string& bytes, const std::string& what) {
        SCOPED_TRACE(what);
        std::ofstream(damaged, std::ios::binary) << bytes;
        const Played played = play(damaged);
        EXPECT_TRUE(!played.refused.empty() || played.frames.size() >= whole_.frames.size() - kGroupFrames || bytes.size() < file.size());
        // The checksums let nothing through that was not written.
        for (const auto& [frame, hashes] : played.frames) {
            EXPECT_EQ(hashes.motion, whole_.frames.at(frame).motion) << "frame " << frame;
            EXPECT_TRUE(!hashes.picture || hashes.picture == whole_.frames.at(frame).picture) << "frame " << frame;
        }
    };
    for (std::size_t at = 0; at < file.size(); at += 1 + file.size() / 25) {
        for (const int value : {0x00, 0xff, int(std::uint8_t(file[at])) ^ 0x40}) {
            std::string bytes = file;
            bytes[at] = char(value);
            play_bytes(bytes, fmt::format("byte {} := {}", at, value));
        }
        play_bytes(file.substr(0, at), fmt::format("cut at {} of {}", at, file.size()));
    }
}

INSTANTIATE_TEST_SUITE_P(Codecs, Damage,
                         testing::Values(std::tuple("h264", "opus"), std::tuple("hevc", "aac"), std::tuple("mpeg4", "opus"),
                                         std::tuple("av1", "aac")),
                         [](const auto& named) { return std::string(std::get<0>(named.param)) + "_" + std::get<1>(named.param); });

}  // namespace
}  // namespace mien::player
