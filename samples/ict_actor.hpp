#pragma once

#include <filesystem>
#include <memory>
#include <vector>

#include "core/clip.hpp"
#include "core/result.hpp"
#include "samples/actor.hpp"

namespace mien::samples {

/// The scan-derived head of ICT-FaceKit (https://github.com/ICT-VGL/ICT-FaceKit), posed by linear blendshapes. Its 26 719
/// vertices keep their order; triangles are grouped by part; the texture tiles of its materials are packed into one atlas.
/// Sheets that need pictures or shaders the kit does not bring (EyeBlend, EyeOcclusion, EyeLashes) keep their vertices but
/// are not drawn. Eyeballs are turned by gaze, not by the EyeLook shapes, which move the lids alone.
class IctActor : public Actor {
public:
    const Mesh& neutral() const override { return neutral_; }
    const Landmarks& landmarks() const override { return landmarks_; }
    const std::vector<std::uint32_t>& rigid_vertices() const override { return rigid_; }
    Points deform(const Instant& instant) const override;

    /// The ARKit shapes as targets, in the order of kArkitNames: deform() = neutral + sum w_i * offsets_i, but for gaze.
    /// TongueOut has no shape here and is all zero.
    std::vector<Blendshape> blendshapes() const;

private:
    friend Result<std::unique_ptr<IctActor>> make_ict_actor(const std::filesystem::path&, const std::vector<float>&);
    struct Offset {
        std::uint32_t vertex;
        Vec3 by;  // mm at weight 1
    };
    Mesh neutral_;
    Landmarks landmarks_;
    std::vector<std::uint32_t> rigid_;
    std::vector<std::uint32_t> eyeball_[2];  // right, left
    std::array<std::vector<Offset>, kArkitCount> shapes_;
};

/// Loads the head from `folder`, in either of two forms:
/// - as published: FaceXModel/ (or the folder itself) with generic_neutral_mesh.obj, an OBJ per expression (jawOpen.obj, ...),
///   identity000.obj to identity099.obj;
/// - gathered: generic_neutral_mesh.obj, expression_names.txt, expression_deltas_f32.npy [57, 26719, 3] and
///   identity_deltas_first20_f32.npy [20, 26719, 3], offsets in cm.
/// `identity`: weights of the identity modes from the first on; none gives the generic head.
/// Errors: missing (file or expression, by name), mismatch (not this head's topology, or more identity weights than modes).
Result<std::unique_ptr<IctActor>> make_ict_actor(const std::filesystem::path& folder, const std::vector<float>& identity = {});

/// A plausible identity: `count` weights, normally distributed within two standard deviations. Seed 0: all zero.
std::vector<float> ict_identity(std::uint64_t seed, int count = 20);

}  // namespace mien::samples
