#pragma once

#include "coding/motion_corrections.hpp"
#include "coding/motion_frames.hpp"

/// What decoder::MotionDecoder does with the objects of one rung that stands alone, for a coder of the test's own.
namespace mien::motion_test {

class ObjectWalk {
public:
    /// basis outlives it.
    ObjectWalk(const coding::MotionBasis& basis, const coding::MotionShape& shape)
        : corrects_(!basis.corrected.empty()), shape_(shape), frames_(basis, shape), corrections_(basis, shape) {}

    void begin_group() {
        frames_.begin_group();
        corrections_.begin_group();
    }

    template <class Coder>
    void decode(Coder& coder, std::uint32_t frames) {
        coder.enter(true);
        if (shape_.presence) frames_.code_presence(coder, frames, presence_);
        frames_.decode(coder, frames);
        coder.enter(false);
        for (std::uint32_t f = 0; corrects_ && f < frames && !coder.failed(); ++f) corrections_.code(coder, changes_);
    }

private:
    bool corrects_;
    coding::MotionShape shape_;
    coding::MotionFrames frames_;
    coding::MotionCorrections corrections_;
    std::vector<std::uint8_t> presence_;
    std::vector<coding::MotionCorrections::Change> changes_;
};

}  // namespace mien::motion_test
