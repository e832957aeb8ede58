#pragma once

#include "core/image.hpp"

namespace mien::analysis {

/// A map of one channel minus its mean over a neighbourhood of about a Gaussian of `sigma` texels (three box means); NaN
/// texels stay NaN and count nothing.
FloatMap high_pass(const FloatMap& map, double sigma);

}  // namespace mien::analysis
