#include "player/window.hpp"

// epoxy-free: everything OpenGL is in the render room and in Dear ImGui.
#define GLFW_INCLUDE_NONE
#include <GLFW/glfw3.h>
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <future>

#include "core/environment_error.hpp"
#include "core/interruption.hpp"
#include "io/image_file.hpp"
#include "net/stored_stream.hpp"
#include "net/url.hpp"
#include "player/face_view.hpp"
#include "player/headless.hpp"
#include "player/live_sound.hpp"
#include "player/overlay.hpp"
#include "player/playback.hpp"
#include "player/screenshot.hpp"
#include "player/view_controls.hpp"
#include "render/context.hpp"

namespace mien::player {
namespace {

constexpr double kMessageSeconds = 2.5;
constexpr double kIdleWait = 0.004;   // seconds: how late a due frame can be noticed when the screen sets no beat

struct Glfw {
    Glfw() {
        const char* why = nullptr;
        if (glfwInit()) return;
        glfwGetError(&why);
        throw EnvironmentError(fmt::format("no display to open a window on ({}); use --headless --output FILE.png or FILE.mp4",
                                           why ? why : "no X11 or Wayland"));
    }
    ~Glfw() { glfwTerminate(); }
};

struct DestroyWindow {
    void operator()(GLFWwindow* window) const { glfwDestroyWindow(window); }
};

/// What opening a stream in the background gives.
struct Opened {
    std::unique_ptr<SoundOutput> sound;   // outlives the decode thread of the session, which fills it
    Result<Session> session = Error{ErrorCode::missing, "not opened"};
    std::string no_sound;
};

Opened open_stream(const Options& options, std::string input, std::shared_ptr<std::atomic<bool>> cancelled) {
    SessionOptions wanted;
    wanted.source.start = options.time;
    wanted.source.cache = open_cache(options);
    wanted.source.start_bytes = std::uint64_t(std::llround(1000 * options.model_kb.value_or(0)));
    wanted.sound = options.sound;
    wanted.motion_rungs = options.motion_rung + 1;
    wanted.texture = options.texture;
    wanted.wait = options.wait;
    wanted.source.max_attempts = options.attempts;
    wanted.delay = options.delay;
    wanted.give_up = [cancelled] { return cancelled->load(); };
    Opened opened;
    wanted.sound_sink = [&](const StreamModel& stream) -> DecodeThread::SoundSink {
        if (stream.sound) opened.sound = SoundOutput::open(stream.sample_rate, &opened.no_sound);
        if (!opened.sound) return {};
        if (stream.live) return [live = std::make_shared<LiveSound>(*opened.sound)](decoder::SoundDecoder::Block block) { live->add(std::move(block), steady_seconds()); };
        opened.sound->flush(0);
        return [sound = opened.sound.get()](decoder::SoundDecoder::Block block) {
            sound->push(block.first_sample, std::move(block.sound));
        };
    };
    opened.session = open_session(input, std::move(wanted));
    return opened;
}

std::string clock_text(double seconds) {
    const int whole = int(std::max(0.0, seconds));
    return fmt::format("{}:{:02d}", whole / 60, whole % 60);
}

/// "texture 2 of 3, 512 x 512, 240 kbit/s, auto"
std::string rung_text(const StreamModel& stream, std::size_t rung, bool automatic) {
    const StreamModel::TextureRung& r = stream.texture_rungs[rung];
    return fmt::format("texture {} of {}, {} x {}{}{}", rung + 1, stream.texture_rungs.size(), r.width, r.height,
                       r.bits_per_second > 0 ? fmt::format(", {:.0f} kbit/s", r.bits_per_second / 1000) : "", automatic ? ", auto" : "");
}

class PlayerWindow {
public:
    PlayerWindow(const Options& options, double process_start);
    ~PlayerWindow();
    int run();

private:
    void open(std::string input);
    void drop(std::string input, int count, double now);
    void poll_opening(double now);
    void refine(double now);
    void tell_damage(double now);
    void sum_up_damage();
    void draw(double now);
    void key(int key, double now);
    void character(unsigned code, double now);
    void say(std::string text, double now) { message_ = std::move(text), message_until_ = now + kMessageSeconds; }
    void set_speed(double speed, double now);
    void change_rung(int by, double now);
    void say_rung(double now);
    void toggle_full_screen();
    void screenshot(double now);
    Overlay::Content content(double now);
    std::vector<std::string> statistics_lines(double now);
    void finish_statistics();

    Options options_;
    double begun_;                         // the process, or when what plays was dropped here
    Glfw glfw_;
    std::unique_ptr<GLFWwindow, DestroyWindow> window_;
    std::optional<Overlay> overlay_;
    std::optional<render::Target> target_;
    std::string input_, failure_, unrefined_;
    std::shared_ptr<std::atomic<bool>> cancelled_ = std::make_shared<std::atomic<bool>>(false);
    std::future<Opened> opening_;
    std::unique_ptr<Playback> playback_;
    std::unique_ptr<FaceView> face_;
    ViewControls controls_;
    render::Look look_;
    Statistics statistics_;
    bool framed_ = false, show_statistics_ = false, show_help_ = false, dirty_ = true;
    std::string message_;
    double message_until_ = 0, last_input_ = -1e9, mouse_x_ = 0, mouse_y_ = 0;
    double counted_since_ = 0, shown_per_second_ = 0, draw_seconds_ = 0;
    int counted_ = 0;
    std::size_t shown_rung_ = 0;
    std::vector<Damage> told_;             // as it was when it was told
    int windowed_[4] = {0, 0, 640, 720};
};

PlayerWindow& self(GLFWwindow* window) { return *static_cast<PlayerWindow*>(glfwGetWindowUserPointer(window)); }

PlayerWindow::PlayerWindow(const Options& options, double process_start) : options_(options), begun_(process_start) {
    glfwWindowHint(GLFW_CONTEXT_VERSION_MAJOR, 4);
    glfwWindowHint(GLFW_CONTEXT_VERSION_MINOR, 5);
    glfwWindowHint(GLFW_OPENGL_PROFILE, GLFW_OPENGL_CORE_PROFILE);
    glfwWindowHint(GLFW_SCALE_TO_MONITOR, GLFW_TRUE);
    glfwWindowHint(GLFW_DEPTH_BITS, 0);
    window_.reset(glfwCreateWindow(options.width, options.height, "mien", nullptr, nullptr));
    if (!window_) {
        const char* why = nullptr;
        glfwGetError(&why);
        throw EnvironmentError(fmt::format("this display has no OpenGL 4.5 ({}); use --headless --output FILE.png or FILE.mp4",
                                           why ? why : "no reason given"));
    }
    GLFWwindow* window = window_.get();
    glfwSetWindowUserPointer(window, this);
    glfwMakeContextCurrent(window);
    glfwSwapInterval(1);
    glfwSetKeyCallback(window, [](GLFWwindow* w, int key, int, int action, int) {
        if (action != GLFW_RELEASE) self(w).key(key, steady_seconds());
    });
    glfwSetCharCallback(window, [](GLFWwindow* w, unsigned code) { self(w).character(code, steady_seconds()); });
    glfwSetScrollCallback(window, [](GLFWwindow* w, double, double notches) {
        self(w).controls_.wheel(notches);
        self(w).dirty_ = true;
    });
    glfwSetCursorPosCallback(window, [](GLFWwindow* w, double x, double y) {
        PlayerWindow& player = self(w);
        const bool orbits = glfwGetMouseButton(w, GLFW_MOUSE_BUTTON_LEFT) == GLFW_PRESS;
        const bool pans = glfwGetMouseButton(w, GLFW_MOUSE_BUTTON_RIGHT) == GLFW_PRESS ||
                          glfwGetMouseButton(w, GLFW_MOUSE_BUTTON_MIDDLE) == GLFW_PRESS;
        int width = 0, height = 1;
        glfwGetWindowSize(w, &width, &height);
        if (orbits || pans) player.controls_.drag(pans, x - player.mouse_x_, y - player.mouse_y_, std::max(1, height));
        player.mouse_x_ = x;
        player.mouse_y_ = y;
        player.last_input_ = steady_seconds();
        player.dirty_ = true;
    });
    glfwSetDropCallback(window, [](GLFWwindow* w, int count, const char** paths) {
        if (count > 0) self(w).drop(paths[0], count, steady_seconds());
    });
    const auto refresh = [](GLFWwindow* w) { self(w).dirty_ = true; };
    glfwSetWindowRefreshCallback(window, refresh);
    glfwSetFramebufferSizeCallback(window, [](GLFWwindow* w, int, int) { self(w).dirty_ = true; });
    float scale = 1, other = 1;
    glfwGetWindowContentScale(window, &scale, &other);
    overlay_.emplace(window, scale);
    statistics_.renderer = render::renderer_name();
    if (options.full_screen) toggle_full_screen();
    if (!options.input.empty()) open(options.input);
}

PlayerWindow::~PlayerWindow() {
    *cancelled_ = true;
    if (opening_.valid()) opening_.wait();
}

void PlayerWindow::open(std::string input) {
    *cancelled_ = true;
    if (opening_.valid()) opening_.wait();
    cancelled_ = std::make_shared<std::atomic<bool>>(false);
    sum_up_damage();
    playback_.reset();
    face_.reset();
    framed_ = false;
    failure_.clear();
    unrefined_.clear();
    statistics_ = {.renderer = statistics_.renderer};
    input_ = std::move(input);
    glfwSetWindowTitle(window_.get(), fmt::format("{} - mien", input_).c_str());
    opening_ = std::async(std::launch::async, open_stream, std::cref(options_), input_, cancelled_);
    dirty_ = true;
}

/// What plays goes on when the hand slipped: a file that is no stream is named, and nothing else happens.
void PlayerWindow::drop(std::string input, int count, double now) {
    if (input.starts_with("file:/")) input.erase(0, 5);   // GLFW takes only file:// off
    if (playback_ && !net::looks_like_url(input)) {
        if (const auto stored = net::open_stored_stream(input); !stored.ok()) {
            fmt::print(stderr, "mien-play: {}\n", stored.error().message);
            dirty_ = true;
            return say(stored.error().message, now);
        }
    }
    begun_ = now;
    open(std::move(input));
    if (count > 1) say(fmt::format("playing the first of {} files", count), now);
}

void PlayerWindow::poll_opening(double now) {
    if (!opening_.valid() || opening_.wait_for(std::chrono::seconds(0)) != std::future_status::ready) return;
    Opened opened = opening_.get();
    dirty_ = true;
    if (!opened.session.ok()) {
        failure_ = opened.session.error().message;
        fmt::print(stderr, "mien-play: {}\n", failure_);
        return;
    }
    if (!opened.no_sound.empty()) {
        fmt::print(stderr, "mien-play: {}: silent\n", opened.no_sound);
        say(fmt::format("silent: {}", opened.no_sound), now);
    }
    face_ = std::make_unique<FaceView>(*opened.session->stream);
    glfwSetWindowTitle(window_.get(), fmt::format("{}{} - mien", opened.session->source->header().name, opened.session->stream->live ? " (live)" : "").c_str());
    playback_ = std::make_unique<Playback>(std::move(*opened.session), std::move(opened.sound), options_.loop);
    // What was chosen for one stream holds for the next that is dropped here, but for its start.
    playback_->set_rate(now, options_.speed);
    playback_->set_volume(options_.volume);
    if (options_.muted) playback_->toggle_mute();
    if (const double start = std::exchange(options_.time, 0); start > 0) playback_->seek(now, start);
    if (std::exchange(options_.paused, false) && !playback_->live()) playback_->toggle_pause(now);
}

/// Hands what has come of the model to the GPU, also while a pause holds the picture.
void PlayerWindow::refine(double now) {
    const Session& session = playback_->session();
    if (session.refiner && !face_->refining())
        if (auto pictures = session.refiner->take()) face_->refine(std::move(pictures));
    dirty_ = dirty_ || face_->refining();
    if (std::string why = unrefined_.empty() ? session.unrefined() : std::string(); !why.empty()) {
        fmt::print(stderr, "mien-play: {}\n", why);
        say(unrefined_ = std::move(why), now);
        dirty_ = true;
    }
}

/// Each stretch when it is met; how far it went is known later.
void PlayerWindow::tell_damage(double now) {
    const std::vector<Damage> stretches = playback_->session().decode->damage().stretches();
    for (std::size_t d = told_.size(); d < stretches.size(); ++d) {
        fmt::print(stderr, "mien-play: {}\n", describe(stretches[d]));
        say(describe(stretches[d]), now);
        told_.push_back(stretches[d]);
        dirty_ = true;
    }
}

void PlayerWindow::sum_up_damage() {
    if (!playback_) return;
    const std::vector<Damage> stretches = playback_->session().decode->damage().stretches();
    for (std::size_t d = 0; d < stretches.size(); ++d)
        if (d >= told_.size() || stretches[d].end > told_[d].end || stretches[d].first < told_[d].first) fmt::print(stderr, "mien-play: in all, {}\n", describe(stretches[d]));
    told_.clear();
}

void PlayerWindow::key(int key, double now) {
    last_input_ = now;
    dirty_ = true;
    if (key == GLFW_KEY_F1) show_help_ = !show_help_;
    if (key == GLFW_KEY_ESCAPE && glfwGetWindowMonitor(window_.get())) return toggle_full_screen();
    if (!playback_) return;
    if (playback_->live() && key != GLFW_KEY_SPACE) {
        const bool seeks = key == GLFW_KEY_LEFT || key == GLFW_KEY_RIGHT || key == GLFW_KEY_UP || key == GLFW_KEY_DOWN || key == GLFW_KEY_HOME;
        return seeks ? say("live: there is nothing to seek in", now) : void();
    }
    switch (key) {
        case GLFW_KEY_SPACE: return playback_->toggle_pause(now);
        case GLFW_KEY_LEFT: return playback_->seek_by(now, -5);
        case GLFW_KEY_RIGHT: return playback_->seek_by(now, 5);
        case GLFW_KEY_UP: return playback_->seek_by(now, 60);
        case GLFW_KEY_DOWN: return playback_->seek_by(now, -60);
        case GLFW_KEY_HOME: return playback_->seek(now, 0);
        case GLFW_KEY_BACKSPACE: return set_speed(1, now);
        default: return;
    }
}

void PlayerWindow::character(unsigned code, double now) {
    dirty_ = true;
    switch (code) {
        case 'q': return glfwSetWindowShouldClose(window_.get(), GLFW_TRUE);
        case 'f': return toggle_full_screen();
        case 'i': show_statistics_ = !show_statistics_; return;
        case 'h':
        case '?': show_help_ = !show_help_; return;
        default: break;
    }
    if (!playback_) return;
    switch (code) {
        case '.': return playback_->step(now, 1);
        case ',': return playback_->step(now, -1);
        case 'p': return playback_->toggle_pause(now);
        case '[': return set_speed(playback_->rate() / 1.1, now);
        case ']': return set_speed(playback_->rate() * 1.1, now);
        case '{': return set_speed(playback_->rate() / 2, now);
        case '}': return set_speed(playback_->rate() * 2, now);
        case 'l':
            if (playback_->live()) return;
            playback_->toggle_loop();
            options_.loop = playback_->loops();
            return say(options_.loop ? "loop on" : "loop off", now);
        case '9':
        case '0':
            playback_->set_volume(playback_->volume() + (code == '9' ? -0.05 : 0.05));
            options_.volume = playback_->volume();
            return say(playback_->has_sound() ? fmt::format("volume {:.0f} %", 100 * options_.volume) : "no sound", now);
        case '-':
        case '+':
        case '=':   // the same key without shift on many keyboards
            return change_rung(code == '-' ? -1 : 1, now);
        case 'a':
            playback_->follow_line(now);
            return say_rung(now);
        case 'm':
            playback_->toggle_mute();
            options_.muted = playback_->muted();
            return say(!playback_->has_sound() ? "no sound" : playback_->muted() ? "muted" : "sound on", now);
        case 's': return screenshot(now);
        case 'w': look_.wireframe = !look_.wireframe; return;
        case 'r': framed_ = false; return;
        default: break;
    }
    if (code >= '1' && code < '1' + kLayerCount) {
        const std::string_view name = toggle_layer(look_, int(code - '0'));
        say(fmt::format("{} {}", name, layer_on(look_, int(code - '0')) ? "on" : "off"), now);
    }
}

void PlayerWindow::set_speed(double speed, double now) {
    if (playback_->live()) return;
    playback_->set_rate(now, speed);
    options_.speed = playback_->rate();
    say(fmt::format("speed {:.2f}", options_.speed), now);
}

void PlayerWindow::change_rung(int by, double now) {
    const std::size_t rung = playback_->rung(), count = playback_->session().stream->texture_rungs.size();
    if (count > 0) playback_->set_rung(by < 0 ? rung - (rung > 0) : std::min(rung + 1, count - 1));
    say_rung(now);
}

void PlayerWindow::say_rung(double now) {
    const StreamModel& stream = *playback_->session().stream;
    if (stream.texture_rungs.size() < 2) return say("one rung of texture only", now);
    say(rung_text(stream, playback_->rung(), playback_->follows_line()), now);
}

void PlayerWindow::toggle_full_screen() {
    GLFWwindow* window = window_.get();
    if (glfwGetWindowMonitor(window)) {
        glfwSetWindowMonitor(window, nullptr, windowed_[0], windowed_[1], windowed_[2], windowed_[3], GLFW_DONT_CARE);
    } else if (GLFWmonitor* monitor = glfwGetPrimaryMonitor()) {
        glfwGetWindowPos(window, &windowed_[0], &windowed_[1]);
        glfwGetWindowSize(window, &windowed_[2], &windowed_[3]);
        const GLFWvidmode* mode = glfwGetVideoMode(monitor);
        glfwSetWindowMonitor(window, monitor, 0, 0, mode->width, mode->height, mode->refreshRate);
    }
}

void PlayerWindow::screenshot(double now) {
    if (!target_ || !face_ || !face_->has_frame()) return;
    try {
        const std::filesystem::path path = claim_screenshot(std::filesystem::current_path());
        render::Target still(target_->width(), target_->height(), render::Smoothing::supersample);
        face_->draw(controls_.camera().camera(), look_, still);
        io::write_image(path, still.read());
        say(fmt::format("saved {}", path.string()), now);
    } catch (const EnvironmentError& error) {
        say(error.what(), now);
    }
}

std::vector<std::string> PlayerWindow::statistics_lines(double now) {
    const Session& session = playback_->session();
    const net::SourceStatistics source = session.source->statistics();
    const DecodeThread& decode = *session.decode;
    const StreamModel& stream = *session.stream;
    std::vector<std::string> lines = {
        fmt::format("{}", statistics_.renderer),
        fmt::format("{:.1f} of {:.2f} frames/s, {:.1f} ms to draw", shown_per_second_, stream.frame_rate.value() * playback_->rate(),
                    1000 * draw_seconds_),
        fmt::format("buffer {} frames, dropped {}, stalls {}", decode.buffered(), decode.dropped(), playback_->stalls()),
        fmt::format("received {:.1f} kB, of the model {:.1f} kB; {} blobs from cache", double(source.bytes) / 1e3,
                    double(source.blob_bytes) / 1e3, source.blobs_from_cache),
        fmt::format("model {:.0f} % of {:.1f} kB here", source.model_size ? 100 * double(source.model_bytes) / double(source.model_size) : 100.0,
                    double(source.model_size) / 1e3),
        fmt::format("motion {:.1f} kB, texture {:.1f} kB, sound {:.1f} kB", double(session.motion_bytes()) / 1e3,
                    double(session.texture_bytes()) / 1e3,
                    stream.sound ? double(decode.bytes_of(stream.sound_slot)) / 1e3 : 0.0),
        fmt::format("{} points, {} components, damaged groups {}", stream.model.point_count(), stream.composed.size(),
                    decode.damaged_groups() + source.damaged_groups),
    };
    if (!unrefined_.empty()) lines.push_back(unrefined_);
    if (!stream.texture_rungs.empty()) {
        lines.push_back(rung_text(stream, playback_->rung(), playback_->follows_line()));
        if (shown_rung_ != playback_->rung()) lines.back() += fmt::format("; {} still shown", shown_rung_ + 1);
    }
    if (session.networked && !stream.live)
        lines.push_back(fmt::format("line {}, {:.1f} s ahead", source.line ? fmt::format("{:.2f} Mbit/s", *source.line / 1e6) : "not measured",
                                    std::max(0.0, source.until - playback_->position(now))));
    if (source.round_trip > 0 || source.reconnects > 0)
        lines.push_back(fmt::format("round trip {:.1f} ms, reconnects {}", 1000 * source.round_trip, source.reconnects));
    if (const auto lead = playback_->sound_lead(now)) lines.push_back(fmt::format("sound {:+.0f} ms", 1000 * *lead));
    return lines;
}

Overlay::Content PlayerWindow::content(double now) {
    Overlay::Content content;
    content.help = show_help_;
    if (now < message_until_) content.message = message_;
    if (!failure_.empty()) content.message = failure_;
    if (opening_.valid()) content.message = fmt::format("opening {}", input_);
    if (input_.empty()) content.message = "drop a .mien file here, or start with mien-play URL";
    if (!playback_) return content;
    const net::SourceStatus status = playback_->session().source->status();
    if (status.state == net::SourceState::reconnecting) {
        content.message = fmt::format("connection lost, reconnecting ({})", status.reason);
    } else if (status.state == net::SourceState::failed) {
        content.message = fmt::format("connection lost: {}", status.reason);
    } else if (playback_->live() && playback_->ended()) {
        content.message = "the live stream has ended; it goes on here when its sender comes back";
    } else if (playback_->waiting() && content.message.empty()) {
        content.message = playback_->live() ? "waiting for live data" : "waiting for data";
    }
    content.live = playback_->live() && !playback_->ended();
    if (content.live && playback_->paused() && content.message.empty()) content.message = "paused";
    if (show_statistics_) content.statistics = statistics_lines(now);
    const double length = playback_->session().stream->seconds();
    if (length > 0 && (playback_->paused() || now - last_input_ < 2)) {
        content.time_line = playback_->position(now) / length;
        content.clock = fmt::format("{} / {}", clock_text(playback_->position(now)), clock_text(length));
    }
    return content;
}

void PlayerWindow::draw(double now) {
    int width = 0, height = 0;
    glfwGetFramebufferSize(window_.get(), &width, &height);
    if (width <= 0 || height <= 0) return;   // minimised
    const bool reshaped = !target_ || target_->width() != width || target_->height() != height;
    if (reshaped) target_.emplace(width, height, render::live_smoothing());
    if (face_ && face_->has_frame()) {
        const render::OrbitCamera home = face_->framing(float(width) / float(height), options_.view);
        if (!std::exchange(framed_, true)) controls_.reset(home);
        else if (reshaped) controls_.reshape(home);
        face_->draw(controls_.camera().camera(), look_, *target_);
    } else {
        target_->clear();
    }
    target_->present(width, height);
    overlay_->draw(content(now));
    glfwSwapBuffers(window_.get());
}

int PlayerWindow::run() {
    double overlay_until = 0;
    while (!glfwWindowShouldClose(window_.get()) && StopRequest::signal() == 0) {
        const double now = steady_seconds();
        poll_opening(now);
        bool fresh = false;
        if (playback_) {
            refine(now);
            tell_damage(now);
            if (const auto frame = playback_->tick(now)) {
                face_->show(*frame);
                shown_rung_ = frame->texture_rung;
                fresh = true;
                if (statistics_.frames++ == 0) {
                    statistics_.startup = now - begun_;
                    statistics_.startup_bytes = playback_->session().source->statistics().bytes;
                }
                ++counted_;
            }
        }
        if (now - counted_since_ >= 1) {
            shown_per_second_ = counted_ / (now - counted_since_);
            counted_since_ = now;
            counted_ = 0;
            dirty_ = dirty_ || show_statistics_ || !playback_ || playback_->waiting() || playback_->live();
        }
        // Messages and the time line come and go by themselves.
        const bool overlaid = now < message_until_ || now - last_input_ < 2;
        if (overlaid) overlay_until = now + 0.1;
        if (fresh || std::exchange(dirty_, false) || now < overlay_until) {
            draw(now);
            draw_seconds_ += 0.1 * (steady_seconds() - now - draw_seconds_);
            glfwPollEvents();
        } else {
            glfwWaitEventsTimeout(kIdleWait);
        }
    }
    sum_up_damage();
    finish_statistics();
    return failure_.empty() ? 0 : 1;
}

void PlayerWindow::finish_statistics() {
    if (options_.stats.empty() || !playback_) return;
    playback_->session().collect(statistics_);
    statistics_.stalls = playback_->stalls();
    statistics_.frames_per_second = draw_seconds_ > 0 ? 1 / draw_seconds_ : 0;
    write_json(options_.stats, statistics_);
}

}  // namespace

int run_window(const Options& options, double process_start) {
    const StopRequest stop;
    PlayerWindow window(options, process_start);
    const int code = window.run();
    return StopRequest::signal() ? 128 + StopRequest::signal() : code;
}

}  // namespace mien::player
