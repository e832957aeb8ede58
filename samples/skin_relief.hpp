#pragma once

#include <memory>

#include "core/texel_map.hpp"
#include "samples/actor.hpp"
#include "samples/skin_stretch.hpp"

namespace mien::samples {

/// The shape of skin beyond its mesh, from the mesh's true strain alone. Nothing in it is a polynomial: bulges set in past a
/// threshold and saturate; wrinkles buckle where skin is pressed together across their own direction past a threshold, with
/// the square root of what is beyond it, and sharpen into creases; pores widen, shear and flatten with the skin around
/// them. Deterministic by seed. May be used from several threads at once.
class SkinRelief {
public:
    /// texels: the map that `fine` is for. The actor need not outlive the relief.
    SkinRelief(const Actor& actor, const TexelMap& texels, std::uint64_t seed);
    ~SkinRelief();

    /// The medium surface: the deformed mesh with its bulges, some mm at most, V x 3. `deformed`: V x 3, mm, head space.
    Points bulged(PointsRef deformed, const Stretch::Field& strain) const;
    /// Height of wrinkles and pores over the medium surface along its normal, mm, 1 channel; 0 where there is no skin.
    FloatMap fine(const Stretch::Field& strain) const;

    const Stretch& stretch() const;

private:
    struct Laid;
    std::unique_ptr<const Laid> laid_;
};

/// How high skin stands at `across` mm from a fold's line, per mm of its depth: a groove between two ridges, sharper the more
/// `pressed` (0 .. 1) it is. width: the fold's half width at rest, mm.
float fold_profile(float across, float width, float pressed);
/// How far a fold has buckled, 0 .. 1, under `squeeze`: minus the logarithmic strain across it.
float fold_depth(float squeeze, float threshold);

}  // namespace mien::samples
