#include "player/decode_thread.hpp"

#include <algorithm>
#include <chrono>
#include <cmath>

namespace mien::player {
namespace {

using namespace std::chrono_literals;

constexpr std::size_t kBufferBytes = 192u << 20;  // decoded pictures that wait: 120 of 1024 x 1024, a few of 8192 x 8192
constexpr std::size_t kBufferFrames = 60;
constexpr double kSoundGap = 0.05;                // seconds: where a block ends and the next begins is a matter of packets
constexpr double kStartSeconds = 0.2;             // of frames before playing starts: covers a decoder's burst

std::size_t capacity_of(const StreamModel& stream, double delay) {
    if (stream.live) return kBufferFrames + std::size_t(std::ceil(delay * stream.frame_rate.value()));
    std::size_t picture = 0;
    for (const StreamModel::TextureRung& rung : stream.texture_rungs) picture = std::max(picture, std::size_t(rung.width) * rung.height * 3 / 2);
    return picture ? std::clamp<std::size_t>(kBufferBytes / picture, 3, kBufferFrames) : kBufferFrames;
}

std::size_t enough_of(const StreamModel& stream) {
    return std::size_t(std::ceil(kStartSeconds * stream.frame_rate.value()));
}

}  // namespace

DecodeThread::DecodeThread(net::StreamSource& source, StreamModel& stream, SoundSink on_sound, double delay)
    : source_(source), stream_(stream), on_sound_(std::move(on_sound)), groups_(stream, damage_), live_(stream),
      buffer_(capacity_of(stream, delay), enough_of(stream)), live_clock_(stream.frame_rate.value(), delay),
      thread_([this] { stream_.live ? run_live() : run(); }) {}

DecodeThread::~DecodeThread() {
    {
        const std::lock_guard lock(mutex_);
        stopping_ = true;
    }
    changed_.notify_all();
    thread_.join();
}

void DecodeThread::start(std::int64_t first_frame) {
    const std::lock_guard lock(mutex_);
    restart_ = first_frame;
    idle_ = false;
    changed_.notify_all();
}

void DecodeThread::seek(double seconds, const std::function<void()>& quiet, std::optional<std::uint64_t> slots) {
    const std::scoped_lock lock(sound_mutex_, mutex_);
    if (quiet) quiet();
    if (slots) select(*slots);
    generation_ = source_.seek(seconds);
    buffer_.clear();
    starved_ = true;
    // A hair before the frame's time still means that frame.
    restart_ = std::int64_t(std::floor(seconds * stream_.frame_rate.value() + 1e-6));
    due_ = -1;
    idle_ = false;
    changed_.notify_all();
}

void DecodeThread::select(std::uint64_t slots) {
    slots_ = slots;
    source_.select(slots);
}

void DecodeThread::restart() {
    const std::int64_t first = *std::exchange(restart_, std::nullopt);
    groups_.restart(first);
    sound_end_ = double(first) / stream_.frame_rate.value();
}

void DecodeThread::heard(const decoder::SoundDecoder::Block& block) {
    const double first = double(block.first_sample) / stream_.sample_rate;
    if (first > sound_end_ + kSoundGap) damage_.note({protocol::TrackKind::sound, sound_end_, first});
    sound_end_ = std::max(sound_end_, first + double(block.sound.length()) / stream_.sample_rate);
}

/// The stream is over: what it should have gone on with is lost.
void DecodeThread::note_missing_end() {
    const auto asked = [&](std::uint8_t slot) { return slots_ >> slot & 1; };
    const double rate = stream_.frame_rate.value(), motion_end = double(groups_.motion_end()) / rate, sound = double(stream_.samples) / stream_.sample_rate;
    if (asked(stream_.motion_slots.front()) && groups_.motion_end() < stream_.frames) damage_.note({protocol::TrackKind::motion, motion_end, stream_.seconds()});
    if (stream_.sound && asked(stream_.sound_slot) && sound_end_ + kSoundGap < sound) damage_.note({protocol::TrackKind::sound, sound_end_, sound});
}

void DecodeThread::run() {
    for (;;) {
        std::uint32_t generation = 0;
        {
            std::unique_lock lock(mutex_);
            changed_.wait(lock, [&] { return stopping_ || !idle_; });
            if (stopping_) return;
            if (restart_) restart();
            generation = generation_;
        }
        if (groups_.wants_group()) pull();
        if (const std::int64_t due = due_; due >= 0) skipped_ += std::uint64_t(groups_.skip_to(due));
        if (groups_.has_work()) {
            for (PlayFrame& frame : groups_.step()) push(std::move(frame), generation);
        } else {
            std::unique_lock lock(mutex_);
            starved_ = true;
            if (groups_.drained() && !restart_) {
                note_missing_end();
                buffer_.finish();
                changed_.notify_all();
                changed_.wait(lock, [&] { return stopping_ || restart_; });
            }
        }
        damaged_ = groups_.damaged_groups();
    }
}

void DecodeThread::run_live() {
    for (;;) {
        {
            std::unique_lock lock(mutex_);
            changed_.wait(lock, [&] { return stopping_ || !idle_; });
            if (stopping_) return;
        }
        const std::optional<net::Arrival> arrival = source_.next(50ms);
        std::uint32_t generation = 0;
        {
            const std::lock_guard lock(mutex_);
            if (restart_) live_.restart(), restart_.reset();
            generation = generation_;
            starved_ = !arrival;
            if (arrival && arrival->generation == generation && arrival->is_end()) {
                buffer_.finish();
                changed_.notify_all();
            }
        }
        if (!arrival || arrival->generation != generation || !arrival->object) continue;
        const protocol::LiveObject& object = *arrival->object;
        if (object.slot < bytes_.size()) bytes_[object.slot] += object.object.bytes.size();
        if (stream_.sound && object.slot == stream_.sound_slot) {
            if (auto block = live_.hear(object)) sound(std::move(*block), generation);
        } else {
            for (PlayFrame& frame : live_.add(object)) push_live(std::move(frame), generation);
        }
        damaged_ = live_.damaged_groups();
    }
}

void DecodeThread::push_live(PlayFrame frame, std::uint32_t generation) {
    const std::lock_guard lock(mutex_);
    if (generation_ != generation) return;
    frame.decoded_at = std::chrono::duration<double>(std::chrono::steady_clock::now().time_since_epoch()).count();
    if (frame.frame <= last_live_) {   // the stream has begun anew
        buffer_.clear();
        live_clock_.restart();
    }
    last_live_ = frame.frame;
    live_clock_.arrived(frame.frame, frame.decoded_at);
    buffer_.resume();
    buffer_.make_room();
    buffer_.push(std::move(frame));
    ++decoded_;
    changed_.notify_all();
}

void DecodeThread::pull() {
    std::optional<net::Arrival> arrival = source_.next(groups_.has_work() ? 0ms : 50ms);
    if (!arrival) return;
    std::uint32_t generation = 0;
    {
        const std::lock_guard lock(mutex_);
        // A seek may have come while next() waited: what arrived can already be of after it.
        if (restart_) restart();
        generation = generation_;
        if (arrival->generation == generation) starved_ = false;
    }
    if (arrival->generation != generation) return;
    if (!arrival->group) {
        groups_.finish();
        return;
    }
    const std::uint8_t slot = arrival->group->slot;
    if (slot < bytes_.size())
        for (const protocol::Object& object : arrival->group->objects) bytes_[slot] += object.bytes.size();
    const auto& motion = stream_.motion_slots;
    if (std::find(motion.begin(), motion.end(), slot) != motion.end() || stream_.texture_rung_of(slot)) {
        groups_.add(std::move(*arrival->group));
    } else if (stream_.sound && slot == stream_.sound_slot) {
        auto block = stream_.sound->decode(*arrival->group);
        if (!block.ok()) return;   // a damaged group of sound is silence
        sound(std::move(*block), generation);
    }
}

void DecodeThread::sound(decoder::SoundDecoder::Block block, std::uint32_t generation) {
    const std::lock_guard sound_lock(sound_mutex_);
    {
        const std::lock_guard lock(mutex_);
        if (generation_ != generation) return;
    }
    if (!stream_.live) heard(block);
    if (on_sound_) on_sound_(std::move(block));
}

void DecodeThread::push(PlayFrame frame, std::uint32_t generation) {
    std::unique_lock lock(mutex_);
    changed_.wait(lock, [&] { return stopping_ || generation_ != generation || buffer_.has_room(); });
    if (stopping_ || generation_ != generation) return;
    buffer_.push(std::move(frame));
    ++decoded_;
    starved_ = false;
    changed_.notify_all();
}

std::optional<PlayFrame> DecodeThread::take(std::int64_t due) {
    const std::lock_guard lock(mutex_);
    auto frame = buffer_.take(due);
    if (frame) changed_.notify_all();
    return frame;
}

std::optional<PlayFrame> DecodeThread::take_live(double now, std::optional<double> heard) {
    const std::lock_guard lock(mutex_);
    if (heard) live_clock_.follow_sound(*heard, now);
    return buffer_.take(live_clock_.due(now));
}

std::optional<PlayFrame> DecodeThread::pop() {
    const std::lock_guard lock(mutex_);
    auto frame = buffer_.pop();
    if (frame) changed_.notify_all();
    return frame;
}

std::optional<PlayFrame> DecodeThread::wait_pop(const std::function<bool()>& give_up) {
    std::unique_lock lock(mutex_);
    while (buffer_.empty() && !buffer_.drained()) {
        if (changed_.wait_for(lock, 100ms) == std::cv_status::no_timeout || !give_up) continue;
        lock.unlock();
        const bool over = give_up();
        lock.lock();
        if (over) break;
    }
    auto frame = buffer_.pop();
    changed_.notify_all();
    return frame;
}

bool DecodeThread::ready() const { return std::lock_guard(mutex_), buffer_.ready(); }
bool DecodeThread::empty() const { return std::lock_guard(mutex_), buffer_.empty(); }
bool DecodeThread::drained() const { return std::lock_guard(mutex_), buffer_.drained(); }
bool DecodeThread::starved() const { return std::lock_guard(mutex_), starved_; }
std::size_t DecodeThread::buffered() const { return std::lock_guard(mutex_), buffer_.size(); }
std::uint64_t DecodeThread::dropped() const { return std::lock_guard(mutex_), buffer_.dropped() + skipped_; }

}  // namespace mien::player
