#include <cstdint>
#include <cstdlib>

#include "protocol/messages.hpp"

/// Any bytes as a message: no crash, and what is accepted is written again as it was.
extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* input, std::size_t size) {
    using namespace mien;
    // A copy of exact size, so that a read one byte past the end is seen.
    const Bytes bytes(reinterpret_cast<const std::byte*>(input), reinterpret_cast<const std::byte*>(input) + size);
    if (!bytes.empty()) (void)protocol::parse_manifest(bytes).ok();
    const auto message = protocol::parse_message(bytes);
    if (!message) return 0;
    // Packed blobs may be packed in many ways.
    if (!std::holds_alternative<protocol::StaticBlob>(*message) && protocol::encode(*message) != bytes) std::abort();
    return 0;
}
