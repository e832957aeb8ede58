#include <cstdint>
#include <cstdlib>

#include "coding/motion_basis.hpp"
#include "decoder/motion_decoder.hpp"

// The first bytes choose the track and whether the basis stands alone or refines a small one (128); the rest is a motion basis.
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
    std::vector<ByteView> bases;
    Bytes below;
    if (bytes[0] & 128) {
        coding::MotionBasis plain;
        const coding::MotionShape shape{.points = info.count, .coordinates = info.kind == protocol::MotionKind::weights ? 1u : 3u,
                                        .pose = info.has_pose, .gaze = info.has_gaze, .presence = info.has_presence};
        plain.mean.assign(shape.dimension(), 0);
        plain.components.emplace_back(shape.dimension(), 0).front() = coding::MotionBasis::kEvenSteps[0];   // on the residual grid
        plain.corrected = {info.count - 1};
        below = write_motion_basis(plain, shape, coding::plain_order(info.count)).bytes;
        bases.push_back(below);
    }
    bases.push_back(basis);
    const auto decoder = decoder::MotionDecoder::create(info, bases, triangles, mirror);
    if (decoder.ok() && !decoder->basis().components.allFinite()) std::abort();
    return 0;
}
