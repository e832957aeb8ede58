#include "io/sound_file.hpp"

#include <fmt/format.h>
#include <sndfile.h>

#include <algorithm>
#include <cmath>
#include <memory>
#include <vector>

#include "core/byte_io.hpp"
#include "io/file.hpp"
#include "io/limits.hpp"

namespace mien::io {
namespace {

struct SoundCloser {
    void operator()(SNDFILE* file) const { sf_close(file); }
};

}  // namespace

Result<Sound> read_sound(const std::filesystem::path& path) {
    MIEN_TRY(readable, open_to_read(path));  // for messages that tell "missing" from "not a sound"
    readable.reset();
    SF_INFO format{};
    const std::unique_ptr<SNDFILE, SoundCloser> file(sf_open(path.c_str(), SFM_READ, &format));
    if (!file) return Error{ErrorCode::damaged, fmt::format("{} is not a sound file that can be read: {}", path.string(), sf_strerror(nullptr))};
    if (format.channels < 1 || format.channels > 8 || format.samplerate < 1)
        return Error{ErrorCode::invalid, fmt::format("{} has {} channels at {} Hz; 1 to 8 channels are possible", path.string(), format.channels, format.samplerate)};

    Sound sound;
    sound.sample_rate = format.samplerate;
    sound.channels = format.channels;
    // Grows with what is really there: the header's frame count may be anything.
    std::vector<float> piece(std::size_t(format.channels) * 16384);
    for (;;) {
        const sf_count_t got = sf_readf_float(file.get(), piece.data(), 16384);
        if (got <= 0) break;
        sound.samples.insert(sound.samples.end(), piece.begin(), piece.begin() + std::ptrdiff_t(got * format.channels));
        if (std::int64_t(sound.samples.size()) > kMaxSoundSamples)
            return Error{ErrorCode::limit_exceeded, fmt::format("{} is longer than {} samples", path.string(), kMaxSoundSamples)};
    }
    if (sf_error(file.get()) != SF_ERR_NO_ERROR)
        return Error{ErrorCode::damaged, fmt::format("{} breaks off: {}", path.string(), sf_strerror(file.get()))};
    for (std::size_t i = 0; i < sound.samples.size(); ++i)
        if (!std::isfinite(sound.samples[i]))
            return Error{ErrorCode::invalid, fmt::format("{}: sample {} is not finite", path.string(), i / std::size_t(format.channels))};
    return sound;
}

void write_wav(const std::filesystem::path& path, const Sound& sound) {
    // Written by hand rather than by libsndfile, which reports a full disk only in part.
    const auto size = static_cast<std::uint32_t>(sound.samples.size() * 2);
    ByteWriter header;
    const auto tag = [&](const char* name) { header.bytes(std::as_bytes(std::span(name, 4))); };
    tag("RIFF");
    header.u32(36 + size);
    tag("WAVE");
    tag("fmt ");
    header.u32(16);
    header.u16(1);  // PCM
    header.u16(static_cast<std::uint16_t>(sound.channels));
    header.u32(static_cast<std::uint32_t>(sound.sample_rate));
    header.u32(static_cast<std::uint32_t>(sound.sample_rate * sound.channels * 2));
    header.u16(static_cast<std::uint16_t>(sound.channels * 2));
    header.u16(16);
    tag("data");
    header.u32(size);

    OutputFile file(path);
    file.write(header.view());
    Bytes pcm;
    pcm.reserve(sound.samples.size() * 2);
    for (const float sample : sound.samples) {
        const long value = std::clamp(std::lround(sample * 32768.0f), -32768l, 32767l);
        pcm.push_back(static_cast<std::byte>(value & 255));
        pcm.push_back(static_cast<std::byte>(value >> 8 & 255));
    }
    file.write(pcm);
    file.commit();
}

}  // namespace mien::io
