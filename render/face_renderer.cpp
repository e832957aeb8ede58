#include "render/face_renderer.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cassert>
#include <cmath>
#include <map>
#include <optional>
#include <set>
#include <tuple>

#include "embedded_mien_render.hpp"
#include "render/albedo.hpp"
#include "render/bust.hpp"
#include "render/corners.hpp"
#include "render/detail_map.hpp"
#include "render/gl.hpp"
#include "render/point_cloud.hpp"
#include "render/shadow_map.hpp"
#include "render/shape.hpp"

namespace mien::render {
namespace {

constexpr std::size_t kTakenAtOnce = 4u << 20;   // bytes of refined maps a picture: a millisecond or two of copying

std::string surface_defines(Surface surface) {
    return fmt::format(
        "#define SKIN 0\n#define EYE 1\n#define CORNEA 2\n#define TEETH 3\n#define MOUTH 4\n#define LASHES 5\n"
        "#define HAIR 6\n#define OTHER 7\n#define SURFACE {}\n",
        int(surface));
}

}  // namespace

struct FaceRenderer::State {
    State(const model::FaceModel& model, const model::LinearMotion& composed)
        : shape(model, composed), box(bounding_box(model::neutral_points(model))) {
        if (const auto* base = std::get_if<model::PointBase>(&model.base)) {
            points.emplace(*base);
        } else {
            const Corners made = make_corners(model);
            batches = made.batches;
            corners = gl::make_buffer(sizeof(Corner) * made.corners.size(), made.corners.data());
            indices = gl::make_buffer(sizeof(std::uint32_t) * made.indices.size(), made.indices.data());
            index_count = GLsizei(made.indices.size());
            for (const Batch& batch : batches)
                if (batch.surface == Surface::skin || batch.surface == Surface::hair) solid_count = GLsizei(batch.first + batch.count);
            std::vector<std::uint32_t> vertices;
            for (const std::uint32_t corner : made.indices) vertices.push_back(made.corners[corner].vertex);
            caster_indices = gl::make_buffer(sizeof(std::uint32_t) * vertices.size(), vertices.data());
            fade = bust_fade(model.neutral);
            make_layout();
            make_casters();
        }
        if (model.detail && (model.detail->model().fine.texels > 0 || model.detail->model().albedo.texels > 0)) {
            detail_map.emplace(model.detail->model(), map_pictures(model.detail->model(), model.static_albedo ? &*model.static_albedo : nullptr));
            pictured = model.static_albedo.has_value();
            texels_a_mm = float(model.detail->texels_a_mm());
        }
        any = gl::make_vertex_array();
        backdrop = gl::make_program(embedded::shaders_backdrop_vert, embedded::shaders_backdrop_frag);
    }

    void make_layout() {
        layout = gl::make_vertex_array();
        const GLuint id = layout.id();
        glVertexArrayVertexBuffer(id, 0, corners.id(), 0, sizeof(Corner));
        glVertexArrayElementBuffer(id, indices.id());
        glVertexArrayAttribIFormat(id, 0, 1, GL_UNSIGNED_INT, offsetof(Corner, vertex));
        glVertexArrayAttribFormat(id, 1, 2, GL_FLOAT, GL_FALSE, offsetof(Corner, u));
        glVertexArrayAttribFormat(id, 2, 4, GL_FLOAT, GL_FALSE, offsetof(Corner, feature));
        for (GLuint attribute = 0; attribute < 3; ++attribute) {
            glVertexArrayAttribBinding(id, attribute, 0);
            glEnableVertexArrayAttrib(id, attribute);
        }
    }

    /// Shadows need positions alone, which come as they lie, without the way over the corners.
    void make_casters() {
        casters = gl::make_vertex_array();
        const GLuint id = casters.id();
        glVertexArrayVertexBuffer(id, 0, shape.positions().id(), 0, 3 * sizeof(float));
        glVertexArrayElementBuffer(id, caster_indices.id());
        glVertexArrayAttribFormat(id, 0, 3, GL_FLOAT, GL_FALSE, 0);
        glVertexArrayAttribBinding(id, 0, 0);
        glEnableVertexArrayAttrib(id, 0);
    }

    gl::Program& program(Surface surface, Albedo::Kind kind, bool fine) {
        const auto [at, fresh] = programs.try_emplace({surface, kind, fine});
        if (fresh)
            at->second = gl::make_program(embedded::shaders_face_vert, embedded::shaders_face_frag,
                                          surface_defines(surface) + Albedo::defines(kind) + (fine ? "#define FINE\n" : ""));
        return at->second;
    }

    void form(const ShapeSteps& steps) {
        if (motion && (stale || !(steps == formed))) shape.form(*motion, steps);
        stale = false;
        formed = steps;
    }

    void take_pictures() {
        std::size_t budget = kTakenAtOnce;
        if (coming.maps && detail_map->take(coming.maps->maps, budget)) coming.maps.reset();
        if (coming.medium && shape.detail()->take(coming.medium->medium, budget)) coming.medium.reset(), stale = true;
    }

    /// Without a wall there is nothing to fade into.
    bool fades(const Look& look) const { return fade && look.lit && look.backdrop && !look.wireframe; }

    void draw_face(const Camera& camera, const Look& look, const Target& target);
    void draw_backdrop(const Camera& camera, const Look& look, const Target& target);
    void draw_batch(const Batch& batch, gl::Program& program);

    Shape shape;
    Albedo albedo;
    Eigen::AlignedBox3f box;               // of the neutral points, head space
    std::optional<BustFade> fade;
    std::optional<model::Motion> motion;   // none: positions came from outside
    bool stale = false;
    ShapeSteps formed;

    std::vector<Batch> batches;
    gl::Buffer corners, indices, caster_indices;
    GLsizei index_count = 0, solid_count = 0;   // skin and hair come first
    gl::VertexArray layout, casters, any;
    std::optional<DetailMap> detail_map;
    float texels_a_mm = 0;
    struct {
        std::shared_ptr<const DetailPictures> maps, medium;
    } coming;                              // of refine(), until it is drawn
    bool pictured = false;                 // the model has a picture of what its maps do not colour
    std::map<std::tuple<Surface, Albedo::Kind, bool>, gl::Program> programs;
    std::optional<PointCloud> points;
    std::optional<ShadowMap> shadow;       // made when first wanted
    gl::Program backdrop;
};

FaceRenderer::FaceRenderer(const model::FaceModel& model, const model::LinearMotion& composed)
    : state_(std::make_unique<State>(model, composed)) {}
FaceRenderer::~FaceRenderer() = default;

void FaceRenderer::set_motion(const model::Motion& motion) {
    state_->motion = motion;
    state_->stale = true;
    if (state_->points) state_->points->set_presence(motion.presence);
}

void FaceRenderer::set_positions(PointsRef positions, const RigidPose& pose) {
    state_->motion.reset();
    state_->shape.form(positions, pose);
    if (!state_->points) return;
    std::vector<std::uint8_t> presence(std::size_t(positions.rows()));
    for (Eigen::Index i = 0; i < positions.rows(); ++i) presence[std::size_t(i)] = positions.row(i).allFinite();
    state_->points->set_presence(presence);
}

void FaceRenderer::set_texture(const YuvView& picture) { state_->albedo.set(picture); }
void FaceRenderer::set_texture(const Image& picture) { state_->albedo.set(picture); }
void FaceRenderer::clear_texture() { state_->albedo.clear(); }

void FaceRenderer::refine(std::shared_ptr<const DetailPictures> pictures) {
    assert(!refining());
    if (!pictures->maps.empty() && state_->detail_map) state_->coming.maps = pictures;
    if (!pictures->medium.empty() && state_->shape.detail()) state_->coming.medium = std::move(pictures);
}

bool FaceRenderer::refining() const { return state_->coming.maps || state_->coming.medium; }

void FaceRenderer::State::draw_batch(const Batch& batch, gl::Program& program) {
    program.use();
    glDrawElements(GL_TRIANGLES, GLsizei(batch.count), GL_UNSIGNED_INT,
                   reinterpret_cast<const void*>(std::size_t(batch.first) * sizeof(std::uint32_t)));
}

void FaceRenderer::State::draw_face(const Camera& camera, const Look& look, const Target& target) {
    // Positions from outside say nothing of markers that the maps could follow.
    const bool detailed = detail_map && motion;
    const bool fine = detailed && look.fine && look.lit && detail_map->has_fine(), coloured = detailed && look.polynomial_albedo && detail_map->has_albedo();
    if (fine || coloured) {
        const float mm_a_pixel = 2 * (camera.eye - shape.pose().apply(box.center())).norm() * std::tan(camera.fov / 2) / float(target.height());
        detail_map->evaluate(shape.detail()->parameters(), texels_a_mm * mm_a_pixel);
        target.bind();
    }
    const bool shadowed = look.shadows && look.lit;
    Eigen::Vector4f part_left(0, 0, 0, 1);   // times (position, 1): below 1 where the bust fades
    if (fades(look)) {
        const Vec3 up = shape.pose().rotation * Vec3::UnitY() / (fade->whole - fade->gone);
        part_left << up, -up.dot(shape.pose().translation) - fade->gone / (fade->whole - fade->gone);
    }
    Eigen::Matrix4f light_projection = Eigen::Matrix4f::Identity();
    const Vec3 centre = shape.pose().apply(box.center());
    if (shadowed) {
        if (!shadow) shadow.emplace();
        light_projection = ShadowMap::projection(look.lighting.lights[0].towards, centre, box.diagonal().norm() * 0.55f);
        shadow->draw(casters, index_count, solid_count, light_projection, target.height());
        target.bind();
    }
    const Eigen::Matrix4f view_projection =
        camera.projection(float(target.width()) / float(target.height())) * camera.view();
    glBindVertexArray(layout.id());
    shape.bind_texels(4);
    for (const Batch& batch : batches) {
        const bool cornea = batch.surface == Surface::cornea;
        if (cornea && !look.lit) continue;
        const bool textured = look.texture && batch.textured && !cornea && batch.surface != Surface::lashes;
        // Without a picture beside it, the map knows the colour of skin alone.
        const bool mapped = coloured && (pictured || batch.surface == Surface::skin);
        const Albedo::Kind kind = !textured ? Albedo::Kind::none : mapped ? Albedo::Kind::map : albedo.kind();
        gl::Program& p = program(batch.surface, kind, fine && batch.surface == Surface::skin);
        if (textured) albedo.apply(p);
        if (fine || coloured) detail_map->bind(2);
        p.set("view_projection", view_projection);
        p.set("light_projection", light_projection);
        p.set("middle", centre);
        p.set("head_rotation", Eigen::Matrix3f(shape.pose().rotation.toRotationMatrix()));
        p.set("head_translation", shape.pose().translation);
        p.set("eye", camera.eye);
        p.set("sky", look.lighting.sky);
        p.set("ground", look.lighting.ground);
        constexpr const char* kTowards[] = {"light_towards[0]", "light_towards[1]", "light_towards[2]"};
        constexpr const char* kColour[] = {"light_colour[0]", "light_colour[1]", "light_colour[2]"};
        for (int i = 0; i < 3; ++i) {
            p.set(kTowards[i], look.lighting.lights[i].towards);
            p.set(kColour[i], look.lighting.lights[i].colour);
        }
        p.set("specular", look.lighting.specular);
        p.set("lit", int(look.lit));
        p.set("part_left", part_left);
        p.set("shadows", int(shadowed));
        p.set("wireframe", 0);
        const bool blended = cornea || batch.surface == Surface::lashes;
        if (blended) {
            glEnable(GL_BLEND);
            glBlendFunc(GL_ONE, GL_ONE_MINUS_SRC_ALPHA);
            glDepthMask(GL_FALSE);
        }
        draw_batch(batch, p);
        if (look.wireframe && !cornea) {
            glPolygonMode(GL_FRONT_AND_BACK, GL_LINE);
            glEnable(GL_POLYGON_OFFSET_LINE);
            glPolygonOffset(-1, -1);
            p.set("wireframe", 1);
            draw_batch(batch, p);
            glDisable(GL_POLYGON_OFFSET_LINE);
            glPolygonMode(GL_FRONT_AND_BACK, GL_FILL);
        }
        if (blended) {
            glDisable(GL_BLEND);
            glDepthMask(GL_TRUE);
        }
    }
}

void FaceRenderer::State::draw_backdrop(const Camera& camera, const Look& look, const Target& target) {
    constexpr int kRows = 16;                 // of backdrop.vert's grid, from the bottom up,
    constexpr int kRowCorners = 6 * 16;       // and corners in each
    glDisable(GL_FRAMEBUFFER_SRGB);   // its colours are encoded already
    backdrop.use();
    glBindVertexArray(any.id());
    glDrawArrays(GL_TRIANGLES, 0, kRows * kRowCorners);   // after the face: only where nothing hides it
    if (fades(look)) {
        // Once more over what fades, and only over those rows.
        Eigen::AlignedBox3f faded = box;
        faded.max().y() = fade->whole;
        const Eigen::AlignedBox2i pixels = pixels_of(faded, shape.pose(), camera, target.width(), target.height());
        const int first = pixels.min().y() * kRows / target.height(), last = (pixels.max().y() * kRows - 1) / target.height();
        glEnable(GL_BLEND);
        glBlendFuncSeparate(GL_ONE_MINUS_DST_ALPHA, GL_DST_ALPHA, GL_ONE, GL_ZERO);
        glDepthFunc(GL_GREATER);   // in front of the wall alone
        if (last >= first) glDrawArrays(GL_TRIANGLES, first * kRowCorners, (last - first + 1) * kRowCorners);
        glDepthFunc(GL_LEQUAL);
        glDisable(GL_BLEND);
    }
    glEnable(GL_FRAMEBUFFER_SRGB);
}

void FaceRenderer::draw(const Camera& camera, const Look& look, Target& target) {
    State& s = *state_;
    s.take_pictures();
    s.form(look.steps);
    target.bind();
    glEnable(GL_FRAMEBUFFER_SRGB);
    glEnable(GL_DEPTH_TEST);
    glDepthFunc(GL_LEQUAL);
    glDepthMask(GL_TRUE);
    glDisable(GL_BLEND);
    glDisable(GL_CULL_FACE);
    glDisable(GL_SCISSOR_TEST);
    glClearColor(0, 0, 0, 1);
    glClear(GL_COLOR_BUFFER_BIT | GL_DEPTH_BUFFER_BIT);
    // A face leaves the box of its neutral shape by a chin's or a brow's way at most.
    const Vec3 air = Vec3::Constant(0.1f * s.box.diagonal().norm());
    target.edges_within(s.points ? Eigen::AlignedBox2i(Eigen::Vector2i::Zero(), Eigen::Vector2i(target.width(), target.height()))
                                 : pixels_of({s.box.min() - air, s.box.max() + air}, s.shape.pose(), camera, target.width(), target.height()));
    if (s.points) {
        const float aspect = float(target.width()) / float(target.height());
        s.points->draw(s.shape.positions(), camera, aspect, target.height(), look.lighting, look.wireframe);
    } else {
        s.draw_face(camera, look, target);
    }
    if (look.backdrop) s.draw_backdrop(camera, look, target);
}

Points FaceRenderer::read_positions() const { return state_->shape.read_positions(); }
FloatMap FaceRenderer::read_detail() const { return state_->detail_map ? state_->detail_map->read() : FloatMap{}; }
Points FaceRenderer::read_normals() const { return state_->shape.read_normals(); }

}  // namespace mien::render
