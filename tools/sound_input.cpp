#include "tools/sound_input.hpp"

#include <fmt/format.h>

#include <algorithm>

#include "io/text.hpp"

namespace mien::tools {

Result<SoundFormat> parse_sound_format(const std::string& text) {
    const auto parts = io::split(text, 'x');
    const auto rate = io::parse_integer(parts[0]), channels = parts.size() > 1 ? io::parse_integer(parts[1]) : std::optional<std::int64_t>(1);
    if (parts.size() > 2 || !rate || !channels || *rate < 8000 || *rate > 192'000 || *channels < 1 || *channels > 2)
        return Error{ErrorCode::invalid, fmt::format("'{}' is no form of sound; 48000 or 44100x2 are: samples per second, and 1 or 2 channels", text)};
    return SoundFormat{int(*rate), int(*channels)};
}

std::int64_t SampleCounter::count(const io::RtpPacket& packet, std::int64_t samples) {
    const std::int64_t step = static_cast<std::int32_t>(packet.timestamp - timestamp_);
    const bool follows = source_ == packet.source && step > -std::int64_t(sample_rate_) && step < 10 * std::int64_t(sample_rate_);
    at_ = follows ? at_ + step : source_ ? end_ + 2 * std::int64_t(sample_rate_) : 0;
    source_ = packet.source;
    timestamp_ = packet.timestamp;
    end_ = std::max(end_, at_ + samples);
    return at_;
}

std::optional<CapturedSound> SoundInput::next(std::chrono::milliseconds longest) {
    const auto packet = socket_.next(longest);
    if (!packet) return std::nullopt;
    const auto refuse = [&](std::string why) {
        ++refused_;
        last_refusal_ = std::move(why);
        return std::nullopt;
    };
    if (!socket_.welcome()) return refuse("another sender sends sound here too");
    auto captured = take(*packet);
    if (!captured) return refuse(captured.error().message);
    socket_.hear();
    return std::move(*captured);
}

Result<CapturedSound> SoundInput::take(ByteView bytes) {
    MIEN_TRY(packet, io::parse_rtp(bytes));
    SoundFormat format = format_;
    if (packet.payload_type == 10 || packet.payload_type == 11) format = {44100, packet.payload_type == 10 ? 2 : 1};
    else if (packet.payload_type < 96) return Error{ErrorCode::mismatch, fmt::format("RTP of payload type {} is no L16 sound", packet.payload_type)};
    if (format.sample_rate != format_.sample_rate || format.channels != format_.channels)
        return Error{ErrorCode::mismatch, fmt::format("RTP of payload type {} is sound of {}x{}; --sound-format says {}x{}", packet.payload_type, format.sample_rate,
                                                      format.channels, format_.sample_rate, format_.channels)};
    MIEN_TRY(sound, io::parse_l16(packet.payload, format.sample_rate, format.channels));
    const std::int64_t first = counter_.count(packet, sound.length());
    return CapturedSound{first, std::move(sound)};
}

}  // namespace mien::tools
