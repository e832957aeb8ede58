#include <arpa/inet.h>
#include <fmt/core.h>
#include <netinet/in.h>
#include <sys/socket.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <chrono>
#include <cmath>
#include <cstring>
#include <thread>

#include "core/environment_error.hpp"
#include "core/frame_rate.hpp"
#include "io/clip_folder.hpp"
#include "io/frame_packet.hpp"
#include "io/live_link.hpp"
#include "io/rtp_packet.hpp"
#include "tools/commands.hpp"
#include "tools/console.hpp"
#include "tools/options.hpp"

namespace mien::tools {
namespace {

struct Request {
    std::string clip, address = "127.0.0.1", fps;
    std::uint16_t port = 0, sound_port = 0;
    bool loop = false, quiet = false;
};

class Sender {
public:
    Sender(const std::string& address, std::uint16_t port) {
        to_.sin_family = AF_INET;
        to_.sin_port = htons(port);
        if (::inet_pton(AF_INET, address.c_str(), &to_.sin_addr) != 1) throw EnvironmentError("'" + address + "' is not an IPv4 address");
        socket_ = ::socket(AF_INET, SOCK_DGRAM | SOCK_CLOEXEC, 0);
        if (socket_ < 0) throw EnvironmentError(std::string("no socket: ") + std::strerror(errno));
    }
    ~Sender() { ::close(socket_); }
    Sender(const Sender&) = delete;
    Sender& operator=(const Sender&) = delete;

    void send(ByteView packet) const {
        // Nobody listening is no mistake of ours: packets are lost, as they may be.
        if (::sendto(socket_, packet.data(), packet.size(), 0, reinterpret_cast<const sockaddr*>(&to_), sizeof to_) < 0 && errno != ECONNREFUSED)
            throw EnvironmentError(std::string("cannot send: ") + std::strerror(errno));
    }

private:
    sockaddr_in to_{};
    int socket_ = -1;
};

Bytes marker_packet(const Clip& clip, std::int64_t frame, std::uint32_t sequence) {
    const auto now = std::chrono::steady_clock::now().time_since_epoch();
    return io::encode(io::MarkerPacket{sequence, std::uint64_t(std::chrono::duration_cast<std::chrono::microseconds>(now).count()), clip.markers->frame(frame)});
}

Bytes weight_packet(const Clip& clip, std::int64_t frame, std::uint32_t sequence) {
    io::LiveLinkPacket packet{.device = "mien", .subject = clip.name.substr(0, 200), .frame = std::int32_t(sequence), .rate_numerator = std::int32_t(clip.frame_rate.num),
                              .rate_denominator = std::int32_t(clip.frame_rate.den)};
    std::copy_n(clip.weights->frame(frame), io::LiveLinkPacket::kWeights, packet.values.begin());
    const auto at = std::size_t(frame);
    float* angles = packet.values.data() + io::LiveLinkPacket::kWeights;
    if (at < clip.head_pose.size()) io::live_link_angles(clip.head_pose[at], angles);
    if (at < clip.gaze.size()) io::live_link_angles(clip.gaze[at], angles);
    return io::encode(packet);
}

using Clock = std::chrono::steady_clock;
Clock::time_point after(Clock::time_point begun, double seconds) { return begun + std::chrono::duration_cast<Clock::duration>(std::chrono::duration<double>(seconds)); }

/// Sound of 10 ms a packet, each when its last sample would have been captured; silence where the sound is shorter than the take.
void send_sound(const Sender& sender, const Sound& sound, double take_seconds, bool loop, Clock::time_point begun, const std::stop_token& stop) {
    const std::int64_t length = std::max<std::int64_t>(1, sound.sample_rate / 100), take = std::llround(take_seconds * sound.sample_rate);
    const auto channels = std::size_t(sound.channels);
    std::uint16_t number = 0;
    for (std::int64_t first = 0; (loop || first < take) && !stop.stop_requested(); first += length) {
        Sound part{sound.sample_rate, sound.channels, std::vector<float>(std::size_t(length) * channels)};
        for (std::int64_t i = 0; i < length; ++i) {
            const std::int64_t at = (first + i) % std::max<std::int64_t>(1, take);
            if (at < sound.length()) std::copy_n(sound.samples.begin() + at * sound.channels, channels, part.samples.begin() + i * sound.channels);
        }
        std::this_thread::sleep_until(after(begun, double(first + length) / sound.sample_rate));
        const Bytes payload = io::encode_l16(part);
        sender.send(io::encode(io::RtpPacket{96, number++, std::uint32_t(first), 0x6d69656e, payload}));
    }
}

Result<int> send(const Request& request) {
    io::LoadOptions load;
    load.progress = progress_bar(request.quiet);
    if (!request.fps.empty()) {
        MIEN_TRY(rate, parse_frame_rate(request.fps));
        load.frame_rate = rate;
    }
    MIEN_TRY(loaded, io::load_clip(request.clip, load));
    end_progress();
    for (const std::string& text : loaded.warnings) warn(text);
    const Clip& clip = loaded.clip;
    const bool markers = clip.markers.has_value();
    if (!markers && !(clip.weights && clip.weights->count == std::int64_t(io::LiveLinkPacket::kWeights)))
        return fail("the clip has neither markers nor the 52 weights that Live Link Face sends");
    if (markers && clip.markers->points > std::int64_t(io::MarkerPacket::kMaxMarkers))
        return fail(fmt::format("{} markers do not fit in a packet; {} do", clip.markers->points, io::MarkerPacket::kMaxMarkers));
    if (request.sound_port && !clip.sound) return fail("the clip has no sound");
    if (request.sound_port && clip.sound->channels > 2) return fail("the clip's sound has more than two channels");
    const Sender sender(request.address, request.port);
    std::optional<Sender> sound_sender;
    if (request.sound_port) sound_sender.emplace(request.address, request.sound_port);
    const std::int64_t frames = markers ? clip.markers->frames : clip.weights->frames;
    const double rate = clip.frame_rate.value();
    if (!request.quiet)
        fmt::print("{} frames of {} at {:g} Hz to {} port {}{}{}\n", frames, markers ? "markers" : "Live Link Face weights", rate, request.address, request.port,
                   sound_sender ? fmt::format(", sound of {}x{} to port {}", clip.sound->sample_rate, clip.sound->channels, request.sound_port) : "",
                   request.loop ? ", again and again" : "");
    std::fflush(stdout);
    const auto begun = Clock::now();
    std::jthread voice;
    if (request.sound_port)
        voice = std::jthread([&](const std::stop_token& stop) {
            try {
                send_sound(*sound_sender, *clip.sound, double(frames) / rate, request.loop, begun, stop);
            } catch (const EnvironmentError& error) {
                warn(error.what());
            }
        });
    for (std::uint32_t sent = 0; request.loop || sent < frames; ++sent) {
        std::this_thread::sleep_until(after(begun, sent / rate));
        sender.send(markers ? marker_packet(clip, sent % frames, sent) : weight_packet(clip, sent % frames, sent));
    }
    if (voice.joinable()) voice.join();   // the last frame's own length
    return kDone;
}

}  // namespace

void add_send(CLI::App& mien, int& code) {
    auto request = std::make_shared<Request>();
    CLI::App* command = mien.add_subcommand("send", "Play the markers or weights of a clip as UDP packets, as a capture system would, for mien live");
    command->add_option("clip", request->clip, "Clip folder, or a single recording")->required();
    command->add_option("--udp", request->port, "UDP port to send to")->required()->check(CLI::Range(1, 65535));
    command->add_option("--sound-udp", request->sound_port, "UDP port to send the clip's sound to, as RTP packets of L16")->check(CLI::Range(1, 65535));
    command->add_option("--to", request->address, "Address to send to")->capture_default_str();
    command->add_option("--fps", request->fps, "Frames per second, for clips that do not say")->check(frame_rate());
    command->add_flag("--loop", request->loop, "Start again at the end, until interrupted");
    command->add_flag("-q,--quiet", request->quiet, "No summary");
    command->callback([request, &code] { code = guarded([&] { return send(*request); }); });
}

}  // namespace mien::tools
