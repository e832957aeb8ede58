#include "samples/head_rig.hpp"
#include "samples/procedural_actor.hpp"

namespace mien::samples {
namespace {

class ProceduralActor final : public Actor {
public:
    explicit ProceduralActor(std::uint64_t seed)
        : surface_(head_proportions(seed)), head_(make_head_mesh(surface_)), rig_(surface_, head_) {}

    const Mesh& neutral() const override { return head_.mesh; }
    const Landmarks& landmarks() const override { return head_.landmarks; }
    const std::vector<std::uint32_t>& rigid_vertices() const override { return rig_.rigid_vertices(); }
    Points deform(const Instant& instant) const override { return rig_.deform(instant); }

private:
    HeadSurface surface_;
    HeadMesh head_;
    HeadRig rig_;
};

}  // namespace

std::unique_ptr<Actor> make_procedural_actor(std::uint64_t seed) {
    return std::make_unique<ProceduralActor>(seed);
}

}  // namespace mien::samples
