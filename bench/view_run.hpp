#pragma once

#include <map>
#include <memory>

#include "bench/geometry_codec.hpp"
#include "bench/picture_score.hpp"

namespace mien::bench {

/// Received frames drawn from three fixed cameras and held against the drawn truth, inside the face's own pixels: those that
/// the truth covers. Sampled frames, evenly spread over the clip.
class ViewComparison {
public:
    /// clip has a neutral mesh, vertices and a texture; `pictures` frames are drawn. Throws EnvironmentError without OpenGL.
    static Result<std::unique_ptr<ViewComparison>> create(const Clip& clip, std::int64_t pictures);
    ~ViewComparison();

    const std::vector<std::int64_t>& frames() const;  ///< that are drawn, ascending

    /// Decodes the sampled frames of a geometry stream: V x 3 floats each.
    Result<std::vector<Points>> sample(GeometryStream& stream) const;
    /// The drawn truth against positions and textures of the sampled frames.
    PictureScore compare(const std::vector<Points>& positions, const std::vector<Image>& textures);

private:
    struct State;
    explicit ViewComparison(std::unique_ptr<State> state);
    std::unique_ptr<State> state_;
};

}  // namespace mien::bench
