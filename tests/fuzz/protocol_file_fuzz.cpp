#include <algorithm>
#include <cstdint>
#include <cstdlib>
#include <cstring>

#include "protocol/stream_file.hpp"

/// Any bytes as a stored stream: no crash, and every group it names can at least be asked for.
extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* input, std::size_t size) {
    using namespace mien;
    const auto read_at = [&](std::uint64_t offset, std::span<std::byte> into) -> Result<std::size_t> {
        const std::size_t got = offset < size ? std::min<std::size_t>(into.size(), size - offset) : 0;
        if (got) std::memcpy(into.data(), input + offset, got);
        return got;
    };
    const auto reader = protocol::StreamFileReader::open(read_at, size);
    if (!reader) return 0;
    for (const protocol::BlobInfo& blob : reader->catalogue().blobs) (void)reader->blob(blob.hash).ok();
    for (const protocol::IndexEntry& entry : reader->index()) {
        if (reader->find(entry.slot, entry.group) != &entry) std::abort();
        const auto group = reader->read_group(entry);
        const auto message = reader->group_message(entry);
        if (group && (!message || !protocol::parse_message(*message))) std::abort();
    }
    (void)reader->group_at(1.5);
    const auto sum = reader->account();
    if (sum && sum->framing > size) std::abort();
    return 0;
}
