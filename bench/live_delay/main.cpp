#include <arpa/inet.h>
#include <fmt/format.h>
#include <netinet/in.h>
#include <sys/socket.h>
#include <unistd.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <atomic>
#include <cmath>
#include <mutex>
#include <thread>
#include <utility>

#include "core/environment_error.hpp"
#include "io/clip_folder.hpp"
#include "io/frame_packet.hpp"
#include "io/rtp_packet.hpp"
#include "player/face_view.hpp"
#include "player/session.hpp"
#include "render/context.hpp"
#include "render/target.hpp"

/// How long a frame is under way: from the moment its packet of markers is sent to `mien live` to the moment a player has its coefficients, and to the moment
/// its picture is finished, by one clock. And sound: from the moment a sample would have been captured to the moment a player has it decoded.
namespace {

using namespace mien;
using Clock = std::chrono::steady_clock;
using namespace std::chrono_literals;

double seconds_now() { return std::chrono::duration<double>(Clock::now().time_since_epoch()).count(); }

class Socket {
public:
    explicit Socket(std::uint16_t port) : socket_(::socket(AF_INET, SOCK_DGRAM | SOCK_CLOEXEC, 0)) {
        to_.sin_family = AF_INET;
        to_.sin_port = htons(port);
        to_.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
    }
    Socket(Socket&& other) noexcept : socket_(std::exchange(other.socket_, -1)), to_(other.to_) {}
    ~Socket() {
        if (socket_ >= 0) ::close(socket_);
    }
    void send(ByteView packet) const { (void)::sendto(socket_, packet.data(), packet.size(), 0, reinterpret_cast<const sockaddr*>(&to_), sizeof to_); }

private:
    int socket_;
    sockaddr_in to_{};
};

double percentile(std::vector<double>& sorted, double p) { return sorted[std::min(sorted.size() - 1, std::size_t(p * double(sorted.size())))]; }

void tell(const std::string& what, std::vector<double> delays) {
    std::ranges::sort(delays);
    fmt::print("{}: median {:.2f} ms, 90 % {:.2f}, 99 % {:.2f}, largest {:.2f}\n", what, percentile(delays, 0.5), percentile(delays, 0.9), percentile(delays, 0.99),
               delays.back());
}

struct Size {
    int width = 0, height = 0;
};

/// Draws frames as the player's window would, each picture finished before the next is begun.
class Screen {
public:
    Screen(const player::StreamModel& stream, Size size) : size_(size), face_(stream), target_(size.width, size.height, render::live_smoothing()) {}
    void draw(const player::PlayFrame& frame) {
        face_.show(frame);
        face_.draw(face_.framing(float(size_.width) / float(size_.height), render::View::front).camera(), {}, target_);
        target_.wait();
    }
    std::string name() const { return fmt::format("{} x {}, {}", size_.width, size_.height, render::renderer_name()); }

private:
    Size size_;
    render::OffscreenContext context_;
    player::FaceView face_;
    render::Target target_;
};

/// Decoded sound as it comes.
struct Ears {
    struct Heard {
        double end = 0, at = 0;   // of the stream, and steady: seconds
    };
    std::mutex mutex;
    std::vector<Heard> heard;
    std::atomic<bool> open{false};
    void hear(const decoder::SoundDecoder::Block& block) {
        if (!open) return;
        const std::lock_guard lock(mutex);
        heard.push_back({double(block.first_sample + block.sound.length()) / block.sound.sample_rate, seconds_now()});
    }
};

Result<int> measure(const std::string& url, const std::string& folder, std::uint16_t port, std::optional<std::uint16_t> sound_port, double rate, double seconds,
                    std::optional<Size> size) {
    MIEN_TRY(loaded, io::load_clip(folder));
    if (!loaded.clip.markers) return Error{ErrorCode::missing, "the clip has no markers"};
    const PointSequence& markers = *loaded.clip.markers;
    Ears ears;
    player::SessionOptions options;
    options.sound = sound_port.has_value();
    options.sound_sink = [&](const player::StreamModel&) { return [&](decoder::SoundDecoder::Block block) { ears.hear(block); }; };
    MIEN_TRY(session, player::open_session(url, options));
    if (sound_port && !session.stream->sound) return Error{ErrorCode::missing, "the stream has no sound: start mien live with --sound-udp"};
    session.decode->start();
    const Socket socket(port);
    // What lies in the clip goes to and fro, so that no motion jumps.
    const auto packet = [&](std::uint32_t sequence) {
        const std::int64_t turn = std::max<std::int64_t>(1, 2 * (markers.frames - 1)), at = std::int64_t(sequence) % turn;
        return io::encode(io::MarkerPacket{sequence, 0, markers.frame(at < markers.frames ? at : turn - at)});
    };
    const auto next = [&](double patience) {
        const double until = seconds_now() + patience;
        return session.decode->wait_pop([&] { return seconds_now() > until; });
    };
    while (next(0.5)) {}   // of a sender before us
    std::optional<player::PlayFrame> first;
    for (int i = 0; i < 50 && !first; ++i) {
        socket.send(packet(0));
        first = next(0.1);
    }
    if (!first) return Error{ErrorCode::unavailable, "no frame came back: is mien live taking packets on this port and publishing there?"};
    const std::int64_t base = first->frame;
    std::optional<Screen> screen;
    if (size) {
        screen.emplace(*session.stream, *size);
        for (int i = 0; i < 3; ++i) screen->draw(*first);   // the first pictures also pay for compiling shaders
        while (next(0.2)) {}
    }

    const auto count = std::uint32_t(seconds * rate);
    std::vector<std::atomic<double>> sent(count + 1);
    const auto begun = Clock::now() + 100ms;
    std::jthread voice;
    if (sound_port) {
        ears.open = true;
        voice = std::jthread([&, to = Socket(*sound_port)](const std::stop_token& stop) {
            Sound hum{48000, 1, std::vector<float>(480)};
            for (std::size_t i = 0; i < hum.samples.size(); ++i) hum.samples[i] = 0.2f * std::sin(float(i) * 0.0654498f);   // five turns
            const Bytes payload = io::encode_l16(hum);
            for (std::uint32_t p = 0; !stop.stop_requested(); ++p) {
                std::this_thread::sleep_until(begun + 10ms * (p + 1));
                to.send(io::encode(io::RtpPacket{96, std::uint16_t(p), 480 * p, 1, payload}));
            }
        });
    }
    std::thread sender([&] {
        for (std::uint32_t s = 1; s <= count; ++s) {
            std::this_thread::sleep_until(begun + std::chrono::duration_cast<Clock::duration>(std::chrono::duration<double>(s / rate)));
            const Bytes bytes = packet(s);
            sent[s] = seconds_now();
            socket.send(bytes);
        }
    });
    std::vector<double> delays, pictures;
    player::PlayFrame shown;
    const double give_up = seconds_now() + seconds + 3;
    for (;;) {
        auto frame = session.decode->wait_pop([&] { return seconds_now() > give_up; });
        if (!frame) break;
        std::optional<std::size_t> newest;
        for (; frame; frame = screen ? session.decode->pop() : std::nullopt) {   // who draws shows the newest
            const std::int64_t sequence = frame->frame - base;
            if (sequence < 1 || sequence > count) continue;
            newest = std::size_t(sequence);
            delays.push_back(1000 * (frame->decoded_at - sent[*newest]));
            shown = std::move(*frame);
        }
        if (!newest) continue;
        if (screen) {
            screen->draw(shown);
            pictures.push_back(1000 * (seconds_now() - sent[*newest]));
        }
        if (*newest == count) break;
    }
    sender.join();
    if (delays.empty()) return Error{ErrorCode::unavailable, "no frame came back"};
    tell(fmt::format("{} of {} frames at {:g} Hz, to coefficients", delays.size(), count, rate), delays);
    if (sound_port) {
        voice.request_stop();
        voice.join();
        // Frame `base` + s is of begun + s / rate: so that is when a moment of the stream was captured.
        const double zero = std::chrono::duration<double>(begun.time_since_epoch()).count() - double(base) / session.stream->frame_rate.value();
        std::vector<double> late;
        const std::lock_guard lock(ears.mutex);
        for (const Ears::Heard& heard : ears.heard) late.push_back(1000 * (heard.at - (zero + heard.end)));
        if (late.empty()) return Error{ErrorCode::unavailable, "no sound came back"};
        tell(fmt::format("{} packets of sound of 10 ms, from the capture of the last sample by the pictures' clock to decoded samples", late.size()), late);
    }
    if (!pictures.empty()) tell(fmt::format("{} pictures of {}, to the finished picture", pictures.size(), screen->name()), pictures);
    return 0;
}

}  // namespace

int main(int argc, char** argv) {
    CLI::App app("mien-live-delay: time from a packet of markers to the coefficients in a player, and to its picture. Start mien-serve --publish and mien live --udp PORT first.");
    std::string url, clip, size_text;
    std::optional<Size> size;
    std::uint16_t port = 0;
    std::optional<std::uint16_t> sound_port;
    double rate = 60, seconds = 30;
    app.add_option("url", url, "mien://HOST[:PORT]/NAME that mien live publishes")->required();
    app.add_option("clip", clip, "Clip folder whose markers are sent")->required();
    app.add_option("--udp", port, "Port that mien live listens on")->required();
    app.add_option("--sound-udp", sound_port, "Port that mien live takes sound on: sends a hum there, and measures that too");
    app.add_option("--fps", rate, "Packets per second")->check(CLI::PositiveNumber)->capture_default_str();
    app.add_option("--seconds", seconds, "How long")->check(CLI::PositiveNumber)->capture_default_str();
    app.add_option("--size", size_text, "WxH: draws what comes, without a window, and measures to the finished picture too")->check([&](const std::string& text) -> std::string {
        Size wanted;
        char rest = 0;
        if (std::sscanf(text.c_str(), "%dx%d%c", &wanted.width, &wanted.height, &rest) != 2 || wanted.width < 16 || wanted.height < 16 || wanted.width > 8192 ||
            wanted.height > 8192)
            return "a size is WxH, each 16 to 8192, as in 640x360";
        size = wanted;
        return {};
    });
    CLI11_PARSE(app, argc, argv);
    try {
        const auto code = measure(url, clip, port, sound_port, rate, seconds, size);
        if (code.ok()) return *code;
        fmt::print(stderr, "mien-live-delay: {}\n", code.error().message);
    } catch (const EnvironmentError& error) {
        fmt::print(stderr, "mien-live-delay: {}\n", error.what());
    }
    return 1;
}
