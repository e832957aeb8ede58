#pragma once

#include <vector>

#include "encoder/texture_lanes.hpp"

namespace mien::encoder {

/// Sets the step of every lane that shrinks, by the first `frames` frames, encoded at the quality that has about the asked rate. What
/// quantiser step q its encoder takes there nobody tells, but its error does: an even quantiser of step q errs by q^2 / 12. Of not
/// shrinking at all, q, and its doubles or halves as long as these get better, that is taken with which weighted error times bits is
/// least (squared errors fall about as bits grow).
Result<void> choose_steps(TextureSource& source, TextureFill& fill, const std::vector<TextureLane*>& lanes, std::int64_t frames,
                          const Progress& progress);

}  // namespace mien::encoder
