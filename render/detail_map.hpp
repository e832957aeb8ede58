#pragma once

#include <vector>

#include "core/image.hpp"
#include "render/detail_pictures.hpp"
#include "render/gl.hpp"

namespace mien::render {

/// The fine and albedo maps of a detail model, evaluated on the GPU into one picture in texture space: linear albedo in red, green and
/// blue, height along the normal in mm in alpha. The picture has the map's own size, or half of it each way, and so on, by how large
/// the face is drawn.
class DetailMap {
public:
    /// `maps`: map_pictures() of the model.
    DetailMap(const model::DetailModel& model, const std::vector<DetailPictures::Level>& maps);

    /// Puts maps of the same model, with more stages, in the place of those that are drawn: `budget` bytes of them at most, which it counts down. True once
    /// all are on the GPU; they are drawn from then on. False: call again, with the same maps, until it is true.
    bool take(const std::vector<DetailPictures::Level>& maps, std::size_t& budget);

    bool has_albedo() const { return has_albedo_; }
    bool has_fine() const { return has_fine_; }

    /// Evaluates all texels for d1, d2 as DetailShape forms them. texels_per_pixel: of the full map, where the face is drawn.
    void evaluate(const gl::Texture& parameters, float texels_per_pixel);
    /// Binds the picture of the last evaluation.
    void bind(GLuint unit) const;

    FloatMap read() const;   ///< 4 channels, for tests

private:
    /// Of a level, what changes with the stages of the maps.
    struct Pictures {
        gl::Texture coefficients, still, value;
        gl::Framebuffer target;
    };
    struct Level {
        int width = 0, height = 0;
        gl::Texture domain;
        Pictures pictures;
        gl::Buffer squares;
        gl::VertexArray layout;
        GLsizei corner_count = 0;
    };
    void make_level(const DetailPictures::Level& map);
    static Pictures make_pictures(const DetailPictures::Level& map);

    bool has_albedo_ = false, has_fine_ = false;
    gl::Program program_;
    std::vector<Level> levels_;
    std::size_t shown_ = 0;
    std::vector<Pictures> coming_;   // of take(): levels that have begun
    struct {
        std::size_t level = 0, picture = 0;   // a term, or `still` behind the last
        int row = 0;
    } taken_;                        // what take() goes on with
};

}  // namespace mien::render
