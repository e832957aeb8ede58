#pragma once

#include <cstdint>
#include <memory>

#include "core/image.hpp"
#include "core/texel_map.hpp"
#include "samples/actor.hpp"

namespace mien::samples {

/// What a skin looks like apart from where it lies. Amounts are relative to a fair, lightly freckled adult
/// (all 1).
struct Complexion {
    float melanin = 1;                     ///< of the whole skin; 0.5 very fair .. 6 dark
    float haemoglobin = 1;                 ///< redness of the whole skin
    float freckles = 1;                    ///< how many, and how dark
    float beard_shadow = 0.12f;            ///< shaved stubble over jaw and upper lip, 0 .. 1
    Vec3 hair = {0.048f, 0.026f, 0.014f};  ///< linear albedo of brows, lashes and hair
    Vec3 iris = {0.105f, 0.14f, 0.145f};   ///< linear albedo of the middle of the iris

    /// A plausible person: hair, eyes and skin vary together. Seed 0 is the stage's default actor.
    static Complexion of_seed(std::uint64_t seed);
};

/// The procedural skin of any actor: a texture painted once in the 3-D space of the neutral head, from its
/// landmarks, and lit, reddened and creased anew in every frame by what the face does. Deterministic by seed.
class Skin {
public:
    /// size: texels per side, 16 .. 8192. The actor need not outlive the skin.
    Skin(const Actor& actor, int size, std::uint64_t seed);
    Skin(const Actor& actor, int size, std::uint64_t seed, const Complexion& complexion);
    ~Skin();
    Skin(Skin&&) noexcept;
    Skin& operator=(Skin&&) noexcept;

    /// RGB, size x size, sRGB: the albedo with this instant's blood (skin that is compressed reddens,
    /// stretched skin blanches), creases and ambient occlusion. `deformed`: what actor.deform(instant) gave,
    /// V x 3, mm, head space. Texels within 16 of a chart repeat the nearest charted one. May be called from
    /// several threads at once.
    Image texture(const Instant& instant, PointsRef deformed) const;

    /// Grey, 255 where a chart covers the texel centre, else 0: exactly texel_map().used().
    Image mask() const;

    /// Linear albedo of one instant, 3 channels, `outside` outside the charts: blood and creases, but no occlusion.
    /// `deformed`: V x 3, mm, head space. May be called from several threads at once.
    FloatMap albedo(const Instant& instant, PointsRef deformed, float outside = 0) const;

    /// Linear albedo before anything that depends on the instant, 3 channels, zero outside the charts.
    FloatMap albedo() const;

    const TexelMap& texel_map() const;

private:
    struct Painted;
    std::unique_ptr<const Painted> painted_;
};

}  // namespace mien::samples
