#pragma once

#include <deque>
#include <functional>
#include <memory>
#include <mutex>

#include "core/arrival_clock.hpp"
#include "encoder/live_motion.hpp"
#include "encoder/live_sound.hpp"
#include "net/publisher.hpp"
#include "tools/frame_counter.hpp"
#include "tools/live_input.hpp"
#include "tools/live_recording.hpp"
#include "tools/sound_input.hpp"
#include "tools/training_take.hpp"

namespace mien::tools {

struct LiveOptions {
    std::string name;                             ///< of the stream, in its header
    std::optional<Rational> frame_rate;           ///< none: the training take's
    double group_seconds = 1;
    std::optional<net::Url> url;                  ///< where to publish; none: nowhere
    std::filesystem::path recording;              ///< empty: none
    std::optional<encoder::LiveSoundOptions> sound;   ///< none: motion alone
    std::chrono::milliseconds connect{10000};     ///< for the server to take the stream
    std::function<void(const net::SourceStatus&)> on_status;
};

/// Frames in, a live stream out: coded one by one, published, recorded, or both; and sound with them.
class LiveSession {
public:
    /// Errors: the server refuses the stream or does not answer. Throws EnvironmentError: the recording cannot be written.
    static Result<std::unique_ptr<LiveSession>> start(const StoredTake& take, const LiveOptions& options);

    /// Codes one frame and sends it at once. Frames that were lost before it are held, so that time goes on; errors leave the stream as it was. `now`:
    /// steady seconds at which it came.
    Result<void> add(const Captured& captured, double now);
    /// Codes sound that has just been captured and sends every packet that is full. What is heard and what is seen belong together as they arrive. Before the first
    /// frame there is nothing to hear. Another thread may call this. Only with options.sound.
    Result<void> add_sound(const CapturedSound& captured, double now);
    /// Ends stream and recording.
    void finish();

    const protocol::StreamHeader& header() const { return header_; }
    encoder::LiveMotion::Figures figures() const { return std::lock_guard(mutex_), motion_.figures(); }
    std::uint64_t lost() const { return std::lock_guard(mutex_), lost_; }       ///< frames that never came
    std::uint64_t late() const { return std::lock_guard(mutex_), late_; }       ///< frames that came late or twice
    const net::Publisher* publisher() const { return publisher_.get(); }

private:
    LiveSession(const StoredTake& take, const LiveOptions& options, std::optional<encoder::LiveSound> sound);
    Result<void> code(const encoder::MotionFrame& frame);
    void take(encoder::LiveSound::Packet packet, double zero);
    void start_sound_group(std::uint32_t number);
    void record();

    mutable std::mutex mutex_;                         ///< of everything below
    encoder::LiveMotion motion_;
    protocol::StreamHeader header_;
    FrameCounter counter_;
    std::unique_ptr<net::Publisher> publisher_;
    std::optional<LiveRecording> recording_;
    protocol::Group group_;
    std::int64_t frame_ = 0;
    std::optional<encoder::MotionFrame> last_;
    std::uint64_t lost_ = 0, late_ = 0;
    ArrivalClock arrivals_;                            ///< of frames

    std::optional<encoder::LiveSound> sound_;
    ArrivalClock sound_arrivals_;                      ///< of the sender's samples
    std::deque<Bytes> before_;                         ///< the last packets, as many as a decoder swallows
    protocol::Group sound_group_;
    std::int64_t sound_time_ = 0;                      ///< of the next packet, ticks
    bool sound_astray_ = true;                         ///< its time is found anew with the next group
};

}  // namespace mien::tools
