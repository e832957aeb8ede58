#pragma once

#include <functional>
#include <memory>

#include "encoder/live_motion.hpp"
#include "net/publisher.hpp"
#include "tools/frame_counter.hpp"
#include "tools/live_input.hpp"
#include "tools/live_recording.hpp"
#include "tools/training_take.hpp"

namespace mien::tools {

struct LiveOptions {
    std::string name;                             ///< of the stream, in its header
    std::optional<Rational> frame_rate;           ///< none: the training take's
    double group_seconds = 1;
    std::optional<net::Url> url;                  ///< where to publish; none: nowhere
    std::filesystem::path recording;              ///< empty: none
    std::chrono::milliseconds connect{10000};     ///< for the server to take the stream
    std::function<void(const net::SourceStatus&)> on_status;
};

/// Frames in, a live stream out: coded one by one, published, recorded, or both.
class LiveSession {
public:
    /// Errors: the server refuses the stream or does not answer. Throws EnvironmentError: the recording cannot be written.
    static Result<std::unique_ptr<LiveSession>> start(const StoredTake& take, const LiveOptions& options);

    /// Codes one frame and sends it at once. Frames that were lost before it are held, so that time goes on; errors leave the stream as it was.
    Result<void> add(const Captured& captured);
    /// Ends stream and recording.
    void finish();

    const protocol::StreamHeader& header() const { return header_; }
    encoder::LiveMotion::Figures figures() const { return motion_.figures(); }
    std::uint64_t lost() const { return lost_; }       ///< frames that never came
    std::uint64_t late() const { return late_; }       ///< frames that came late or twice
    const net::Publisher* publisher() const { return publisher_.get(); }

private:
    LiveSession(const StoredTake& take, const LiveOptions& options);
    Result<void> code(const encoder::MotionFrame& frame);

    encoder::LiveMotion motion_;
    protocol::StreamHeader header_;
    FrameCounter counter_;
    std::unique_ptr<net::Publisher> publisher_;
    std::optional<LiveRecording> recording_;
    protocol::Group group_;
    std::int64_t frame_ = 0;
    std::optional<encoder::MotionFrame> last_;
    std::uint64_t lost_ = 0, late_ = 0;
};

}  // namespace mien::tools
