#pragma once

#include "encoder/motion_encoder.hpp"
#include "encoder/training_take.hpp"

namespace mien::encoder {

/// As encode_motion(), with the basis of a training take instead of one made for this clip: only its step may differ. Presets file and live, an RMS
/// or a peak error, and the reference of the take's model. Fails with the error that the basis leaves when that is above the asked one.
Result<EncodedMotion> encode_trained(const Clip& clip, const TrainingTake& take, const MotionOptions& options, const Progress& progress = {});

}  // namespace mien::encoder
