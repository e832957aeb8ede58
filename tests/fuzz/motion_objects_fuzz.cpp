#include <algorithm>
#include <cmath>
#include <cstdint>
#include <cstdlib>

#include "coding/motion_basis.hpp"
#include "coding/motion_frames.hpp"
#include "decoder/motion_decoder.hpp"

// Objects of a small stream. The first byte chooses the scheme (value mod 3), whether points are corrected (4) and whether a rung
// refines it (8). Then each object is a length byte, a frame count byte and bytes; with two rungs a refinement follows each.
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
    if (bytes[0] & 4) basis.corrected = {1, 3};
    const bool refined = bytes[0] & 8 && basis.scheme != coding::MotionScheme::guenter98;
    if (basis.scheme == coding::MotionScheme::guenter98) basis.static_codes.assign(11, {});
    std::vector<Bytes> stored{write_motion_basis(basis, shape, coding::plain_order(4)).bytes};
    if (refined) {
        coding::MotionBasis finer = coding::refining(basis);
        finer.step = basis.step / 2;
        finer.mean.assign(12, 0);
        finer.components.push_back({0, 0, 8, 0, 0, 8, 0, 0, 0, 0, 8, 0});
        finer.level_steps.fill(8);
        finer.predictors.assign(3, {300, -60, 10});
        if (bytes[0] & 4) finer.corrected = {0, 3};
        shape.pose = shape.presence = false;
        stored.push_back(write_motion_basis(finer, shape, coding::plain_order(4)).bytes);
    }
    const std::vector<ByteView> bases(stored.begin(), stored.end());
    const protocol::MotionInfo info{.kind = protocol::MotionKind::markers, .count = 4, .has_pose = true, .has_presence = true};
    auto decoder = decoder::MotionDecoder::create(info, bases);
    if (!decoder.ok()) std::abort();
    decoder->begin_group();
    std::size_t at = 1;
    const auto next = [&] {
        const std::size_t length = std::min<std::size_t>(bytes[at], size - at - 2);
        protocol::Object object{.frames = bytes[at + 1], .bytes = {}};
        const auto* begin = reinterpret_cast<const std::byte*>(bytes + at + 2);
        object.bytes.assign(begin, begin + length);
        at += 2 + length;
        return object;
    };
    while (at + 2 <= size) {
        const protocol::Object object = next();
        protocol::Object refinement;
        std::vector<const protocol::Object*> refinements;
        if (refined && at + 2 <= size) {
            refinement = next();
            refinements.push_back(&refinement);
        }
        const auto motions = decoder->decode(object, 0, refinements);
        if (!motions.ok()) decoder->begin_group();
        else
            for (const auto& motion : *motions) {
                if (!motion.coefficients.allFinite() || !motion.pose.translation.allFinite()) std::abort();
                for (const auto& correction : motion.corrections)
                    if (correction.at >= 12 || !std::isfinite(correction.offset)) std::abort();
            }
    }
    return 0;
}
