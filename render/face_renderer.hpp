#pragma once

#include <memory>

#include "core/image.hpp"
#include "model/face_model.hpp"
#include "render/camera.hpp"
#include "render/detail_pictures.hpp"
#include "render/look.hpp"
#include "render/target.hpp"

namespace mien::render {

/// Draws one face model. Belongs to the OpenGL context that is current when it is made; not thread-safe. A frame uploads
/// its coefficients and its texture, never a mesh.
class FaceRenderer {
public:
    /// `composed`: model::compose's; empty (dimension 0) when positions always come from outside.
    explicit FaceRenderer(const model::FaceModel& model, const model::LinearMotion& composed = {});
    ~FaceRenderer();
    FaceRenderer(const FaceRenderer&) = delete;
    FaceRenderer& operator=(const FaceRenderer&) = delete;

    /// The next picture shows this instant. Markers whose presence is 0 are not drawn.
    void set_motion(const model::Motion& motion);
    /// The next picture shows these points (V x 3 mm, clip space; rows with NaN are not drawn when the model is points).
    /// `pose`: the head's, for where cavities and the shadow are.
    void set_positions(PointsRef positions, const RigidPose& pose = {});

    void set_texture(const YuvView& picture);
    void set_texture(const Image& picture);   ///< 1, 3 or 4 channels, rows from the top
    void clear_texture();

    /// Takes over maps of the model's detail that have more stages than those that are drawn. They go to the GPU a few megabytes with each picture, so that none
    /// waits for them, and are drawn from the first one on for which all are there. Only when not refining().
    void refine(std::shared_ptr<const DetailPictures> pictures);
    bool refining() const;   ///< some of what refine() was given is not drawn yet

    void draw(const Camera& camera, const Look& look, Target& target);

    /// What the GPU formed for the last picture, V x 3; for tests.
    Points read_positions() const;
    Points read_normals() const;
    /// Linear albedo and height (mm) in texture space as the maps of a detail model gave them for the last picture, 4 channels.
    FloatMap read_detail() const;

private:
    struct State;
    std::unique_ptr<State> state_;
};

}  // namespace mien::render
