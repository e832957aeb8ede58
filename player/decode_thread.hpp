#pragma once

#include <array>
#include <atomic>
#include <condition_variable>
#include <functional>
#include <mutex>
#include <thread>

#include "player/group_decoder.hpp"
#include "player/jitter_buffer.hpp"
#include "player/live_clock.hpp"
#include "player/live_decoder.hpp"
#include "protocol/limits.hpp"

namespace mien::player {

/// Pulls groups from a source, decodes them and fills the jitter buffer, on a thread of its own. Every wait is bounded by
/// the buffer's room and by what waits undecoded, so memory is bounded however long the stream is.
class DecodeThread {
public:
    using SoundSink = std::function<void(decoder::SoundDecoder::Block block)>;

    /// delay: seconds that frames of a live stream wait to be shown evenly. `source` and `stream` outlive it. `on_sound` is called from the decode thread, in order of time. Nothing is read until
    /// start() or seek().
    DecodeThread(net::StreamSource& source, StreamModel& stream, SoundSink on_sound, double delay = 0);
    ~DecodeThread();

    /// Which slots the source gives from its next group on. What of them does not come is noted as damage.
    void select(std::uint64_t slots);
    /// Begins where the source does; frames before `first_frame` are left out.
    void start(std::int64_t first_frame = 0);
    /// Goes on from `seconds`: everything decoded is dropped. Between the last block of sound from before and the first from
    /// after, `quiet` is called: the place to empty what the sink has filled. With `slots`, these are given from there on, and nothing of them
    /// is looked for in what was on its way.
    void seek(double seconds, const std::function<void()>& quiet = {}, std::optional<std::uint64_t> slots = {});
    /// Which frame the clock is at; the decoder gives up groups that fall behind it. Negative: never give up.
    void set_due(std::int64_t frame) { due_ = frame; }

    std::optional<PlayFrame> take(std::int64_t due);    ///< JitterBuffer::take
    /// Of a live stream: the newest that is due. `heard`: seconds of the sound that leaves the loudspeaker now.
    std::optional<PlayFrame> take_live(double now, std::optional<double> heard = {});
    std::optional<PlayFrame> pop();                     ///< JitterBuffer::pop
    /// Waits for the next frame in order; none at the end, or when `give_up` answers true (asked a few times a second).
    std::optional<PlayFrame> wait_pop(const std::function<bool()>& give_up);
    bool ready() const;
    bool empty() const;
    bool drained() const;                       ///< the stream has ended and every frame was taken; live: until it goes on
    bool starved() const;                       ///< nothing to decode either: the source is behind
    std::size_t buffered() const;
    std::uint64_t dropped() const;
    std::uint64_t decoded() const { return decoded_; }
    std::uint64_t damaged_groups() const { return damaged_; }
    const DamageLog& damage() const { return damage_; }                        ///< of a recording
    std::uint64_t bytes_of(std::uint8_t slot) const { return bytes_[slot]; }   ///< of objects, without framing

private:
    void run();
    void run_live();
    void push_live(PlayFrame frame, std::uint32_t generation);
    void pull();
    void restart();
    void sound(decoder::SoundDecoder::Block block, std::uint32_t generation);
    void heard(const decoder::SoundDecoder::Block& block);
    void note_missing_end();
    void push(PlayFrame frame, std::uint32_t generation);

    net::StreamSource& source_;
    StreamModel& stream_;
    SoundSink on_sound_;
    DamageLog damage_;
    GroupDecoder groups_;                       // decode thread only
    LiveDecoder live_;                          // likewise

    double sound_end_ = 0;                      // likewise: seconds up to which sound has come since the last restart

    mutable std::mutex mutex_;
    std::condition_variable changed_;
    JitterBuffer buffer_;
    LiveClock live_clock_;
    std::int64_t last_live_ = -1;               // frame of a live stream
    std::uint32_t generation_ = 0;              // of the source, since the last seek
    std::optional<std::int64_t> restart_;       // first frame wanted by a seek that the thread has not seen
    bool idle_ = true;                          // until start() or seek()
    bool stopping_ = false;
    bool starved_ = true;
    std::mutex sound_mutex_;                    // held while on_sound_ runs, so that a seek can wait for it
    std::array<std::atomic<std::uint64_t>, protocol::kMaxSlots> bytes_{};
    std::atomic<std::uint64_t> slots_{~std::uint64_t(0)};
    std::atomic<std::int64_t> due_{-1};
    std::atomic<std::uint64_t> decoded_{0}, damaged_{0}, skipped_{0};
    std::thread thread_;
};

}  // namespace mien::player
