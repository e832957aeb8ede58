#pragma once

#include <vector>

#include "core/image.hpp"
#include "samples/performance.hpp"
#include "samples/skin.hpp"

namespace mien::samples {

/// The texture video of a performance, painted when it is read. A few frames ahead are painted together, each on a thread
/// of its own, so ascending reads use the whole machine and memory stays small.
class StageTexture : public TextureSource {
public:
    /// All three outlive it.
    StageTexture(const Actor& actor, const Skin& skin, const std::vector<Instant>& instants);

    int width() const override { return skin_.texel_map().width; }
    int height() const override { return skin_.texel_map().height; }
    std::int64_t frames() const override { return std::int64_t(instants_.size()); }
    Result<Image> read(std::int64_t frame) override;

private:
    const Actor& actor_;
    const Skin& skin_;
    const std::vector<Instant>& instants_;
    std::int64_t first_ = 0;
    std::vector<Image> ready_;  ///< frames first_, first_ + 1, ...
};

}  // namespace mien::samples
