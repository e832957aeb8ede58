#include "io/clip_reader.hpp"

#include <fmt/format.h>

#include <map>
#include <mutex>

#include "core/parallel.hpp"
#include "io/limits.hpp"
#include "io/mesh_file.hpp"
#include "io/npy.hpp"
#include "io/numbered_files.hpp"
#include "io/text.hpp"

namespace mien::io {
namespace {

namespace fs = std::filesystem;

}  // namespace

void ClipReader::read_vertices() {
    std::vector<fs::path> files = description_.vertex_files;
    if (description_.vertices) {
        const fs::path& path = *description_.vertices;
        sources_.vertices = path.string();
        const std::string ending = lower_case(path.extension().string());
        std::error_code ignored;
        if (ending == ".npy") {
            auto array = take(read_npy(path));
            if (!array) return;
            if (array->shape.size() == 2) array->shape.insert(array->shape.begin(), 1);
            if (array->shape.size() != 3 || array->shape[2] != 3)
                return problem(ErrorCode::invalid, fmt::format("{} has shape {}; [frames, vertices, 3] is wanted", path.string(), array->shape_text()));
            if (array->shape[1] > kMaxVertices || array->shape[0] > kMaxFrames)
                return problem(ErrorCode::limit_exceeded, fmt::format("{} has shape {}, more than a clip may have", path.string(), array->shape_text()));
            clip_.vertices.emplace();
            clip_.vertices->frames = array->shape[0];
            clip_.vertices->points = array->shape[1];
            clip_.vertices->xyz = std::move(array->values);
            return;
        }
        if (!names_many(path) && (fs::exists(path, ignored) || ending == ".glb" || ending == ".gltf")) {
            files = {path};
        } else {
            auto numbered = take(open_numbered(path, kMeshEndings));
            if (!numbered) return;
            if (numbered->fault) findings_.problem(*numbered->fault);
            files = std::move(numbered->paths);
        }
    }
    if (!files.empty()) read_mesh_sequence(files);
}

void ClipReader::read_mesh_sequence(const std::vector<fs::path>& files) {
    if (!description_.vertices) sources_.vertices = files[0].parent_path().string();
    for (const fs::path& file : files) sources_.vertex_frames.push_back(file.string());
    const auto in_frame = [](Error error, std::int64_t f) {
        error.message += fmt::format(" (frame {})", f);
        return error;
    };
    // The file before stands for one that is missing, which has been told.
    const auto missing = [&](std::int64_t f) { return f > 0 && files[std::size_t(f)] == files[std::size_t(f - 1)]; };
    std::optional<MeshFile> first;
    std::int64_t reference = 0;
    for (std::int64_t f = 0; !first && f < std::int64_t(files.size()); ++f) {
        if (missing(f)) continue;
        auto file = read_mesh(files[std::size_t(f)]);
        if (!file) {
            findings_.problem(in_frame(file.error(), f));
            continue;
        }
        first = std::move(*file);
        reference = f;
    }
    if (!first) return;
    const std::string reference_name = files[std::size_t(reference)].filename().string();
    for (std::string& warning : first->warnings) findings_.warn(std::move(warning));
    const std::int64_t points = first->mesh.positions.rows();
    if (points == 0) return problem(ErrorCode::invalid, fmt::format("{} has no vertices", reference_name));
    const auto frames = std::int64_t(files.size());
    if (frames * points > kMaxValues / 3) return problem(ErrorCode::limit_exceeded, fmt::format("{} meshes are more than fits into memory", files.size()));
    clip_.vertices.emplace(frames, points);
    for (std::int64_t f = 0; f <= reference; ++f) clip_.vertices->frame(f) = first->mesh.positions;
    std::vector<std::optional<Error>> errors(files.size());
    std::vector<std::int64_t> counts(files.size(), points);
    std::mutex progress_mutex;
    std::int64_t done = reference + 1;
    parallel_for(frames - reference - 1, [&](std::int64_t i) {
        const std::int64_t f = reference + 1 + i;
        if (missing(f)) {
            clip_.vertices->frame(f) = first->mesh.positions;
            return;
        }
        const auto positions = read_positions(files[std::size_t(f)]);
        if (!positions) {
            errors[std::size_t(f)] = in_frame(positions.error(), f);
        } else if (positions->rows() != points) {
            counts[std::size_t(f)] = positions->rows();
        } else {
            clip_.vertices->frame(f) = *positions;
        }
        if (options_.progress) {
            const std::lock_guard lock(progress_mutex);
            options_.progress("reading meshes", ++done, frames);
        }
    });
    for (std::size_t f = 0; f < errors.size(); ++f) {
        if (errors[f]) findings_.problem(*errors[f]);
        // The first that can be read stands for those that are left out, so that nothing else is found wrong with them.
        if (errors[f] || counts[f] != points) clip_.vertices->frame(std::int64_t(f)) = first->mesh.positions;
    }
    std::map<std::int64_t, IndexRanges> frames_of_count;
    for (std::size_t f = 0; f < counts.size(); ++f)
        if (counts[f] != points) frames_of_count[counts[f]].add(std::int64_t(f));
    for (const auto& entry : frames_of_count) {
        const std::int64_t count = entry.first;   // clang 14 does not let lambdas have structured bindings
        const IndexRanges& of_count = entry.second;
        std::string which = files[std::size_t(of_count.first())].string();
        if (of_count.count() > 1) which += " to " + files[std::size_t(of_count.last())].filename().string();
        findings_.problem_of_list(ErrorCode::mismatch, [&](std::size_t most) {
            return fmt::format("{} ({}) {} {} vertices, but {} has {}", which, of_count.text("frame", "frames", most), of_count.count() == 1 ? "has" : "have", count,
                               reference_name, points);
        });
    }
    sequence_mesh_ = std::move(first->mesh);
    sequence_shapes_ = std::move(first->blendshapes);
}

void ClipReader::read_neutral() {
    if (description_.neutral) {
        sources_.neutral = description_.neutral->string();
        auto file = read_mesh(*description_.neutral);
        if (!file) {
            // A recording loads without a model that merely lies beside it, as one of compressed geometry.
            const std::string ending = lower_case(description_.neutral->extension().string());
            if (!guessed_ || (ending != ".glb" && ending != ".gltf")) return findings_.problem(file.error());
            findings_.warn(file.error().message + "; it is not used");
            description_.neutral.reset();
            return;
        }
        for (std::string& warning : file->warnings) findings_.warn(std::move(warning));
        if (file->mesh.positions.rows() == 0) return problem(ErrorCode::invalid, fmt::format("{} has no vertices", sources_.neutral));
        clip_.neutral = std::move(file->mesh);
        sequence_shapes_ = std::move(file->blendshapes);
    } else if (sequence_mesh_) {
        sources_.neutral = sources_.vertex_frames[0];
        clip_.neutral = std::move(*sequence_mesh_);
        if (clip_.vertices->frames > 1)
            findings_.note(fmt::format("no neutral mesh is named; {} stands for it", fs::path(sources_.neutral).filename().string()));
    } else if (clip_.vertices && !unread("neutral")) {
        findings_.warn("no neutral mesh is named: without its triangles the vertices are a cloud of points");
    }
}

}  // namespace mien::io
