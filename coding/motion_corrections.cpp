#include "coding/motion_corrections.hpp"

namespace mien::coding {

MotionCorrections::MotionCorrections(const MotionBasis& basis, const MotionShape& shape)
    : coordinates_(shape.coordinates), flags_(kFlagContexts, 1, 1, kLimit), move_(kValueContexts, 1, 9, kLimit),
      values_(basis.corrected.size() * shape.coordinates), changed_(basis.corrected.size()), last_(changed_), age_(changed_) {
    begin_group();
}

void MotionCorrections::begin_group() {
    flags_ = IntegerModel(kFlagContexts, 1, 1, kLimit);
    move_ = IntegerModel(kValueContexts, 1, 9, kLimit);
    // Most points stay as they are.
    for (AdaptiveBit& bit : flags_.bits()) bit = {.p = kHalf / 8, .n = 1};
    any_ = {};
    any_last_ = 0;
    count_last_ = 0;
    std::fill(values_.begin(), values_.end(), 0);
    std::fill(changed_.begin(), changed_.end(), std::uint8_t(0));
    std::fill(age_.begin(), age_.end(), std::uint8_t(0));
}

}  // namespace mien::coding
