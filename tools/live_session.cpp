#include "tools/live_session.hpp"

#include <algorithm>
#include <cmath>

namespace mien::tools {

LiveSession::LiveSession(const StoredTake& take, const LiveOptions& options)
    : motion_(take.take, take.reference, {}, take.model.model.neutral.triangles, take.model.model.neutral.mirror),
      counter_(std::max<std::int64_t>(1, std::llround(options.frame_rate.value_or(take.header.frame_rate).value()))) {
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
    if (!options.recording.empty()) recording_.emplace(options.recording, header_, blobs);
    if (!options.url) return;
    net::PublisherOptions publishing;
    publishing.software = "mien live";
    publishing.on_status = options.on_status;
    publisher_ = std::make_unique<net::Publisher>(*options.url, header_, std::move(blobs), std::move(publishing));
}

Result<std::unique_ptr<LiveSession>> LiveSession::start(const StoredTake& take, const LiveOptions& options) {
    std::unique_ptr<LiveSession> session(new LiveSession(take, options));
    if (session->publisher_) MIEN_CHECK(session->publisher_->wait_ready(options.connect));
    return session;
}

Result<void> LiveSession::add(const Captured& captured) {
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
    return {};
}

Result<void> LiveSession::code(const encoder::MotionFrame& frame) {
    const std::int64_t per_group = header_.group_frames;
    const bool starts = frame_ % per_group == 0;
    if (starts) motion_.begin_group();
    MIEN_TRY(object, motion_.encode(frame));
    if (starts) {
        const auto number = std::uint32_t(frame_ / per_group);
        if (recording_ && !group_.objects.empty()) recording_->add(group_);
        group_ = {.slot = 0, .group = number, .first_time = frame_, .objects = {}};
        if (publisher_) publisher_->start_group({0, number, frame_, 1});
    }
    if (publisher_) publisher_->send({0, object.bytes});
    if (recording_) group_.objects.push_back(std::move(object));
    ++frame_;
    return {};
}

void LiveSession::finish() {
    publisher_.reset();
    if (!recording_) return;
    if (!group_.objects.empty()) recording_->add(group_);
    recording_->finish(std::uint64_t(frame_));
    recording_.reset();
}

}  // namespace mien::tools
