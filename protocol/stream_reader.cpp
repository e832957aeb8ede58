#include <fmt/format.h>

#include <algorithm>
#include <cassert>

#include "core/byte_io.hpp"
#include "protocol/scan.hpp"
#include "protocol/stream_file.hpp"

namespace mien::protocol {

namespace {

/// "the static blob 1a2b3c4d (shape)"
std::string describe(const BlobInfo& blob) {
    return fmt::format("the static blob {} ({})", blob.hash.hex().substr(0, 8), name_of(blob.kind));
}

/// The track and rung with this slot; null when the header names none.
const Track* track_of(const StreamHeader& header, std::uint8_t slot) {
    for (const Track& track : header.tracks)
        for (const Rung& rung : track.rungs)
            if (rung.slot == slot) return &track;
    return nullptr;
}

/// Seeking goes by the first rung of the first visual track; in a stream of sound alone by that. A model without tracks has no groups.
std::uint8_t marking_slot(const StreamHeader& header) {
    for (const Track& track : header.tracks)
        if (track.kind != TrackKind::sound) return track.rungs.front().slot;
    return header.tracks.empty() ? std::uint8_t(0) : header.tracks.front().rungs.front().slot;
}

auto order_of(const IndexEntry& entry) { return std::pair(entry.group, entry.slot); }

}  // namespace

Result<StreamFileReader> StreamFileReader::open(ReadAt read_at, std::uint64_t file_size) {
    StreamFileReader reader;
    reader.read_at_ = std::move(read_at);
    reader.file_size_ = file_size;
    MIEN_CHECK(reader.read_front());
    if (auto stored = reader.read_stored_index(); !stored) {
        reader.complaint_ = stored.error().message;
        reader.rebuild_index();
    }
    return reader;
}

Result<Bytes> StreamFileReader::read(std::uint64_t offset, std::uint64_t size) const {
    if (offset > file_size_ || size > file_size_ - offset) return Error{ErrorCode::truncated, "the file ends early"};
    Bytes bytes(size);
    MIEN_TRY(got, read_at_(offset, bytes));
    if (got != size) return Error{ErrorCode::truncated, "the file has become shorter while it was read"};
    return bytes;
}

Result<MessageHead> StreamFileReader::read_head(std::uint64_t offset) const {
    if (offset >= file_size_) return Error{ErrorCode::truncated, "the file ends early"};
    MIEN_TRY(bytes, read(offset, std::min<std::uint64_t>(kMaxHeadBytes, file_size_ - offset)));
    return parse_head(bytes);
}

Result<Message> StreamFileReader::read_message(std::uint64_t offset, MessageType type, std::uint64_t& next) const {
    MIEN_TRY(head, read_head(offset));
    if (head.type != static_cast<std::uint8_t>(type))
        return Error{ErrorCode::damaged, fmt::format("{} stands in its place", name_of(head.type))};
    MIEN_TRY(body, read(offset + head.size, head.body));
    next = offset + head.total();
    return parse_body(head.type, body);
}

Result<void> StreamFileReader::read_front() {
    // The first bytes tell a foreign file from a damaged one.
    MIEN_TRY(start, read(0, std::min<std::uint64_t>(file_size_, 16)));
    const auto head = parse_head(start);
    const auto foreign = Error{ErrorCode::bad_magic, "this is not a mien stream"};
    if (!head || head->type != static_cast<std::uint8_t>(MessageType::header)) return foreign;
    constexpr std::string_view magic = "mien";
    if (start.size() < head->size + magic.size())
        return Error{ErrorCode::truncated, "the stream header: the file ends early"};
    if (!std::ranges::equal(ByteView(start).subspan(head->size, magic.size()), std::as_bytes(std::span(magic)))) return foreign;

    std::uint64_t at = 0;
    auto header = read_message(0, MessageType::header, at);
    if (!header) {
        // Another version may lay out all that follows in its own way, so its name comes before any other complaint.
        ByteReader version(ByteView(start).subspan(head->size + magic.size()));
        const std::uint64_t number = version.varint();
        if (version.ok() && number != kVersion)
            return Error{ErrorCode::unsupported_version,
                         fmt::format("the stream has format version {}, this program reads version {}", number, kVersion)};
        return Error{header.error().code, "the stream header: " + header.error().message};
    }
    header_ = std::get<StreamHeader>(std::move(*header));
    auto catalogue = read_message(at, MessageType::catalogue, at);
    if (!catalogue) return Error{catalogue.error().code, "the catalogue: " + catalogue.error().message};
    catalogue_ = std::get<Catalogue>(std::move(*catalogue));
    MIEN_CHECK(read_blob_places(at));

    MIEN_TRY(manifest, blob(header_.model));
    MIEN_TRY(parsed, parse_manifest(manifest));
    manifest_ = std::move(parsed);
    return {};
}

Result<void> StreamFileReader::read_blob_places(std::uint64_t at) {
    // BLOBs stand in catalogue order, so a damaged one is known by name.
    const BlobInfo* before = nullptr;
    for (const BlobInfo& info : catalogue_.blobs) {
        const auto refuse = [&](const Error& why) {
            // What looks wrong here may be the length of the one before.
            if (before)
                if (auto previous = blob(before->hash); !previous) return previous.error();
            return Error{why.code, describe(info) + ": " + why.message};
        };
        auto head = read_head(at);
        if (!head) return refuse(head.error());
        if (head->type != static_cast<std::uint8_t>(MessageType::blob))
            return refuse({ErrorCode::damaged, fmt::format("{} stands in its place", name_of(head->type))});
        if (head->total() > file_size_ - at) return refuse({ErrorCode::truncated, "the file ends early"});
        auto start = read(at + head->size, std::min<std::uint64_t>(head->body, kMaxBlobHeadBytes));
        if (!start) return refuse(start.error());
        auto stored = parse_blob_head(*start);
        if (!stored) return refuse(stored.error());
        if (stored->hash != info.hash || stored->kind != info.kind || stored->unpacked != info.size)
            return refuse({ErrorCode::damaged, "its hash, kind or size is not what the catalogue says"});
        blobs_[info.hash] = {at, head->total(), *stored};
        before = &info;
        at += head->total();
    }
    front_ = at;
    return {};
}

Result<Bytes> StreamFileReader::blob_message(const Hash& hash) const {
    const auto found = blobs_.find(hash);
    if (found == blobs_.end())
        return Error{ErrorCode::missing, fmt::format("the stream has no static blob {}", hash.hex().substr(0, 8))};
    return read(found->second.offset, found->second.size);
}

Result<BlobPart> StreamFileReader::blob_part(const Hash& hash, std::uint64_t offset, std::uint32_t bytes) const {
    const auto found = blobs_.find(hash);
    if (found == blobs_.end())
        return Error{ErrorCode::missing, fmt::format("the stream has no static blob {}", hash.hex().substr(0, 8))};
    const std::uint64_t total = found->second.size;
    if (offset >= total) return Error{ErrorCode::invalid, fmt::format("static blob {} has no byte {}", hash.hex().substr(0, 8), offset)};
    MIEN_TRY(part, read(found->second.offset + offset, std::min<std::uint64_t>(bytes, total - offset)));
    return BlobPart{total, std::move(part)};
}

Result<Bytes> StreamFileReader::blob(const Hash& hash) const {
    MIEN_TRY(bytes, blob_message(hash));
    auto message = parse_message(bytes);
    if (!message) {
        const BlobHead& head = blobs_.at(hash).head;
        return Error{message.error().code, describe({hash, head.kind, 0}) + ": " + message.error().message};
    }
    return std::move(std::get<StaticBlob>(*message).bytes);
}

Result<void> StreamFileReader::read_stored_index() {
    const auto say = [](const Error& why) { return Error{why.code, "the index cannot be used: " + why.message}; };
    if (file_size_ - front_ < kTrailerBytes) return Error{ErrorCode::truncated, "the file ends before its index"};
    std::uint64_t end = 0;
    auto trailer = read_message(file_size_ - kTrailerBytes, MessageType::trailer, end);
    if (!trailer) return Error{trailer.error().code, "the file does not end as it should (with its TRAILER): it is cut, or damaged there"};
    const std::uint64_t offset = std::get<Trailer>(*trailer).index_offset;
    if (offset < front_ || offset >= file_size_ - kTrailerBytes) return say({ErrorCode::damaged, "the trailer points astray"});
    auto index = read_message(offset, MessageType::index, end);
    if (!index) return say(index.error());
    if (end != file_size_ - kTrailerBytes) return say({ErrorCode::damaged, "it does not reach to the trailer"});
    if (auto check = check_index(std::get<Index>(*index), offset); !check) return say(check.error());
    use_index(std::move(std::get<Index>(*index).entries));
    return {};
}

Result<void> StreamFileReader::check_index(const Index& index, std::uint64_t end) const {
    std::uint64_t at = front_;
    for (std::size_t e = 0; e < index.entries.size(); ++e) {
        const IndexEntry& entry = index.entries[e];
        const bool ordered = e == 0 || order_of(index.entries[e - 1]) < order_of(entry);
        if (!ordered || !track_of(header_, entry.slot) || entry.offset < at || entry.size > end ||
            entry.offset > end - entry.size)
            return Error{ErrorCode::damaged, fmt::format("entry {} is impossible", e)};
        at = entry.offset + entry.size;
    }
    std::uint64_t next = 0;
    auto last = read_message(at, MessageType::end, next);
    if (!last || next != end) return Error{ErrorCode::damaged, "END does not stand between the last group and the index"};
    return {};
}

void StreamFileReader::rebuild_index() {
    ScanResult found = scan_groups(
        [&](std::uint64_t offset, std::uint64_t size) { return read(offset, size); }, front_, file_size_,
        [&](std::uint8_t slot) { return track_of(header_, slot) != nullptr; });
    cut_ = found.cut;
    use_index(std::move(found.entries));
}

void StreamFileReader::use_index(std::vector<IndexEntry> entries) {
    index_ = std::move(entries);
    const std::uint8_t marking = marking_slot(header_);
    for (const IndexEntry& entry : index_) {
        if (groups_.empty() || groups_.back() != entry.group) groups_.push_back(entry.group);
        if (entry.slot == marking && (marks_.empty() || marks_.back().first_time <= entry.first_time)) marks_.push_back(entry);
    }
}

const IndexEntry* StreamFileReader::find(std::uint8_t slot, std::uint32_t group) const {
    const auto at = std::ranges::lower_bound(index_, std::pair(group, slot), {}, order_of);
    return at != index_.end() && at->slot == slot && at->group == group ? &*at : nullptr;
}

std::size_t StreamFileReader::first_entry(std::uint32_t group) const {
    return std::size_t(std::ranges::lower_bound(index_, group, {}, &IndexEntry::group) - index_.begin());
}

double StreamFileReader::start_of(const IndexEntry& entry) const {
    const Track* track = track_of(header_, entry.slot);
    assert(track);
    return double(entry.first_time) * track->time_base.value();
}

std::uint32_t StreamFileReader::group_at(double seconds) const {
    constexpr double tolerance = 1e-6;  // times cross the wire in whole microseconds
    const auto after = std::ranges::upper_bound(marks_, seconds + tolerance, {},
                                                [&](const IndexEntry& entry) { return start_of(entry); });
    if (after != marks_.begin()) return std::prev(after)->group;
    return groups_.empty() ? 0 : groups_.front();
}

double StreamFileReader::seconds() const {
    if (header_.frames != 0) return double(header_.frames) / header_.frame_rate.value();
    return marks_.empty() ? 0 : start_of(marks_.back()) + header_.group_frames / header_.frame_rate.value();
}

Result<Group> StreamFileReader::read_group(std::uint8_t slot, std::uint32_t group) const {
    const IndexEntry* entry = find(slot, group);
    if (!entry) return Error{ErrorCode::missing, fmt::format("the stream has no group {} of slot {}", group, slot)};
    return read_group(*entry);
}

Result<Group> StreamFileReader::read_group(const IndexEntry& entry) const {
    const auto say = [&](const Error& why) {
        return Error{why.code, fmt::format("group {} of slot {}: {}", entry.group, entry.slot, why.message)};
    };
    auto bytes = read(entry.offset, entry.size);
    if (!bytes) return say(bytes.error());
    auto head = parse_head(*bytes);
    const bool cut = is_cut(entry);
    if (!head || head->type != static_cast<std::uint8_t>(MessageType::group) || (head->total() != entry.size && !cut))
        return say({ErrorCode::damaged, "its type or length is damaged"});
    const ByteView body = ByteView(*bytes).subspan(head->size);
    auto parsed = cut ? parse_cut_group(body, head->body) : [&]() -> Result<Group> {
        auto message = parse_body(head->type, body);
        if (!message) return message.error();
        return std::get<Group>(std::move(*message));
    }();
    if (!parsed) return say(parsed.error());
    if (parsed->slot != entry.slot || parsed->group != entry.group || parsed->first_time != entry.first_time)
        return say({ErrorCode::damaged, "another group stands in its place"});
    return parsed;
}

Result<Bytes> StreamFileReader::group_message(const IndexEntry& entry) const {
    if (is_cut(entry)) {
        MIEN_TRY(group, read_group(entry));
        return encode(group);
    }
    MIEN_TRY(bytes, read(entry.offset, entry.size));
    auto head = parse_head(bytes);
    if (!head || head->type != static_cast<std::uint8_t>(MessageType::group) || head->total() != entry.size)
        return Error{ErrorCode::damaged,
                     fmt::format("group {} of slot {}: its type or length is damaged", entry.group, entry.slot)};
    return std::move(bytes);
}

Result<StreamFileReader::Accounting> StreamFileReader::account() const {
    Accounting sum;
    sum.total = file_size_;
    std::uint64_t payload = 0;
    for (const BlobInfo& info : catalogue_.blobs) {
        const StoredBlob& stored = blobs_.at(info.hash);
        MIEN_TRY(head, read_head(stored.offset));
        const std::uint64_t content = head.body - stored.head.size;
        sum.blobs.push_back({info, content});
        payload += content;
    }
    std::uint64_t after = front_;
    for (const IndexEntry& entry : index_) {
        Accounting::Slot& slot = sum.slots[entry.slot];
        ++slot.groups;
        slot.objects += entry.objects;
        std::uint64_t objects = 0;
        if (auto group = read_group(entry); group)
            for (const Object& object : group->objects) objects += object.bytes.size();
        else
            ++slot.damaged;
        slot.payload += objects;
        payload += objects;
        sum.group_framing += entry.size - objects;
        after = entry.offset + entry.size;
    }
    if (complete()) sum.group_framing += file_size_ - after;
    sum.framing = file_size_ - payload;
    return sum;
}

}  // namespace mien::protocol
