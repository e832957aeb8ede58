#pragma once

#include <chrono>
#include <cstdint>
#include <optional>
#include <string>

#include "core/image.hpp"
#include "core/result.hpp"
#include "io/rtp_packet.hpp"
#include "tools/udp_listener.hpp"

namespace mien::tools {

/// How captured sound comes.
struct SoundFormat {
    int sample_rate = 48000, channels = 1;
};
/// "48000", "44100x2". Errors: invalid for rates outside 8000 .. 192000 and more than two channels.
Result<SoundFormat> parse_sound_format(const std::string& text);

/// Samples as they arrived.
struct CapturedSound {
    std::int64_t first = 0;   ///< the sender's count of samples before these; any zero
    Sound sound;
};

/// What of a sender's 32-bit timestamps a packet's is, counted on for ever. A new sender, or one that has begun anew, counts on two seconds after the last one:
/// so far apart that nobody takes it for the same sound.
class SampleCounter {
public:
    explicit SampleCounter(int sample_rate) : sample_rate_(sample_rate) {}
    std::int64_t count(const io::RtpPacket& packet, std::int64_t samples);

private:
    const int sample_rate_;
    std::optional<std::uint32_t> source_;
    std::uint32_t timestamp_ = 0;   // of the last packet
    std::int64_t at_ = 0, end_ = 0; // where it began, and the farthest that any went
};

/// RTP packets of L16 on a port (RFC 3551): payload types 10 and 11 are 44 100 Hz, 2 and 1 channels; those from 96 on are as `format` says.
class SoundInput {
public:
    /// Throws EnvironmentError: address or port not to be had.
    SoundInput(const std::string& bind, std::uint16_t port, SoundFormat format) : format_(format), counter_(format.sample_rate), socket_(bind, port) {}

    /// Waits up to `longest`; none: nothing came, or nothing that could be used.
    std::optional<CapturedSound> next(std::chrono::milliseconds longest);
    const std::string& name() const { return socket_.name(); }
    std::uint64_t refused() const { return refused_; }
    const std::string& last_refusal() const { return last_refusal_; }

private:
    Result<CapturedSound> take(ByteView bytes);

    SoundFormat format_;
    SampleCounter counter_;
    UdpListener socket_;
    std::uint64_t refused_ = 0;
    std::string last_refusal_;
};

}  // namespace mien::tools
