#include "tools/live_input.hpp"

#include <fmt/format.h>
#include <poll.h>
#include <unistd.h>

#include <cerrno>
#include <cmath>
#include <limits>

#include "io/frame_packet.hpp"
#include "io/live_link.hpp"
#include "io/text.hpp"
#include "tools/udp_listener.hpp"

namespace mien::tools {

namespace {

constexpr std::size_t kMaxLine = 4u << 20;              // bytes: 65 536 markers of 60 characters

bool readable(int descriptor, std::chrono::milliseconds longest) {
    pollfd waiting{descriptor, POLLIN, 0};
    return ::poll(&waiting, 1, int(longest.count())) > 0;
}

class UdpInput final : public LiveInput {
public:
    UdpInput(const std::string& bind, std::uint16_t port, const protocol::MotionInfo& info, Rational rate) : info_(info), rate_(rate), socket_(bind, port) {}

    Got next(Captured& captured, std::chrono::milliseconds longest) override {
        const auto packet = socket_.next(longest);
        if (!packet) return Got::nothing;
        if (!socket_.welcome()) return refuse("another sender sends here too"), Got::nothing;
        const auto taken = take(*packet, captured);
        if (!taken) return refuse(taken.error().message), Got::nothing;
        socket_.hear();
        return Got::frame;
    }
    std::string name() const override { return socket_.name(); }

private:
    Result<void> take(ByteView packet, Captured& captured) const {
        if (info_.kind == protocol::MotionKind::markers) {
            MIEN_TRY(markers, io::parse_marker_packet(packet));
            if (markers.markers.rows() != std::int64_t(info_.count))
                return Error{ErrorCode::mismatch, fmt::format("a packet of {} markers; the basis has {}", markers.markers.rows(), info_.count)};
            captured = {{Eigen::Map<const Eigen::VectorXf>(markers.markers.data(), markers.markers.size()), {}, {}}, markers.sequence};
            return {};
        }
        if (io::is_marker_packet(packet)) return Error{ErrorCode::mismatch, "a packet of markers; the basis is one of weights"};
        MIEN_TRY(face, io::parse_live_link_packet(packet));
        captured = {frame_of(face.values.data()), std::uint32_t(std::llround(face.seconds() * rate_.value()))};
        return {};
    }

    const protocol::MotionInfo info_;
    const Rational rate_;
    UdpListener socket_;
};

class LineInput final : public LiveInput {
public:
    LineInput(int descriptor, const protocol::MotionInfo& info)
        : descriptor_(descriptor), numbers_(info.count * (info.kind == protocol::MotionKind::weights ? 1 : 3)) {}

    Got next(Captured& captured, std::chrono::milliseconds longest) override {
        for (;;) {
            const std::size_t end = text_.find('\n', at_);
            if (end != std::string::npos) {
                const std::string_view line = std::string_view(text_).substr(at_, end - at_);
                at_ = end + 1;
                if (take(line, captured)) return Got::frame;
                continue;
            }
            if (ended_) {
                const std::string rest = std::exchange(text_, {}).substr(at_);
                at_ = 0;
                return !rest.empty() && take(rest, captured) ? Got::frame : Got::end;
            }
            text_.erase(0, std::exchange(at_, 0));
            if (text_.size() > kMaxLine) {
                refuse(fmt::format("a line of more than {} bytes", kMaxLine));
                text_.clear();
            }
            if (!readable(descriptor_, longest)) return Got::nothing;
            char chunk[65536];
            const ssize_t got = ::read(descriptor_, chunk, sizeof chunk);
            if (got < 0 && errno == EINTR) return Got::nothing;
            if (got <= 0) ended_ = true;
            else text_.append(chunk, std::size_t(got));
        }
    }
    std::string name() const override { return "standard input"; }

private:
    bool take(std::string_view line, Captured& captured) {
        const bool first = std::exchange(first_, false);
        if (io::trimmed(line).empty()) return false;
        const auto fields = io::split(line, ',');
        if (fields.size() != numbers_) return refuse(fmt::format("a line of {} numbers; the basis has {}", fields.size(), numbers_)), false;
        captured = {};
        captured.frame.values.resize(Eigen::Index(numbers_));
        for (std::size_t i = 0; i < numbers_; ++i) {
            const auto value = fields[i].empty() ? std::optional(std::numeric_limits<double>::quiet_NaN()) : io::parse_double(fields[i]);
            if (!value && !first) refuse(fmt::format("'{}' is no number", fields[i].substr(0, 40)));
            if (!value) return false;
            captured.frame.values[Eigen::Index(i)] = float(*value);
        }
        return true;
    }

    const int descriptor_;
    const std::size_t numbers_;
    std::string text_;
    std::size_t at_ = 0;
    bool ended_ = false, first_ = true;
};

}  // namespace

encoder::MotionFrame frame_of(const float* values) {
    constexpr int weights = int(io::LiveLinkPacket::kWeights);
    return {Eigen::Map<const Eigen::VectorXf>(values, weights), io::live_link_pose(values + weights), io::live_link_gaze(values + weights)};
}

std::unique_ptr<LiveInput> udp_input(const std::string& bind, std::uint16_t port, const protocol::MotionInfo& info, Rational frame_rate) {
    return std::make_unique<UdpInput>(bind, port, info, frame_rate);
}

std::unique_ptr<LiveInput> line_input(int descriptor, const protocol::MotionInfo& info) { return std::make_unique<LineInput>(descriptor, info); }

}  // namespace mien::tools
