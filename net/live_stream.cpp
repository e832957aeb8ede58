#include "net/live_stream.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <utility>

#include "core/byte_io.hpp"

namespace mien::net {

namespace {

Error refuse(std::string why) { return {ErrorCode::invalid, std::move(why)}; }

/// A whole message again from its parts.
Bytes whole(const RawMessage& raw) {
    ByteWriter out;
    out.u8(raw.type);
    out.varint(raw.body.size());
    out.bytes(raw.body);
    return out.take();
}

}  // namespace

LiveStream::LiveStream(std::string name, protocol::StreamHeader header, protocol::Catalogue catalogue, std::uint64_t ring_bytes)
    : name_(std::move(name)), header_(std::move(header)), catalogue_(std::move(catalogue)), ring_bytes_(ring_bytes) {
    for (const protocol::Track& track : header_.tracks)
        for (const protocol::Rung& rung : track.rungs) {
            Slot& slot = slots_[rung.slot];
            slot.visual = track.kind != protocol::TrackKind::sound;
            if (const auto* sound = std::get_if<protocol::SoundInfo>(&track.info)) slot.packet_ticks = sound->packet_samples;
        }
}

bool LiveStream::same_as(const protocol::StreamHeader& header, const protocol::Catalogue& catalogue) const {
    return protocol::encode(header) == protocol::encode(header_) && protocol::encode(catalogue) == protocol::encode(catalogue_);
}

std::vector<Hash> LiveStream::missing() const {
    std::vector<Hash> hashes;
    for (const protocol::BlobInfo& info : catalogue_.blobs)
        if (!blobs.contains(info.hash)) hashes.push_back(info.hash);
    return hashes;
}

void LiveStream::set_live(bool live) {
    live_ = live;
    if (live) {
        // What one publisher has begun nobody else can go on with.
        for (auto& [number, slot] : slots_) slot.group.reset();
        least_group_ = next_group_;
        group_start_ = first_ + records_.size();
    }
    ring();
}

void LiveStream::supersede() {
    superseded_ = true;
    ring();
}

Result<void> LiveStream::start_group(const protocol::GroupStart& start) {
    const auto found = slots_.find(start.slot);
    if (found == slots_.end()) return refuse(fmt::format("the header names no slot {}", start.slot));
    Slot& slot = found->second;
    // Groups of all slots with one number belong together, so only the newest may still get others.
    const bool goes_back = slot.group ? start.group <= *slot.group : false;
    if (goes_back || start.group < least_group_ || start.group + 1 < next_group_) return refuse(fmt::format("group {} of slot {} comes too late", start.group, start.slot));
    if (slot.visual && start.first_time < slot.next_time)
        return refuse(fmt::format("group {} of slot {} begins before the last one ends", start.group, start.slot));
    slot.group = start.group;
    slot.frames = start.frames;
    slot.next_time = start.first_time;
    if (start.group >= next_group_) {
        next_group_ = start.group + 1;
        group_start_ = first_ + records_.size();
    }
    keep({start.slot, true, start.group, std::make_shared<const Bytes>(protocol::encode(start))});
    return {};
}

Result<void> LiveStream::append(const protocol::LiveBytes& object) {
    const auto found = slots_.find(object.slot);
    if (found == slots_.end() || !found->second.group) return refuse(fmt::format("an object of slot {} without a group", object.slot));
    Slot& slot = found->second;
    if (slot.next_time > protocol::kMaxTicks) return refuse("its time is impossible");
    slot.next_time += std::int64_t(slot.frames) * slot.packet_ticks;
    keep({object.slot, false, *slot.group, std::make_shared<const Bytes>(protocol::encode(object))});
    return {};
}

void LiveStream::keep(Record record) {
    bytes_ += record.message->size();
    records_.push_back(std::move(record));
    // Whole groups go first, all but the newest and the one before it; then whatever is oldest.
    while (!records_.empty() && (bytes_ > ring_bytes_ || records_.front().group + 2 < next_group_)) {
        bytes_ -= records_.front().message->size();
        records_.pop_front();
        ++first_;
    }
    ring();
}

void LiveStream::ring() const {
    for (asio::steady_timer* bell : bells_) bell->cancel();
}

const LiveStream::Record* LiveStream::at(std::uint64_t number) const {
    return number - first_ < records_.size() ? &records_[std::size_t(number - first_)] : nullptr;
}

std::uint64_t LiveStream::newest() const {
    const std::uint64_t next = first_ + records_.size();
    return live_ && group_start_ >= first_ ? std::min(group_start_, next) : next;
}

std::uint32_t LiveStream::newest_group() const {
    const Record* record = at(newest());
    return record ? record->group : next_group_;
}

std::uint64_t LiveStream::frames() const {
    std::int64_t most = 0;
    for (const auto& [number, slot] : slots_)
        if (slot.visual) most = std::max(most, slot.next_time);
    return std::uint64_t(most);
}

// ---- by name ----

std::shared_ptr<LiveStream> LiveStreams::find(const std::string& name) const {
    const auto found = streams_.find(name);
    auto stream = found == streams_.end() ? nullptr : found->second.lock();
    return stream && stream->live() ? stream : nullptr;
}

std::vector<protocol::StreamEntry> LiveStreams::list() const {
    std::vector<protocol::StreamEntry> entries;
    for (const auto& [name, weak] : streams_)
        if (const auto stream = weak.lock(); stream && stream->live())
            entries.push_back({.name = name, .frame_rate = stream->header().frame_rate, .frames = 0, .live = true});
    return entries;
}

std::shared_ptr<LiveStream> LiveStreams::resume(const std::string& name, protocol::StreamHeader header, protocol::Catalogue catalogue,
                                                std::uint64_t ring_bytes) {
    const auto found = streams_.find(name);
    if (found != streams_.end())
        if (auto stream = found->second.lock(); stream && stream->same_as(header, catalogue)) return stream;
    return std::make_shared<LiveStream>(name, std::move(header), std::move(catalogue), ring_bytes);
}

void LiveStreams::show(const std::shared_ptr<LiveStream>& stream) {
    std::erase_if(streams_, [](const auto& entry) { return entry.second.expired(); });
    auto& place = streams_[stream->name()];
    if (const auto before = place.lock(); before && before != stream) before->supersede();
    place = stream;
    stream->set_live(true);
}

// ---- what a publisher sends ----

Publication::~Publication() {
    if (stage_ == Stage::streaming) stream_->set_live(false);
    streams_.release(name_);
}

std::uint64_t Publication::limit() const {
    switch (stage_) {
        case Stage::header:
        case Stage::catalogue: return kMaxFront;
        case Stage::blobs: return protocol::kMaxMessageBytes;
        case Stage::streaming: return std::min<std::uint64_t>(ring_bytes_, protocol::kMaxObjectBytes);
        case Stage::ended: break;
    }
    return protocol::kMaxControlBytes;
}

Result<std::vector<protocol::Message>> Publication::take(const protocol::Message& message, const RawMessage& raw) {
    std::vector<protocol::Message> nothing;
    const auto misplaced = [&] { return refuse("a publisher's " + protocol::name_of(raw.type) + " has no place here"); };
    switch (stage_) {
        case Stage::header: {
            const auto* header = std::get_if<protocol::StreamHeader>(&message);
            if (!header) return misplaced();
            if (header->frames != 0) return refuse("the header of a live stream must not say how many frames there will be");
            if (header->tracks.empty()) return refuse("the stream has no track");
            header_ = *header;
            stage_ = Stage::catalogue;
            return nothing;
        }
        case Stage::catalogue: {
            const auto* catalogue = std::get_if<protocol::Catalogue>(&message);
            if (!catalogue) return misplaced();
            return take_catalogue(*catalogue);
        }
        case Stage::blobs: {
            const auto* blob = std::get_if<protocol::StaticBlob>(&message);
            if (!blob) return misplaced();
            return take_blob(*blob, raw);
        }
        case Stage::streaming: {
            if (const auto* start = std::get_if<protocol::GroupStart>(&message)) {
                MIEN_CHECK(stream_->start_group(*start));
            } else if (const auto* object = std::get_if<protocol::LiveBytes>(&message)) {
                MIEN_CHECK(stream_->append(*object));
            } else if (std::holds_alternative<protocol::End>(message)) {
                stage_ = Stage::ended;
                stream_->set_live(false);
            } else {
                return misplaced();
            }
            return nothing;
        }
        case Stage::ended: break;
    }
    return misplaced();
}

Result<std::vector<protocol::Message>> Publication::take_catalogue(const protocol::Catalogue& catalogue) {
    std::uint64_t bytes = 0;
    for (const protocol::BlobInfo& info : catalogue.blobs) bytes += info.size;
    if (bytes > kMaxBlobs) return Error{ErrorCode::limit_exceeded, fmt::format("{} bytes of static blobs; at most {} are taken", bytes, kMaxBlobs)};
    const auto has = [&](const Hash& hash) { return std::ranges::find(catalogue.blobs, hash, &protocol::BlobInfo::hash) != catalogue.blobs.end(); };
    bool all = has(header_.model);
    for (const protocol::Track& track : header_.tracks)
        for (const protocol::Rung& rung : track.rungs) all = all && (!rung.basis || has(*rung.basis));
    if (!all) return refuse("the catalogue lacks a static blob that the header names");
    stream_ = streams_.resume(name_, std::move(header_), catalogue, ring_bytes_);
    const std::vector<Hash> missing = stream_->missing();
    awaited_.assign(missing.begin(), missing.end());
    stage_ = Stage::blobs;
    std::vector<protocol::Message> answers{protocol::Want{missing}};
    if (awaited_.empty()) answers.push_back(go_live());
    return answers;
}

Result<std::vector<protocol::Message>> Publication::take_blob(const protocol::StaticBlob& blob, const RawMessage& raw) {
    const auto& infos = stream_->catalogue().blobs;
    const auto info = std::ranges::find(infos, blob.hash, &protocol::BlobInfo::hash);
    if (blob.hash != awaited_.front() || info->kind != blob.kind || info->size != blob.bytes.size())
        return refuse("a static blob that was not asked for, or not as the catalogue says");
    stream_->blobs[blob.hash] = std::make_shared<const Bytes>(whole(raw));
    awaited_.pop_front();
    std::vector<protocol::Message> answers;
    if (awaited_.empty()) answers.push_back(go_live());
    return answers;
}

protocol::Message Publication::go_live() {
    stage_ = Stage::streaming;
    streams_.show(stream_);
    return protocol::Publishing{stream_->next_group(), stream_->frames()};
}

}  // namespace mien::net
