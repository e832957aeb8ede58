#include "tools/live_session.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

namespace mien::tools {
namespace {

constexpr std::uint8_t kSoundSlot = 1;
constexpr double kSlip = 0.03;           // seconds that sound and pictures may come apart
constexpr double kLongestStill = 2;      // seconds that sound goes on without a frame

}  // namespace

LiveSession::LiveSession(const StoredTake& take, const LiveOptions& options, std::optional<encoder::LiveSound> sound)
    : motion_(take.take, take.reference, {}, take.model.model.neutral.triangles, take.model.model.neutral.mirror),
      counter_(std::max<std::int64_t>(1, std::llround(options.frame_rate.value_or(take.header.frame_rate).value()))) {
    sound_ = std::move(sound);
    header_.name = options.name;
    header_.frame_rate = options.frame_rate.value_or(take.header.frame_rate);
    header_.frames = 0;
    header_.group_frames = std::uint32_t(std::max<std::int64_t>(1, std::llround(options.group_seconds * header_.frame_rate.value())));
    header_.unit = take.header.unit;
    header_.model = take.model.manifest;
    const Hash basis = sha256(motion_.basis());
    protocol::Rung rung;
    rung.codec = "motion";
    rung.basis = basis;
    header_.tracks.push_back({protocol::TrackKind::motion, "motion", header_.frame_rate.inverse(), motion_.info(), {std::move(rung)}});
    std::vector<protocol::StaticBlob> blobs = take.model.blobs;
    blobs.push_back({basis, protocol::BlobKind::motion_basis, motion_.basis()});
    if (sound_) {
        protocol::Rung voice;
        voice.slot = kSoundSlot;
        voice.codec = "opus";
        voice.codec_config = sound_->codec_config();
        header_.tracks.push_back({protocol::TrackKind::sound, "sound", make_rational(1, sound_->info().sample_rate), sound_->info(), {std::move(voice)}});
        before_.assign(sound_->lead().begin(), sound_->lead().end());
    }
    if (!options.recording.empty()) recording_.emplace(options.recording, header_, blobs);
    if (!options.url) return;
    net::PublisherOptions publishing;
    publishing.software = "mien live";
    publishing.on_status = options.on_status;
    publisher_ = std::make_unique<net::Publisher>(*options.url, header_, std::move(blobs), std::move(publishing));
}

Result<std::unique_ptr<LiveSession>> LiveSession::start(const StoredTake& take, const LiveOptions& options) {
    std::optional<encoder::LiveSound> sound;
    if (options.sound) {
        MIEN_TRY(opened, encoder::LiveSound::open(*options.sound));
        sound.emplace(std::move(opened));
    }
    std::unique_ptr<LiveSession> session(new LiveSession(take, options, std::move(sound)));
    if (session->publisher_) MIEN_CHECK(session->publisher_->wait_ready(options.connect));
    return session;
}

Result<void> LiveSession::add(const Captured& captured, double now) {
    const std::lock_guard lock(mutex_);
    MIEN_CHECK(encoder::check_frame(captured.frame, motion_.info()));
    std::int64_t step = 1;
    if (captured.sequence) {
        const auto counted = counter_.step(*captured.sequence);
        if (!counted) return ++late_, Result<void>();
        step = *counted;
    }
    if (last_)
        for (; step > 1; --step, ++lost_) MIEN_CHECK(code(*last_));
    MIEN_CHECK(code(captured.frame));
    last_ = captured.frame;
    arrivals_.arrived(double(frame_ - 1) / header_.frame_rate.value(), now);
    return {};
}

Result<void> LiveSession::code(const encoder::MotionFrame& frame) {
    const std::int64_t per_group = header_.group_frames;
    const bool starts = frame_ % per_group == 0;
    if (starts) motion_.begin_group();
    MIEN_TRY(object, motion_.encode(frame));
    if (starts) {
        const auto number = std::uint32_t(frame_ / per_group);
        record();
        group_ = {.slot = 0, .group = number, .first_time = frame_, .objects = {}};
        if (publisher_) publisher_->start_group({0, number, frame_, 1});
    }
    if (publisher_) publisher_->send({0, object.bytes});
    if (recording_) group_.objects.push_back(std::move(object));
    ++frame_;
    return {};
}

Result<void> LiveSession::add_sound(const CapturedSound& captured, double now) {
    const std::lock_guard lock(mutex_);
    MIEN_TRY(packets, sound_->add(captured.first, captured.sound));
    const double rate = captured.sound.sample_rate;
    sound_arrivals_.arrived(double(captured.first + captured.sound.length()) / rate, now);   // a sample has been captured when its packet leaves
    const auto frames = arrivals_.zero();
    for (encoder::LiveSound::Packet& packet : packets) {
        if (frames) take(std::move(packet), *sound_arrivals_.zero() - *frames);
        else before_.push_back(std::move(packet.bytes)), before_.pop_front();
    }
    return {};
}

/// One packet of sound; `zero`: seconds of the stream at which the sender's sample 0 was captured.
void LiveSession::take(encoder::LiveSound::Packet packet, double zero) {
    const protocol::SoundInfo info = sound_->info();
    const auto number = std::uint32_t((frame_ - 1) / header_.group_frames);
    const std::int64_t due = packet.position + std::llround(zero * info.sample_rate);
    // Where no frames come time stands still, and what is said then has no place in it.
    const bool too_far = double(due) / info.sample_rate > double(frame_) / header_.frame_rate.value() + kLongestStill;
    sound_astray_ = sound_astray_ || packet.anew || too_far;
    if (!too_far && (sound_group_.objects.empty() || sound_group_.group != number)) {
        // Inside a group packets follow each other; what has drifted away from the pictures is put right where one begins.
        if (sound_astray_ || std::abs(double(due - sound_time_)) > kSlip * info.sample_rate) sound_time_ = due;
        sound_astray_ = false;
        if (sound_time_ >= 0) start_sound_group(number);
    }
    if (!sound_group_.objects.empty() && !sound_astray_) {
        if (publisher_) publisher_->send({kSoundSlot, packet.bytes});
        sound_group_.objects.push_back({1, packet.bytes});
    }
    sound_time_ += info.packet_samples;
    before_.push_back(std::move(packet.bytes));
    before_.pop_front();
}

void LiveSession::start_sound_group(std::uint32_t number) {
    sound_group_ = {.slot = kSoundSlot, .group = number, .first_time = sound_time_, .objects = {}};
    if (publisher_) publisher_->start_group({kSoundSlot, number, sound_time_, 1});
    for (const Bytes& packet : before_) {
        if (publisher_) publisher_->send({kSoundSlot, packet});
        sound_group_.objects.push_back({1, packet});
    }
}

/// The group that is over; its sound is all there will be of it.
void LiveSession::record() {
    if (recording_ && !group_.objects.empty()) {
        recording_->add(group_);
        if (!sound_group_.objects.empty() && sound_group_.group == group_.group) recording_->add(sound_group_);
    }
    sound_group_ = {};
}

void LiveSession::finish() {
    const std::lock_guard lock(mutex_);
    publisher_.reset();
    if (!recording_) return;
    record();
    recording_->finish(std::uint64_t(frame_));
    recording_.reset();
}

}  // namespace mien::tools
