#include <algorithm>
#include <cassert>

#include "protocol/stream_file.hpp"

namespace mien::protocol {

StreamFileWriter::StreamFileWriter(Append append, const StreamHeader& header, const std::vector<StaticBlob>& blobs)
    : append_(std::move(append)), frames_(header.frames) {
    for (const Track& track : header.tracks)
        for (const Rung& rung : track.rungs) slots_ |= std::uint64_t(1) << rung.slot;
    Catalogue catalogue;
    for (const StaticBlob& blob : blobs) {
        assert(sha256(blob.bytes) == blob.hash);
        catalogue.blobs.push_back({blob.hash, blob.kind, blob.bytes.size()});
    }
    assert(std::ranges::any_of(blobs, [&](const StaticBlob& b) { return b.hash == header.model; }));
    write(encode(header));
    write(encode(catalogue));
    for (const StaticBlob& blob : blobs) write(encode(blob));
}

void StreamFileWriter::add(const Group& group) {
    assert(slots_ >> group.slot & 1);
    assert(index_.entries.empty() || std::pair(index_.entries.back().group, index_.entries.back().slot) <
                                         std::pair(group.group, group.slot));
    const Bytes message = encode(group);
    index_.entries.push_back({group.slot, group.group, group.first_time, static_cast<std::uint32_t>(group.objects.size()),
                              size_, message.size()});
    write(message);
}

void StreamFileWriter::finish() {
    write(encode(End{frames_}));
    const Trailer trailer{size_};
    write(encode(index_));
    write(encode(trailer));
}

void StreamFileWriter::write(const Bytes& bytes) {
    append_(bytes);
    size_ += bytes.size();
}

void order_groups(std::vector<Group>& groups) {
    std::ranges::stable_sort(groups, {}, [](const Group& g) { return std::pair(g.group, g.slot); });
}

}  // namespace mien::protocol
