#pragma once

#include <memory>

#include "core/image.hpp"
#include "core/result.hpp"
#include "protocol/stream.hpp"

namespace mien::decoder {

/// Turns the packets of a sound track into PCM. Not thread-safe.
class SoundDecoder {
public:
    static Result<SoundDecoder> create(const protocol::Track& track, const protocol::Rung& rung);
    SoundDecoder(SoundDecoder&&) noexcept;
    SoundDecoder& operator=(SoundDecoder&&) noexcept;
    ~SoundDecoder();

    /// Interleaved PCM of one whole group, and the time of its first sample. A group decodes without any
    /// earlier one: its pre-roll packets are swallowed.
    struct Block {
        std::int64_t first_sample = 0;  ///< since the start of the sound
        Sound sound;
    };
    Result<Block> decode(const protocol::Group& group);

    /// For packets that come one by one: forgets those before; decodes the next. Errors leave it as after
    /// restart().
    void restart();
    Result<Sound> next(ByteView packet);
    std::size_t preroll_packets() const;
    std::uint32_t packet_samples() const;

private:
    struct State;
    explicit SoundDecoder(std::unique_ptr<State> state);
    std::unique_ptr<State> state_;
};

}  // namespace mien::decoder
