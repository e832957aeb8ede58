#pragma once

#include <algorithm>

namespace mien::encoder {

/// 0 up to t = 0, 1 from t = 1 on, and level at both.
inline float smooth_step(float t) {
    t = std::clamp(t, 0.0f, 1.0f);
    return t * t * (3 - 2 * t);
}

}  // namespace mien::encoder
