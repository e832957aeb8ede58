#include "player/headless.hpp"

#include <fmt/format.h>
#include <unistd.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstdio>
#include <ctime>
#include <future>
#include <memory>
#include <mutex>
#include <optional>
#include <thread>
#include <utility>

#include "core/environment_error.hpp"
#include "core/interruption.hpp"
#include "core/picture_measures.hpp"
#include "io/image_file.hpp"
#include "media/video_writer.hpp"
#include "player/contact_sheet.hpp"
#include "player/face_view.hpp"
#include "player/label.hpp"
#include "player/session.hpp"
#include "player/sound_track.hpp"
#include "player/truth.hpp"
#include "render/context.hpp"

namespace mien::player {
namespace {

constexpr std::int64_t kLikenessEvery = 15;   // SSIM of a picture takes longer than drawing it
constexpr int kTileWidth = 270, kTileHeight = 304;   // of the contact sheet: 2160 pixels across

const Error kStopped{ErrorCode::unavailable, "stopped before the end"};
bool stopped() { return StopRequest::signal() != 0; }

double processor_seconds() {
    timespec time{};
    clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &time);
    return double(time.tv_sec) + 1e-9 * double(time.tv_nsec);
}

/// One pass over a stream without a window.
class HeadlessRun {
public:
    HeadlessRun(const Options& options, double process_start) : options_(options), process_start_(process_start) {}
    /// Figures are written whatever came of it.
    Result<void> run();
    /// Names what was lost of that which was asked for; whether anything was.
    bool tell_damage() const;

private:
    bool wants_movie() const { return options_.output.extension() == ".mp4"; }
    bool wants_png() const { return !options_.output.empty() && !wants_movie(); }
    Result<void> write_outputs();
    void write_figures();
    Result<void> open();
    Result<PlayFrame> next_frame();
    bool over(const Result<PlayFrame>& frame) const;
    void go_to(std::int64_t frame, std::optional<std::uint64_t> slots = {});
    Result<PlayFrame> frame_at(std::int64_t frame);
    Result<void> make_picture();
    Result<Sound> fetch_sound();
    Result<void> make_movie();
    Result<void> make_sheet();
    Result<void> measure();
    Result<void> make_live();
    Result<PlayFrame> next_live();
    Result<void> movie_frame(const PlayFrame& frame, render::Target& target);
    void write_until(std::int64_t frame);
    void written();
    void sheet_moment(int moment);
    void show(const PlayFrame& frame);
    Image picture(const render::OrbitCamera& camera, render::Target& target);
    void drawn();
    void tell(std::int64_t frame) const;

    const Options& options_;
    double process_start_;
    Statistics statistics_;
    SoundTrack sound_;                     // outlives the decode thread of the session, which fills it
    Session session_;
    std::optional<render::OffscreenContext> context_;
    std::optional<FaceView> face_;
    std::unique_ptr<TruthView> truth_;
    std::optional<ContactSheet> sheet_;
    std::optional<render::Target> sheet_target_;
    std::optional<media::VideoWriter> movie_;
    std::int64_t first_ = 0, end_ = 0;     // frames wanted, end_ not included
    std::int64_t written_ = 0;             // frames of the movie, at its own rate
    std::shared_ptr<const Image> last_;    // picture of the movie: stays where frames are lost
    std::future<void> writing_;            // of the movie: it is encoded while the next picture is drawn
    bool begun_ = false;
    double busy_ = 0;                      // seconds spent on what was received
    std::optional<PictureComparison> likeness_;   // of received and truth pictures
};

Result<void> HeadlessRun::open() {
    SessionOptions wanted;
    wanted.source.start = options_.time;
    wanted.source.rate = 0;
    wanted.source.cache = open_cache(options_);
    // What is drawn must not depend on how fast the rest would come.
    wanted.source.refine = false;
    if (options_.model_kb) wanted.source.start_bytes = std::uint64_t(std::llround(1000 * *options_.model_kb));
    wanted.source.max_reconnects = 8;
    wanted.source.max_attempts = options_.attempts;
    wanted.source.on_status = [](const net::SourceStatus& status) {
        if (status.state == net::SourceState::reconnecting)
            fmt::print(stderr, "mien-play: connection lost, reconnecting ({})\n", status.reason);
    };
    wanted.sound = options_.sound && wants_movie();
    wanted.motion_rungs = options_.motion_rung + 1;
    wanted.texture = options_.texture;
    wanted.sound_first = wanted.sound;
    wanted.wait = options_.wait;
    wanted.give_up = stopped;
    wanted.sound_sink = [this](const StreamModel&) {
        return [this](decoder::SoundDecoder::Block block) { sound_.add(std::move(block)); };
    };
    MIEN_TRY(session, open_session(options_.input, std::move(wanted)));
    session_ = std::move(session);
    const StreamModel& stream = *session_.stream;
    if (stream.model.point_count() == 0)
        return Error{ErrorCode::missing, "this stream moves weights without a face: there is nothing to draw. mien decode gives its weights"};
    const double rate = stream.frame_rate.value();
    if (stream.live) {
        if (!options_.sheet.empty() || !options_.compare.empty() || options_.benchmark || options_.first_frame || options_.time > 0)
            return Error{ErrorCode::invalid, "this stream is live: it can be captured with --output and --seconds, from now on; --sheet, --compare, --benchmark, --time and "
                                             "--frames are for recordings"};
        context_.emplace();
        statistics_.renderer = render::renderer_name();
        face_.emplace(stream);
        return {};
    }
    if (options_.seconds) return Error{ErrorCode::invalid, "--seconds is for live streams; use --frames"};
    first_ = options_.first_frame.value_or(std::int64_t(std::floor(options_.time * rate + 1e-6)));
    end_ = options_.end_frame.value_or(stream.frames > 0 ? stream.frames : first_ + std::int64_t(std::ceil(10 * rate)));
    if (stream.frames > 0) end_ = std::min(end_, stream.frames);
    if (first_ >= end_)
        return Error{ErrorCode::invalid, fmt::format("nothing to show: the stream has {} frames ({:.2f} s)", stream.frames,
                                                     stream.seconds())};
    context_.emplace();
    statistics_.renderer = render::renderer_name();
    face_.emplace(stream);
    if (options_.compare.empty()) return {};
    MIEN_TRY(truth, TruthView::open(options_.compare, stream.model));
    if (truth->frames() < end_)
        return Error{ErrorCode::mismatch, fmt::format("{} has {} frames, the stream {}", options_.compare.string(),
                                                      truth->frames(), end_)};
    if (stream.frames > 0 && truth->frames() != stream.frames)
        fmt::print(stderr, "mien-play: {} has {} frames, the stream {}: is it the clip that the stream was made of?\n", options_.compare.string(), truth->frames(), stream.frames);
    if (truth->frame_rate() != stream.frame_rate)
        fmt::print(stderr, "mien-play: {} has {} frames/s, the stream {}\n", options_.compare.string(), to_string(truth->frame_rate()), to_string(stream.frame_rate));
    truth_ = std::move(truth);
    return {};
}

Result<PlayFrame> HeadlessRun::next_frame() {
    const auto failed = [&] { return session_.source->status().state == net::SourceState::failed; };
    if (auto frame = stopped() ? std::nullopt : session_.decode->wait_pop([&] { return failed() || stopped(); })) return std::move(*frame);
    if (stopped()) return kStopped;
    if (failed()) return Error{ErrorCode::unavailable, session_.source->status().reason};
    return Error{ErrorCode::truncated, "nothing that was asked for is left in the stream"};
}

/// The stream has ended early, and what it held is shown.
bool HeadlessRun::over(const Result<PlayFrame>& frame) const {
    return !frame.ok() && frame.error().code == ErrorCode::truncated && statistics_.frames > 0;
}

bool HeadlessRun::tell_damage() const {
    if (!session_.decode || session_.stream->live) return false;
    const double rate = session_.stream->frame_rate.value();
    const double from = double(first_) / rate, until = double(wants_png() && options_.sheet.empty() ? first_ + 1 : end_) / rate;
    bool lost = false;
    for (const Damage& damage : session_.decode->damage().stretches()) {
        if (damage.end <= from || damage.first >= until) continue;
        fmt::print(stderr, "mien-play: {}\n", describe(damage));
        lost = true;
    }
    return lost;
}

/// As next_frame(), but a live stream owes us nothing: `missing` when it has ended or nothing comes.
Result<PlayFrame> HeadlessRun::next_live() {
    const double until = steady_seconds() + options_.wait;
    const auto over = [&] { return session_.source->status().state == net::SourceState::failed || steady_seconds() > until || stopped(); };
    if (auto frame = stopped() ? std::nullopt : session_.decode->wait_pop(over)) return std::move(*frame);
    if (stopped()) return kStopped;
    const net::SourceStatus status = session_.source->status();
    if (status.state == net::SourceState::failed) return Error{ErrorCode::missing, status.reason};
    if (session_.decode->drained()) return Error{ErrorCode::missing, "the live stream has ended"};
    return Error{ErrorCode::missing, fmt::format("no frame of the live stream came in {:.0f} s", options_.wait)};
}

/// From the newest frame on, for as long as was asked, or until the stream ends.
Result<void> HeadlessRun::make_live() {
    session_.decode->start();
    MIEN_TRY(first, next_live());
    first_ = first.frame;
    if (wants_png()) {
        show(first);
        render::Target target(options_.width, options_.height, render::Smoothing::supersample);
        io::write_image(options_.output, picture(face_->framing(float(options_.width) / float(options_.height), options_.view), target));
        return drawn(), Result<void>();
    }
    const Rational own = session_.stream->frame_rate;
    end_ = first_ + std::max<std::int64_t>(1, std::llround(options_.seconds.value_or(10) * own.value()));
    media::VideoWriter::Movie wanted;
    if (session_.stream->sound) wanted.sound = Sound{session_.stream->sample_rate, session_.stream->channels, {}}, wanted.sound_later = true;
    movie_ = media::VideoWriter::movie(options_.output, options_.width, options_.height, options_.frame_rate.value_or(own), std::move(wanted));
    render::Target target(options_.width, options_.height, render::live_smoothing());
    std::int64_t last = first_;
    for (Result<PlayFrame> frame = std::move(first); ; frame = next_live()) {
        if (!frame.ok()) {
            fmt::print(stderr, "mien-play: {}; the movie ends there\n", frame.error().message);
            break;
        }
        if (frame->frame >= end_) break;
        MIEN_CHECK(movie_frame(*frame, target));
        tell(frame->frame);
        last = frame->frame;
        if (frame->frame + 1 == end_) break;
    }
    written();
    if (session_.stream->sound) {
        const double from = double(first_) / own.value(), until = double(last + 1) / own.value(), patience = steady_seconds() + 0.5;
        while (sound_.end() < until && steady_seconds() < patience && !stopped()) std::this_thread::sleep_for(std::chrono::milliseconds(10));
        if (const Sound sound = sound_.between(from, until); !sound.samples.empty()) movie_->set_sound(sound);
    }
    movie_->finish();
    return {};
}

/// Reads from `frame` on. What has not begun yet is begun where the source is, so that nothing is read twice.
void HeadlessRun::go_to(std::int64_t frame, std::optional<std::uint64_t> slots) {
    if (!std::exchange(begun_, true) && !options_.first_frame && frame == first_) return session_.decode->start(frame);
    session_.decode->seek(double(frame) / session_.stream->frame_rate.value(), {}, slots);
}

Result<PlayFrame> HeadlessRun::frame_at(std::int64_t frame) {
    go_to(frame);
    return next_frame();
}

void HeadlessRun::show(const PlayFrame& frame) { face_->show(frame); }

/// Somebody who watches sees that it goes on.
void HeadlessRun::tell(std::int64_t frame) const {
    if (!isatty(STDERR_FILENO)) return;
    fmt::print(stderr, "\rmien-play: frame {} of {}{}", frame - first_ + 1, end_ - first_, frame + 1 < end_ ? "" : "\n");
    std::fflush(stderr);
}

void HeadlessRun::drawn() {
    if (statistics_.frames++ > 0) return;
    statistics_.startup = steady_seconds() - process_start_;
    statistics_.startup_bytes = session_.source->statistics().bytes;
}

Image HeadlessRun::picture(const render::OrbitCamera& camera, render::Target& target) {
    face_->draw(camera.camera(), {}, target);
    return target.read();
}

Result<void> HeadlessRun::make_picture() {
    MIEN_TRY(frame, frame_at(first_));
    show(frame);
    render::Target target(options_.width, options_.height, render::Smoothing::supersample);
    const auto camera = face_->framing(float(options_.width) / float(options_.height), options_.view);
    Image image = picture(camera, target);
    drawn();
    if (truth_) {
        MIEN_CHECK(truth_->show(frame.frame));
        truth_->draw(camera.camera(), {}, target);
        const Image truth = target.read();
        likeness_.emplace(image.width, image.height);
        likeness_->add(truth, image);
        Image both(2 * options_.width, options_.height, 3);
        paste(both, truth, 0, 0);
        paste(both, image, options_.width, 0);
        image = std::move(both);
    }
    io::write_image(options_.output, image);
    return {};
}

void HeadlessRun::sheet_moment(int moment) {
    for (int v = 0; v < int(ContactSheet::kViews.size()); ++v) {
        const float aspect = float(kTileWidth) / kTileHeight;
        sheet_->place(moment, v, picture(face_->framing(aspect, ContactSheet::kViews[std::size_t(v)]), *sheet_target_));
    }
    if (!movie_) drawn();
}

Result<void> HeadlessRun::make_sheet() {
    for (int i = 0; i < ContactSheet::kMoments; ++i) {
        const auto frame = frame_at(sheet_->moments()[std::size_t(i)]);
        if (over(frame)) break;
        if (!frame.ok()) return frame.error();
        show(*frame);
        sheet_moment(i);
    }
    return {};
}

Result<void> HeadlessRun::movie_frame(const PlayFrame& frame, render::Target& target) {
    const double start = steady_seconds();
    show(frame);
    const auto camera = face_->framing(float(options_.width) / float(options_.height), options_.view);
    Image image = picture(camera, target);
    busy_ += steady_seconds() - start;
    drawn();
    if (truth_) {
        MIEN_CHECK(truth_->show(frame.frame));
        truth_->draw(camera.camera(), {}, target);
        const Image truth = target.read();
        if ((frame.frame - first_) % kLikenessEvery == 0) likeness_->add(truth, image);
        Image both(2 * options_.width, options_.height, 3);
        paste(both, truth, 0, 0);
        paste(both, image, options_.width, 0);
        draw_label(both, 16, 14, 2, "truth");
        draw_label(both, options_.width + 16, 14, 2, "received");
        image = std::move(both);
    }
    const auto now = std::make_shared<const Image>(std::move(image));
    if (written_ == 0) last_ = now;
    write_until(frame.frame);
    last_ = now;
    write_until(frame.frame + 1);
    return {};
}

/// A movie of another rate repeats or leaves out pictures: each shows what is due at its own time.
void HeadlessRun::write_until(std::int64_t frame) {
    const Rational own = session_.stream->frame_rate, rate = options_.frame_rate.value_or(own);
    const double until = double(frame - first_) / own.value();
    int times = 0;
    for (; double(written_) / rate.value() < until - 1e-9; ++written_) ++times;
    if (times == 0) return;
    written();
    writing_ = std::async(std::launch::async, [this, picture = last_, times] {
        for (int i = 0; i < times; ++i) movie_->write(*picture);
    });
}

/// All pictures so far are; what the file system refused is thrown here.
void HeadlessRun::written() {
    if (writing_.valid()) writing_.get();
}

/// A movie file wants its sound before its pictures, so the sound track comes by itself first; it is small.
Result<Sound> HeadlessRun::fetch_sound() {
    const StreamModel& stream = *session_.stream;
    const double start = double(first_) / stream.frame_rate.value(), end = double(end_) / stream.frame_rate.value();
    go_to(first_);
    const auto over = [&] {
        return sound_.end() >= end || session_.source->status().state == net::SourceState::failed || stopped();
    };
    while (session_.decode->wait_pop(over)) {}
    if (stopped()) return kStopped;
    if (session_.source->status().state == net::SourceState::failed)
        return Error{ErrorCode::unavailable, session_.source->status().reason};
    return sound_.between(start, std::clamp(sound_.end(), start, end));
}

Result<void> HeadlessRun::make_movie() {
    const Rational own = session_.stream->frame_rate;
    media::VideoWriter::Movie wanted;
    std::optional<std::uint64_t> pictures;   // what is asked for once the sound is there
    if (session_.stream->sound) {
        MIEN_TRY(sound, fetch_sound());
        if (!sound.samples.empty()) wanted.sound = std::move(sound);
        pictures = session_.stream->slots() & ~(std::uint64_t(1) << session_.stream->sound_slot);
    }
    movie_ = media::VideoWriter::movie(options_.output, options_.width * (truth_ ? 2 : 1), options_.height,
                                       options_.frame_rate.value_or(own), std::move(wanted));
    render::Target target(options_.width, options_.height, render::live_smoothing());
    if (truth_) likeness_.emplace(options_.width, options_.height);

    go_to(first_, pictures);
    std::size_t moment = 0;
    for (std::int64_t next = first_; next < end_;) {
        const double start = steady_seconds();
        const auto frame = next_frame();
        busy_ += steady_seconds() - start;
        if (over(frame)) break;
        if (!frame.ok()) return frame.error();
        if (frame->frame >= end_) break;
        MIEN_CHECK(movie_frame(*frame, target));
        while (sheet_ && moment < sheet_->moments().size() && sheet_->moments()[moment] <= frame->frame)
            sheet_moment(int(moment++));
        next = frame->frame + 1;
        tell(frame->frame);
    }
    written();
    movie_->finish();
    return {};
}

/// Draws everything as live playing would, each picture finished before the next is begun.
Result<void> HeadlessRun::measure() {
    render::Target target(options_.width, options_.height, render::live_smoothing());
    const auto camera = [&] { return face_->framing(float(options_.width) / float(options_.height), options_.view).camera(); };
    go_to(first_);
    {   // The first frame also pays for compiling shaders.
        MIEN_TRY(frame, next_frame());
        show(frame);
        face_->draw(camera(), {}, target);
        target.wait();
        drawn();
    }
    Statistics::FrameCost cost;
    const double begin = steady_seconds(), processor = processor_seconds();
    double now = begin;
    const auto lap = [&] {
        const double before = std::exchange(now, steady_seconds());
        return 1000 * (now - before);
    };
    for (std::int64_t next = first_ + 1; next < end_;) {
        const auto frame = next_frame();
        if (over(frame)) break;
        if (!frame.ok()) return frame.error();
        if (frame->frame >= end_) break;
        next = frame->frame + 1;
        cost.wait += lap();
        show(*frame);
        cost.upload += lap();
        face_->draw(camera(), {}, target);
        target.wait();
        cost.draw += lap();
        drawn();
    }
    const double frames = double(statistics_.frames - 1);
    if (frames < 1) return Error{ErrorCode::invalid, "measuring takes two frames at least"};
    cost.processor = 1000 * (processor_seconds() - processor);
    for (double* sum : {&cost.wait, &cost.upload, &cost.draw, &cost.processor}) *sum /= frames;
    statistics_.cost = cost;
    statistics_.frames_per_second = frames / (now - begin);
    return {};
}

Result<void> HeadlessRun::run() {
    MIEN_CHECK(open());
    const auto done = write_outputs();
    if (writing_.valid()) writing_.wait();
    movie_.reset();   // one that has no end is none
    write_figures();
    return done;
}

Result<void> HeadlessRun::write_outputs() {
    const bool live = session_.stream->live;
    if (live) MIEN_CHECK(make_live());
    if (!options_.sheet.empty()) {
        sheet_.emplace(first_, end_, kTileWidth, kTileHeight);
        sheet_target_.emplace(kTileWidth, kTileHeight, render::Smoothing::supersample);
    }
    if (wants_png() && !live) MIEN_CHECK(make_picture());
    if (options_.benchmark) MIEN_CHECK(measure());
    if (wants_movie() && !live) {
        MIEN_CHECK(make_movie());
    } else if (sheet_) {
        MIEN_CHECK(make_sheet());
    }
    if (sheet_) io::write_image(options_.sheet, sheet_->finish(session_.stream->frame_rate));
    return {};
}

void HeadlessRun::write_figures() {
    if (busy_ > 0) statistics_.frames_per_second = double(statistics_.frames) / busy_;
    if (likeness_ && likeness_->frames() > 0) {
        statistics_.rendered_psnr = likeness_->psnr_y();
        statistics_.rendered_ssim = likeness_->ssim();
    }
    session_.collect(statistics_);
    if (options_.benchmark) fmt::print("{}", to_json(statistics_));
    if (!options_.stats.empty()) write_json(options_.stats, statistics_);
}

}  // namespace

double steady_seconds() {
    return std::chrono::duration<double>(std::chrono::steady_clock::now().time_since_epoch()).count();
}

int run_headless(const Options& options, double process_start) {
    const StopRequest stop;
    HeadlessRun run(options, process_start);
    const auto done = run.run();
    const bool lost = run.tell_damage();
    if (done.ok()) return lost;
    fmt::print(stderr, "mien-play: {}\n", done.error().message);
    return stopped() ? 128 + StopRequest::signal() : 1;
}

}  // namespace mien::player
