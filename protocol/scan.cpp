#include "protocol/scan.hpp"

#include <algorithm>
#include <optional>

#include "core/byte_io.hpp"

namespace mien::protocol {

namespace {

constexpr std::uint64_t kChunk = 1u << 20;
constexpr std::uint32_t kFarthestGroup = 1u << 16;  // a group further ahead than 18 hours at 1 s is taken for damage

class Scanner {
public:
    Scanner(const ReadExactly& read, std::uint64_t begin, std::uint64_t end, const std::function<bool(std::uint8_t)>& known)
        : read_(read), at_(begin), end_(end), known_(known), budget_(4 * (end - begin) + kChunk) {}

    ScanResult run() {
        while (at_ < end_) {
            if (closing(at_)) break;
            const std::optional<Found> group = group_at(at_);
            if (group && whole(*group)) {
                if (sound(*group)) {
                    take(*group);
                    continue;
                }
                if (followed(*group)) {
                    at_ += group->head.total();
                    continue;
                }
            }
            // Cut by the end of the file, or damaged: only damage has sound groups behind it.
            if (const std::optional<Found> next = next_sound_group(at_ + 1)) {
                take(*next);
                continue;
            }
            if (group && !whole(*group)) take_cut(*group);
            break;
        }
        return std::move(result_);
    }

private:
    struct Found {
        std::uint64_t offset = 0;
        MessageHead head;
        GroupHead group;
    };

    /// A sound END, INDEX or TRAILER: no group follows.
    bool closing(std::uint64_t offset) const {
        const auto bytes = read_(offset, std::min<std::uint64_t>(kMaxHeadBytes, end_ - offset));
        if (!bytes) return false;
        const auto head = parse_head(*bytes);
        if (!head || head->total() > end_ - offset) return false;
        const auto type = static_cast<MessageType>(head->type);
        if (type != MessageType::end && type != MessageType::index && type != MessageType::trailer) return false;
        const auto body = read_(offset + head->size, head->body);
        return body && parse_body(head->type, *body).ok();
    }

    /// A group that could stand at `offset`, by its head alone.
    std::optional<Found> group_at(std::uint64_t offset) const {
        const auto bytes = read_(offset, std::min<std::uint64_t>(kMaxHeadBytes + kMaxGroupHeadBytes, end_ - offset));
        return bytes ? group_in(*bytes, offset) : std::nullopt;
    }
    std::optional<Found> group_in(ByteView bytes, std::uint64_t offset) const {
        const auto head = parse_head(bytes);
        if (!head || head->type != static_cast<std::uint8_t>(MessageType::group)) return {};
        const ByteView body = bytes.subspan(head->size);
        const auto group = parse_group_head(body.first(std::min<std::uint64_t>(body.size(), head->body)));
        if (!group || !known_(group->slot)) return {};
        if (!result_.entries.empty()) {
            const IndexEntry& last = result_.entries.back();
            if (std::pair(group->group, group->slot) <= std::pair(last.group, last.slot)) return {};
            if (group->group - last.group > kFarthestGroup) return {};
        }
        return Found{offset, *head, *group};
    }

    bool whole(const Found& found) const { return found.head.total() <= end_ - found.offset; }

    bool sound(const Found& found) const {
        const auto body = read_(found.offset + found.head.size, found.head.body);
        if (!body) return false;
        ByteReader in(*body);
        const std::uint32_t crc = in.u32();
        return in.ok() && crc == crc32c(ByteView(*body).subspan(in.position()));
    }

    /// Its checksum fails but its length leads to another message: the damage is inside. The group is lost, and as its slot
    /// and number may be what is wrong, it gets no entry.
    bool followed(const Found& found) const {
        const std::uint64_t next = found.offset + found.head.total();
        return next == end_ || group_at(next) || closing(next);
    }

    /// The first group from `offset` on whose checksum is sound. The work is bounded: crafted bytes could otherwise make
    /// every position look like the head of a long group.
    std::optional<Found> next_sound_group(std::uint64_t offset) {
        constexpr std::uint64_t overlap = kMaxHeadBytes + kMaxGroupHeadBytes;
        while (offset < end_) {
            const std::uint64_t size = std::min(kChunk + overlap, end_ - offset);
            const auto bytes = read_(offset, size);
            if (!bytes) return {};
            const std::uint64_t positions = std::min(kChunk, size);
            for (std::uint64_t p = 0; p < positions; ++p) {
                if ((*bytes)[p] != std::byte(MessageType::group)) continue;
                const auto found = group_in(ByteView(*bytes).subspan(p, std::min(overlap, size - p)), offset + p);
                if (!found || !whole(*found)) continue;
                if (found->head.total() > budget_) return {};
                budget_ -= found->head.total();
                if (sound(*found)) return found;
            }
            offset += positions;
        }
        return {};
    }

    void take(const Found& found) {
        result_.entries.push_back({found.group.slot, found.group.group, found.group.first_time, found.group.objects,
                                   found.offset, found.head.total()});
        at_ = found.offset + found.head.total();
    }

    void take_cut(const Found& found) {
        const auto body = read_(found.offset + found.head.size, end_ - found.offset - found.head.size);
        if (!body) return;
        const auto group = parse_cut_group(*body, found.head.body);
        if (!group) return;
        result_.entries.push_back({group->slot, group->group, group->first_time,
                                   static_cast<std::uint32_t>(group->objects.size()), found.offset, end_ - found.offset});
        result_.cut = found.offset;
    }

    const ReadExactly& read_;
    std::uint64_t at_;
    std::uint64_t end_;
    const std::function<bool(std::uint8_t)>& known_;
    std::uint64_t budget_;   ///< bytes whose checksums may still be tried
    ScanResult result_;
};

}  // namespace

ScanResult scan_groups(const ReadExactly& read, std::uint64_t begin, std::uint64_t end,
                       const std::function<bool(std::uint8_t slot)>& known) {
    return Scanner(read, begin, end, known).run();
}

}  // namespace mien::protocol
