#include <fmt/core.h>

#include <algorithm>
#include <filesystem>

#include "analysis/marker_placement.hpp"
#include "encoder/detail_encoder.hpp"
#include "encoder/model_remap.hpp"
#include "io/clip_folder.hpp"
#include "io/file.hpp"
#include "tools/commands.hpp"
#include "tools/console.hpp"
#include "tools/model_file.hpp"
#include "tools/options.hpp"

namespace mien::tools {
namespace {

namespace fs = std::filesystem;

constexpr double kFarOff = 5;   // mm from the skin: another face, another unit or a face that is not at rest

struct Request {
    std::string model, clip, output;
    std::int64_t at_rest = 0;
    double misplace = 0;
    std::uint32_t seed = 1;
    bool overwrite = false, quiet = false;
};

Points skin_points(const Mesh& mesh) {
    const std::vector<Surface> surfaces = mesh.triangle_surfaces();
    std::vector<std::uint8_t> skin(mesh.vertex_count(), 0);
    for (std::size_t t = 0; t < mesh.triangles.size(); ++t)
        for (const std::uint32_t v : mesh.triangles[t]) skin[v] |= surfaces[t] == Surface::skin;
    Points points(Eigen::Index(std::count(skin.begin(), skin.end(), 1)), 3);
    for (Eigen::Index v = 0, n = 0; v < mesh.positions.rows(); ++v)
        if (skin[std::size_t(v)]) points.row(n++) = mesh.positions.row(v);
    return points;
}

/// The clip's markers at rest, and what of its face mesh there is to hold them: M x 3 and N x 3 (or none) mm.
Result<std::pair<Points, Points>> markers_at_rest(const Clip& clip, std::int64_t frame) {
    if (!clip.markers) return Error{ErrorCode::missing, "the clip has no markers"};
    if (clip.neutral && clip.neutral->vertex_count() > 0 && clip.marker_sites.size() == std::size_t(clip.markers->points)) {
        Points rest(Eigen::Index(clip.marker_sites.size()), 3);
        for (std::size_t m = 0; m < clip.marker_sites.size(); ++m) rest.row(Eigen::Index(m)) = clip.marker_sites[m].position(clip.neutral->positions).transpose();
        return std::pair(rest, skin_points(*clip.neutral));
    }
    if (frame >= clip.markers->frames) return Error{ErrorCode::invalid, fmt::format("the clip has no frame {}", frame)};
    const Points rest = clip.markers->frame(frame);
    for (Eigen::Index m = 0; m < rest.rows(); ++m)
        if (!rest.row(m).allFinite())
            return Error{ErrorCode::invalid, fmt::format("marker {} is missing in frame {}; name one at rest where all are seen with --at-rest", m, frame)};
    return std::pair(rest, Points());
}

Result<int> remap(const Request& request) {
    const fs::path output = request.output;
    MIEN_CHECK(may_write(output, request.overwrite, {request.clip, request.model}));
    MIEN_TRY(model, read_model(request.model));
    MIEN_TRY(loaded, io::load_clip(request.clip, {.frame_rate = {}, .unit = {}, .progress = progress_bar(request.quiet)}));
    for (const std::string& text : loaded.warnings) warn(text);
    MIEN_TRY(rest, markers_at_rest(loaded.clip, request.at_rest));
    if (rest.first.rows() < 4) return fail("a face needs four markers or more");
    io::OutputFile file(output, request.overwrite);
    analysis::PlacedMarkers placed = analysis::place_markers(model.model.neutral, rest.first, rest.second);
    if (request.misplace > 0) analysis::misplace(placed, model.model.neutral, request.misplace, request.seed);
    MIEN_TRY(remapped, encoder::remap_markers(model, placed.sites, placed.rest));
    file.write(ByteView(encoder::model_file(remapped.manifest, remapped.blobs, output.stem().string())));
    file.commit_to_disk();
    end_progress();
    if (placed.largest > kFarOff)
        warn(fmt::format("a marker lies {:.1f} mm from the model's skin: is this the same actor, at rest, in the same unit?", placed.largest));
    if (!request.quiet) {
        std::size_t fresh = 0;
        for (const auto& blob : remapped.blobs)
            if (std::none_of(model.blobs.begin(), model.blobs.end(), [&](const auto& old) { return old.hash == blob.hash; })) fresh += blob.bytes.size();
        fmt::print("{}: {} markers, {:.2f} mm from the skin on average, {:.2f} at most; {} new for who has {}\n", request.output, placed.sites.size(), placed.mean,
                   placed.largest, human_bytes(fresh), request.model);
    }
    return kDone;
}

}  // namespace

void add_remap(CLI::App& mien, int& code) {
    auto request = std::make_shared<Request>();
    CLI::App* command = mien.add_subcommand("remap", "Let the markers of another session drive a trained model of the same actor");
    command->add_option("model", request->model, "Model file of mien train")->required()->check(CLI::ExistingFile);
    command->add_option("clip", request->clip, "Clip of the other session: its markers at rest, by marker_sites on its neutral mesh or else by a frame")->required();
    command->add_option("-o,--output", request->output, "Model file to write")->required();
    command->add_option("--at-rest", request->at_rest, "Frame in which the face is at rest, for clips without neutral and marker_sites")->check(not_negative())->capture_default_str();
    command->add_option("--misplace", request->misplace, "Take every marker to sit so many mm away along the skin, to measure what that costs")->check(above_zero());
    command->add_option("--seed", request->seed, "Of the directions of --misplace")->capture_default_str();
    command->add_flag("-y,--overwrite", request->overwrite, "Overwrite the output file");
    command->add_flag("-q,--quiet", request->quiet, "No progress, no summary");
    command->callback([request, &code] { code = guarded([&] { return remap(*request); }); });
}

}  // namespace mien::tools
