#pragma once

#include <chrono>
#include <memory>
#include <optional>
#include <string>

#include "core/rational.hpp"
#include "encoder/frame_projector.hpp"
#include "protocol/stream.hpp"

namespace mien::tools {

/// One frame as it arrived.
struct Captured {
    encoder::MotionFrame frame;
    std::optional<std::uint32_t> sequence;   ///< its number at the stream's frame rate, when the source counts
};

/// Where live frames come from.
class LiveInput {
public:
    virtual ~LiveInput() = default;
    enum class Got { frame, nothing, end };
    /// Waits up to `longest` (and not longer than a signal lets it).
    virtual Got next(Captured& captured, std::chrono::milliseconds longest) = 0;
    virtual std::string name() const = 0;

    std::uint64_t refused() const { return refused_; }             ///< packets or lines that are no frame
    const std::string& last_refusal() const { return last_refusal_; }

protected:
    void refuse(std::string why) {
        ++refused_;
        last_refusal_ = std::move(why);
    }

private:
    std::uint64_t refused_ = 0;
    std::string last_refusal_;
};

/// Packets of markers (for `info` of markers) or of Live Link Face (for 52 weights), io/frame_packet.hpp, from one sender at a time: another one is
/// heard when the first has been silent for two seconds. Throws EnvironmentError: address or port not to be had.
std::unique_ptr<LiveInput> udp_input(const std::string& bind, std::uint16_t port, const protocol::MotionInfo& info, Rational frame_rate);

/// Standard input: a line for each frame, numbers between commas, x y z of every marker (empty or nan: missing) or all weights; a first line of names is
/// passed over.
std::unique_ptr<LiveInput> line_input(int descriptor, const protocol::MotionInfo& info);

/// A frame of a Live Link Face packet's values.
encoder::MotionFrame frame_of(const float* values);

}  // namespace mien::tools
