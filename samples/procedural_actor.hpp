#pragma once

#include <cstdint>
#include <memory>

#include "samples/actor.hpp"

namespace mien::samples {

/// A head written in code: skin with neck, ears, nostrils and lids, two eyeballs, teeth, gums, tongue and a
/// mouth bag. Seed 0 is the plain, exactly mirror-symmetric head; any other seed varies a few proportions and
/// adds the slight asymmetry of a real face. The same seed gives the same vertices; topology and texture
/// atlas are the same for all seeds.
std::unique_ptr<Actor> make_procedural_actor(std::uint64_t seed = 0);

}  // namespace mien::samples
