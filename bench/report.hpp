#pragma once

#include <filesystem>
#include <map>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "core/result.hpp"

/// What the bench has found, as plain values: written as JSON, CSV, HTML and Markdown, read back from JSON to go on.
namespace mien::bench {

using Parts = std::vector<std::pair<std::string, std::uint64_t>>;

struct Machine {
    std::string processor, system, compiler;
    int cores = 0;
    double read_gbytes_per_s = 0;  ///< one core, sum over a buffer larger than the caches; median of several
    double sgemm_gflops = 0;       ///< one core, Eigen, 768 x 768 x 768
};

struct ClipFacts {
    std::string name, key, kind;  ///< key: hash of what was measured; kind: vertices, markers, weights, or empty
    std::string frame_rate;
    double frames_per_second = 0;
    std::int64_t frames = 0, points = 0, triangles = 0;
    int texture_width = 0, texture_height = 0;
    std::uint64_t connectivity_bytes = 0;  ///< as mien stores it, texture coordinates included; 0: not known
    std::uint64_t draco_sorted_bytes = 0, draco_ordered_bytes = 0;  ///< triangles alone; 0: not known
};

struct GeometryRow {
    std::string clip, codec, library, mode;
    double asked_rms = 0;
    std::uint64_t bytes = 0;
    Parts parts, apart;
    double kbps = 0, bits_per_vertex_frame = 0;  ///< of `bytes`
    double rms = 0, peak = 0, kg = 0;            ///< mm (weights: weight units), KG in percent
    std::string failed;                          ///< why there is no figure; empty: there is
};

/// Decoding of several codecs in turn, unit by unit, in one run. Times are seconds per frame.
struct TimingRow {
    std::string clip, run, set, codec, library;  ///< run: what took part in it; set: "frame", "group" or "encode"
    std::int64_t unit_frames = 1, samples = 0;
    double asked_rms = 0;
    double median = 0, lower = 0, upper = 0;  ///< quartiles
    double ns_per_point = 0;                  ///< of the median
    double ratio = 0;                         ///< median over units of this codec's time / the first row's of the set
};

struct TextureRow {
    std::string clip, codec, library, series;  ///< series: mien, plain
    double asked_kbps = 0, kbps = 0;
    double psnr_y = 0, ssim = 0, worst_psnr_y = 0;
    double pulse = 0;  ///< dB that the first picture of a group is better than the one before it, mean over groups
    std::string failed;
};

struct ViewRow {
    std::string clip, geometry, texture, library, series;  ///< geometry codec, texture codec, texture series
    double asked_kbps = 0, kbps = 0, geometry_kbps = 0;
    double psnr_y = 0, ssim = 0, worst_psnr_y = 0;
    std::int64_t pictures = 0;
    std::string failed;
};

struct Report {
    std::vector<std::string> commands;  ///< that made it, oldest first
    std::string version, date;
    Machine machine;
    std::map<std::string, std::string> codecs;  ///< name: what it is
    std::vector<std::pair<std::string, std::string>> absent;
    std::vector<ClipFacts> clips;
    std::vector<GeometryRow> geometry;
    std::vector<TimingRow> timing;
    std::vector<TextureRow> texture;
    std::vector<ViewRow> views;

    const ClipFacts* clip(const std::string& key) const;
};

std::string own_library();  ///< "mien 0.1.0-1a2b3c4d": the version and a hash of the sources that make the codecs

/// How the report begins as JSON and as CSV, spaces and line ends apart.
inline constexpr std::string_view kJsonBegin = R"({"absent":)", kCsvBegin = "table,clip,codec,library,series,";

/// Errors name the file: `missing` when it is not there, `damaged` when it is no report of this program.
Result<Report> read_json(const std::filesystem::path& path);
// Throw EnvironmentError when the file cannot be written; a file is whole or as it was before.
void write_file(const std::filesystem::path& path, const std::string& text);
std::string to_json(const Report& report);
std::string to_csv(const Report& report);
std::string to_html(const Report& report);
/// Tables for docs/results.md.
std::string to_markdown(const Report& report);

}  // namespace mien::bench
