#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "io/clip_description.hpp"
#include "io/clip_folder.hpp"
#include "io/clip_validation.hpp"

/// What read_clip() is made of; not for other rooms.
namespace mien::io {

inline const std::vector<std::string> kMeshEndings{".obj", ".ply"};

/// Reads one part after another into the clip. Each step reports what is wrong and leaves its part out.
class ClipReader {
public:
    ClipReader(const std::filesystem::path& path, const LoadOptions& options) : path_(path), options_(options) {}
    ClipReading read();

private:
    /// The value, or nothing and a problem.
    template <class T>
    std::optional<T> take(Result<T> result) {
        if (result) return std::move(*result);
        findings_.problem(result.error());
        return std::nullopt;
    }
    void problem(ErrorCode code, std::string text) { findings_.problem(code, std::move(text)); }
    bool unread(const char* key) const { return sources_.unread.contains(key); }
    void note_unread(const char* key, bool named, bool there) {
        if (named && !there) sources_.unread.insert(key);
    }

    // clip_folder.cpp
    bool describe();
    /// What tells the reader what no file does.
    std::string how_to_set(const char* key, const std::string& value) const;
    void settle_rate();
    /// All lengths to mm.
    void settle_unit();

    // clip_geometry.cpp
    void read_vertices();
    /// One mesh per frame. The first gives the connectivity; the others must have as many vertices.
    void read_mesh_sequence(const std::vector<std::filesystem::path>& files);
    void read_neutral();

    // clip_markers.cpp
    void read_markers_file();
    /// Rows of numbers, from clip.json itself or from a file.
    std::optional<std::vector<std::vector<double>>> rows_of(const ClipDescription::Numbers& numbers);
    void read_sites();
    void read_rigid();
    void read_pose_and_gaze();
    void read_pose(const std::filesystem::path& path);

    // clip_weights.cpp
    void read_weights();
    void use_live_link(const std::string& text, const std::filesystem::path& path);
    void read_blendshapes();
    std::string target_name(const std::vector<std::string>& names, std::int64_t i) const;
    /// One that does not move, and a problem, if it cannot be used.
    Blendshape read_target(const std::filesystem::path& path);
    void read_target_list(const std::vector<std::filesystem::path>& meshes);
    /// Those that the neutral mesh's own file brings.
    void take_own_targets();
    /// Named targets to named weights, whatever the spelling; by order when the weights have no names.
    void order_by_name(std::vector<Blendshape> shapes, const std::filesystem::path& path);

    // clip_media.cpp
    void read_texture();
    /// The folder or pattern of numbered masks, one per frame, that `masks` names; nothing if it names pictures of the whole clip.
    std::optional<std::filesystem::path> scan_masks() const;
    /// After the unit is known: maps are scaled as they are read.
    void read_scans();
    void read_sound_file();

    std::filesystem::path path_;
    const LoadOptions& options_;
    ClipReading reading_;
    Clip& clip_ = reading_.clip;
    Findings& findings_ = reading_.findings;
    ClipDescription description_;
    ClipSources sources_;
    bool guessed_ = false;
    std::optional<Mesh> sequence_mesh_;
    std::vector<Blendshape> sequence_shapes_;
    std::optional<Unit> marker_unit_;
    std::vector<std::pair<std::string, Rational>> rates_;  ///< what files say, in order of trust
};

}  // namespace mien::io
