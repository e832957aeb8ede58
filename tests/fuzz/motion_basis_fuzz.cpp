#include <cstdint>
#include <cstdlib>

#include "decoder/motion_decoder.hpp"

// The first bytes choose the track, the rest is a motion basis.
extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* bytes, std::size_t size) {
    using namespace mien;
    if (size < 2) return 0;
    protocol::MotionInfo info;
    info.kind = protocol::MotionKind(1 + bytes[0] % 3);
    info.count = 1 + bytes[1] % 40;
    info.has_pose = bytes[0] & 16;
    info.has_gaze = bytes[0] & 32;
    info.has_presence = bytes[0] & 64;
    const std::vector<Triangle> triangles{{0, 1, 2}, {2, 1, 3}, {3, 4, 5}};
    std::vector<std::uint32_t> mirror(info.count);
    for (std::uint32_t v = 0; v < info.count; ++v) mirror[v] = (v ^ 1) < info.count ? v ^ 1 : v;
    const ByteView basis(reinterpret_cast<const std::byte*>(bytes + 2), size - 2);
    const auto decoder = decoder::MotionDecoder::create(info, basis, triangles, mirror);
    if (decoder.ok() && !decoder->basis().components.allFinite()) std::abort();
    return 0;
}
