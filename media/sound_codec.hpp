#pragma once

#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include "core/hash.hpp"
#include "core/image.hpp"
#include "core/result.hpp"

namespace mien::media {

/// What one encoder run over a whole sound gives. Packet i, decoded after enough packets before it, is
/// samples
/// [(i - preroll_packets) * packet_samples, ... + packet_samples) of the sound: the encoder's delay is taken
/// out.
struct SoundPackets {
    int sample_rate = 48000;  ///< of the packets, Hz
    int channels = 1;
    std::int64_t samples = 0;  ///< of the sound at that rate, per channel; the last packet may pass its end
    int packet_samples = 960;
    int preroll_packets = 0;  ///< packets a decoder must swallow before its output is right
    Bytes codec_config;
    std::vector<Bytes> packets;
};

/// "opus": libopus, 48 kHz, 20 ms packets, 80 ms pre-roll (RFC 7845, 4.6). "aac": AAC-LC of 1024 samples, one
/// packet of pre-roll; keeps the sound's rate where AAC has it. One to eight channels.
Result<SoundPackets> compress_sound(const Sound& sound, const std::string& codec, double kbps);

/// Sound at another rate, by libswresample; sample 0 stays sample 0 and the length is rounded to nearest.
Result<Sound> resample(const Sound& sound, int sample_rate);

/// resample() for sound that comes bit by bit. The first samples come after the filter's half, a millisecond or
/// less.
class SoundResampler {
public:
    static Result<SoundResampler> open(int channels, int from, int to);
    SoundResampler(SoundResampler&&) noexcept;
    SoundResampler& operator=(SoundResampler&&) noexcept;
    ~SoundResampler();
    /// Appends what can be said so far, interleaved.
    Result<void> add(const std::vector<float>& samples, std::vector<float>& resampled);

private:
    struct State;
    explicit SoundResampler(std::unique_ptr<State> state);
    std::unique_ptr<State> state_;
};

/// Encodes sound while it is made: Opus of 48 kHz in its low-delay mode, one packet of 10 ms for each 480 samples. One
/// or two channels. Not thread-safe.
class PacketSoundEncoder {
public:
    static constexpr int kSampleRate = 48000, kPacketSamples = 480;
    static Result<PacketSoundEncoder> open(int channels, double kbps);
    PacketSoundEncoder(PacketSoundEncoder&&) noexcept;
    PacketSoundEncoder& operator=(PacketSoundEncoder&&) noexcept;
    ~PacketSoundEncoder();

    const Bytes& codec_config() const;
    /// Samples by which what a decoder gives of a packet is earlier than what the packet was made of.
    int delay() const;
    /// `samples`: kPacketSamples x channels, interleaved.
    Result<Bytes> encode(const float* samples);

private:
    struct State;
    explicit PacketSoundEncoder(std::unique_ptr<State> state);
    std::unique_ptr<State> state_;
};

/// Turns packets into PCM, sample for sample. Not thread-safe.
class PacketSoundDecoder {
public:
    static Result<PacketSoundDecoder> open(const std::string& codec, ByteView codec_config, int sample_rate,
                                           int channels);
    PacketSoundDecoder(PacketSoundDecoder&&) noexcept;
    PacketSoundDecoder& operator=(PacketSoundDecoder&&) noexcept;
    ~PacketSoundDecoder();

    /// Forgets everything.
    void restart();
    /// Appends what `packet` decodes to, interleaved. Refuses a packet that changes rate or channels.
    Result<void> decode(ByteView packet, std::vector<float>& samples);

private:
    struct State;
    explicit PacketSoundDecoder(std::unique_ptr<State> state);
    std::unique_ptr<State> state_;
};

}  // namespace mien::media
