#include <cstdint>
#include <cstdlib>

#include "io/rtp_packet.hpp"

/// Any bytes as a packet of sound: no crash, and what is accepted holds no more than came.
extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* input, std::size_t size) {
    using namespace mien;
    // A copy of exact size, so that a read one byte past the end is seen.
    const Bytes bytes(reinterpret_cast<const std::byte*>(input), reinterpret_cast<const std::byte*>(input) + size);
    const auto packet = io::parse_rtp(bytes);
    if (!packet) return 0;
    const auto sound = io::parse_l16(packet->payload, 48000, 1 + packet->payload_type % 8);
    if (sound && io::encode_l16(*sound).size() != packet->payload.size()) std::abort();
    return packet->payload.size() + 12 > bytes.size() ? std::abort(), 0 : 0;
}
