#include <cstdint>
#include <cstdlib>

#include "io/frame_packet.hpp"

/// Any bytes as a packet: no crash, and what is accepted is written again as it was.
extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* input, std::size_t size) {
    using namespace mien;
    // A copy of exact size, so that a read one byte past the end is seen.
    const Bytes bytes(reinterpret_cast<const std::byte*>(input), reinterpret_cast<const std::byte*>(input) + size);
    const auto packet = io::parse_marker_packet(bytes);
    if (packet && io::encode(*packet).size() != bytes.size()) std::abort();
    return 0;
}
