#include <cstdint>
#include <cstdlib>

#include "coding/motion_basis.hpp"
#include "coding/motion_frames.hpp"
#include "decoder/motion_decoder.hpp"

// Objects of a small stream: the first byte chooses the scheme, then each object is a length byte, a frame count byte and bytes.
extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* bytes, std::size_t size) {
    using namespace mien;
    if (size < 1) return 0;
    coding::MotionShape shape{.points = 4, .coordinates = 3, .pose = true, .gaze = false, .presence = true};
    coding::MotionBasis basis;
    basis.scheme = coding::MotionScheme(1 + bytes[0] % 3);
    basis.mean.assign(12, 0);
    basis.components = {{8, 0, 0, 8, 0, 0, 16, 0, 0, 0, 0, 8}, {0, 8, 0, 0, -8, 0, 0, 24, 0, 0, 0, 0}};
    basis.level_steps.fill(8);  // the values above are multiples of it
    basis.predictors.assign(8, {300, -60, 10});
    basis.static_codes.assign(11, {});
    const Bytes stored = write_motion_basis(basis, shape, coding::plain_order(4)).bytes;
    const protocol::MotionInfo info{.kind = protocol::MotionKind::markers, .count = 4, .has_pose = true, .has_presence = true};
    auto decoder = decoder::MotionDecoder::create(info, stored);
    if (!decoder.ok()) std::abort();
    decoder->begin_group();
    for (std::size_t at = 1; at + 2 <= size;) {
        const std::size_t length = std::min<std::size_t>(bytes[at], size - at - 2);
        protocol::Object object{.frames = bytes[at + 1], .bytes = {}};
        const auto* begin = reinterpret_cast<const std::byte*>(bytes + at + 2);
        object.bytes.assign(begin, begin + length);
        at += 2 + length;
        const auto motions = decoder->decode(object, 0);
        if (!motions.ok()) decoder->begin_group();
        else
            for (const auto& motion : *motions)
                if (!motion.coefficients.allFinite() || !motion.pose.translation.allFinite()) std::abort();
    }
    return 0;
}
