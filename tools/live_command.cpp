#include <fmt/core.h>
#include <unistd.h>

#include <atomic>
#include <filesystem>
#include <mutex>
#include <thread>

#include "core/frame_rate.hpp"
#include "core/interruption.hpp"
#include "tools/commands.hpp"
#include "tools/console.hpp"
#include "tools/live_session.hpp"
#include "tools/options.hpp"

namespace mien::tools {
namespace {

using Clock = std::chrono::steady_clock;

constexpr auto kWait = std::chrono::milliseconds(100);        // after which signals and the status line are looked at
constexpr auto kStatusEvery = std::chrono::milliseconds(500);

struct Request {
    std::string url, basis, output, bind = "127.0.0.1", fps, sound_format = "48000";
    std::optional<std::uint16_t> port, sound_port;
    double sound_kbps = 48;
    bool lines = false, overwrite = false, quiet = false;
    double group = 1;
};

/// What goes on, in one line that is written over again and again.
class StatusLine {
public:
    explicit StatusLine(bool quiet) : shown_(!quiet && isatty(STDERR_FILENO)) {}

    void show(const LiveSession& session, const LiveInput& input) {
        const auto now = Clock::now();
        if (!shown_ || now - since_ < kStatusEvery) return;
        const auto figures = session.figures();
        const double seconds = std::chrono::duration<double>(now - since_).count();
        const double rate = double(figures.frames - frames_) / seconds, kbits = double(figures.bytes - bytes_) * 8 / 1000 / seconds;
        since_ = now;
        frames_ = figures.frames;
        bytes_ = figures.bytes;
        const std::uint64_t dropped = session.publisher() ? session.publisher()->statistics().dropped : 0;
        fmt::print(stderr, "\r{:.1f} frames/s, {:.2f} kbit/s, error {:.4f} RMS, {} lost, {} late, {} refused, {} not sent\033[K", rate, kbits, figures.rms,
                   session.lost(), session.late(), input.refused(), dropped);
        std::fflush(stderr);
        open_ = true;
    }
    void end() {
        if (std::exchange(open_, false)) std::fputc('\n', stderr);
    }

private:
    const bool shown_;
    bool open_ = false;
    Clock::time_point since_ = Clock::now();
    std::int64_t frames_ = 0;
    std::uint64_t bytes_ = 0;
};

double steady_seconds() { return std::chrono::duration<double>(Clock::now().time_since_epoch()).count(); }

/// Takes sound as it comes and gives it to the session, on a thread of its own: frames and packets of sound do not wait for each other.
class SoundThread {
public:
    SoundThread(SoundInput& input, LiveSession& session)
        : input_(input), session_(session), thread_([this](const std::stop_token& stop) { run(stop); }) {}

    /// The first thing that was wrong, once.
    std::string trouble() {
        const std::lock_guard lock(mutex_);
        return std::exchange(trouble_, {});
    }
    std::int64_t packets() const { return packets_; }

private:
    void run(const std::stop_token& stop) {
        const auto say = [&](const std::string& what) {
            const std::lock_guard lock(mutex_);
            if (!std::exchange(said_, true)) trouble_ = what;
        };
        while (!stop.stop_requested()) {
            const auto captured = input_.next(kWait);
            if (captured) {
                const auto added = session_.add_sound(*captured, steady_seconds());
                added ? void(++packets_) : say(added.error().message);
            } else if (input_.refused() > 0) {
                say(input_.last_refusal());
            }
        }
    }

    SoundInput& input_;
    LiveSession& session_;
    std::atomic<std::int64_t> packets_{0};
    std::mutex mutex_;
    std::string trouble_;
    bool said_ = false;
    std::jthread thread_;
};

Result<LiveOptions> options_of(const Request& request) {
    LiveOptions options;
    if (!request.fps.empty()) {
        MIEN_TRY(rate, parse_frame_rate(request.fps));
        options.frame_rate = rate;
    }
    options.group_seconds = request.group;
    if (request.sound_port) {
        MIEN_TRY(format, parse_sound_format(request.sound_format));
        options.sound = encoder::LiveSoundOptions{format.sample_rate, format.channels, request.sound_kbps};
    }
    options.recording = request.output;
    options.name = std::filesystem::path(request.output).stem().string();
    if (request.url.empty()) return options;
    MIEN_TRY(url, net::parse_url(request.url));
    if (url.name.empty()) return Error{ErrorCode::invalid, request.url + " names a server but no stream; add /NAME"};
    options.name = url.name;
    options.url = std::move(url);
    return options;
}

Result<int> live(const Request& request) {
    if (request.url.empty() && request.output.empty()) return misused("nowhere to send it: give mien://HOST/NAME of a server that runs with --publish, -o FILE, or both");
    if (request.port.has_value() == request.lines) return misused("frames come either from --udp PORT or from --stdin");
    if (!request.output.empty()) MIEN_CHECK(may_write(request.output, request.overwrite, {request.basis}));
    MIEN_TRY(take, read_take(request.basis));
    MIEN_TRY(options, options_of(request));
    if (!request.lines && take.take.info.kind == protocol::MotionKind::weights && take.take.info.count != 52)
        return fail(fmt::format("Live Link Face sends 52 weights, but '{}' has {}", request.basis, take.take.info.count));
    const Rational rate = options.frame_rate.value_or(take.header.frame_rate);
    const std::unique_ptr<LiveInput> input = request.lines ? line_input(STDIN_FILENO, take.take.info) : udp_input(request.bind, *request.port, take.take.info, rate);

    std::optional<SoundInput> sound;
    if (options.sound) sound.emplace(request.bind, *request.sound_port, SoundFormat{options.sound->sample_rate, options.sound->channels});

    std::mutex mutex;
    std::string lost_connection;   // said by the loop, so that lines do not mix
    bool failed = false;
    options.on_status = [&](const net::SourceStatus& status) {
        const std::lock_guard lock(mutex);
        if (status.state == net::SourceState::reconnecting) lost_connection = "the connection is lost, trying again: " + status.reason;
        if (status.state == net::SourceState::failed) lost_connection = status.reason, failed = true;
    };
    const StopRequest stop;
    MIEN_TRY(session, LiveSession::start(take, options));
    if (!request.quiet) {
        // Scripts wait for this line.
        const std::string where = options.url ? net::to_string(*options.url) : request.output;
        fmt::print("live on {}: {} {} at {:g} Hz from {}{}\n", where, take.take.info.count, take.take.info.kind == protocol::MotionKind::markers ? "markers" : "weights",
                   rate.value(), input->name(), sound ? ", sound from " + sound->name() : "");
        std::fflush(stdout);
    }
    std::optional<SoundThread> listening;
    if (sound) listening.emplace(*sound, *session);
    StatusLine line(request.quiet);
    std::string first_refusal;
    bool broken = false;
    for (LiveInput::Got got = LiveInput::Got::nothing; !stop.asked() && got != LiveInput::Got::end;) {
        Captured captured;
        got = input->next(captured, kWait);
        if (got == LiveInput::Got::frame)
            if (const auto added = session->add(captured, steady_seconds()); !added && first_refusal.empty()) first_refusal = added.error().message;
        if (first_refusal.empty() && input->refused() > 0) first_refusal = input->last_refusal();
        if (!first_refusal.empty() && first_refusal[0] != '\0') {
            line.end();
            warn("some frames are left out: " + first_refusal);
            first_refusal = std::string(1, '\0');   // said once
        }
        if (listening)
            if (const std::string trouble = listening->trouble(); !trouble.empty()) line.end(), warn("some sound is left out: " + trouble);
        {
            const std::lock_guard lock(mutex);
            if (!lost_connection.empty()) line.end(), warn(std::exchange(lost_connection, {}));
            broken = failed;
        }
        if (broken && request.output.empty()) break;
        line.show(*session, *input);
    }
    line.end();
    const std::int64_t heard = listening ? listening->packets() : 0;
    listening.reset();
    if (sound && heard == 0) warn(fmt::format("no sound came from {}", sound->name()));
    const auto figures = session->figures();
    const std::uint64_t lost = session->lost(), late = session->late();
    session->finish();
    if (!request.quiet) {
        const double seconds = double(figures.frames) / rate.value();
        const double share = seconds > 0 ? 1 / seconds / 1000 : 0;
        const double bits = figures.pose_bits + figures.coefficient_bits, bytes = 8 * double(figures.bytes);
        fmt::print("{} frames, {}, {:.2f} kbit/s ({:.2f} of it pose), error {:.4f}{} RMS, {:.3f} at most, {} lost, {} late, {} refused\n", figures.frames,
                   human_time(seconds), bytes * share, bits > 0 ? figures.pose_bits / bits * bytes * share : 0.0, figures.rms,
                   take.take.info.kind == protocol::MotionKind::weights ? "" : " mm", figures.peak, lost, late, input->refused());
    }
    return broken ? fail("the stream could not go on") : kDone;
}

}  // namespace

void add_live(CLI::App& mien, int& code) {
    auto request = std::make_shared<Request>();
    CLI::App* command = mien.add_subcommand("live", "Encode frames as they are captured, publish them to a server, record them, or both");
    command->add_option("url", request->url, "mien://HOST[:PORT]/NAME of a server that runs with --publish");
    command->add_option("--basis", request->basis, "Stream file of a training take: motion basis and face model")->required()->check(CLI::ExistingFile);
    command->add_option("--udp", request->port, "UDP port that takes packets of markers or of Live Link Face (docs/live.md)")->check(CLI::Range(1, 65535));
    command->add_option("--bind", request->bind, "Address that takes them; 0.0.0.0 or :: hears the whole network")->capture_default_str();
    command->add_flag("--stdin", request->lines, "Frames as lines of numbers on standard input");
    CLI::Option* sound = command->add_option("--sound-udp", request->sound_port, "UDP port that takes sound as RTP packets of L16 (docs/live.md)")->check(CLI::Range(1, 65535));
    command->add_option("--sound-format", request->sound_format, "Samples per second of that sound, and channels if there are two: 44100x2")
        ->check([](const std::string& text) { return parse_sound_format(text) ? std::string() : parse_sound_format(text).error().message; })
        ->needs(sound)->capture_default_str();
    command->add_option("--sound-kbps", request->sound_kbps, "Sound bit rate, kbit/s")->check(number_from(6.0, 256.0))->needs(sound)->capture_default_str();
    command->add_option("-o,--output", request->output, "Stream file to record to");
    command->add_flag("-y,--overwrite", request->overwrite, "Overwrite the output file");
    command->add_option("--fps", request->fps, "Frames per second (default: the training take's)")->check(frame_rate());
    command->add_option("--group", request->group, "Seconds per group: viewers join at one")->check(number_from(0.1, 60.0))->capture_default_str();
    command->add_flag("-q,--quiet", request->quiet, "Say only what goes wrong");
    command->callback([request, &code] { code = guarded([&] { return live(*request); }); });
}

}  // namespace mien::tools
