#include "bench/report.hpp"

#include <cerrno>
#include <cmath>
#include <cstring>
#include <fstream>
#include <nlohmann/json.hpp>
#include <sstream>

#include "core/environment_error.hpp"
#include "source_hash.hpp"

namespace mien::bench {

constexpr const char* kFormat = "mien-bench report 1";

NLOHMANN_DEFINE_TYPE_NON_INTRUSIVE(Machine, processor, system, compiler, cores, read_gbytes_per_s, sgemm_gflops)
NLOHMANN_DEFINE_TYPE_NON_INTRUSIVE(ClipFacts, name, key, kind, frame_rate, frames_per_second, frames, points, triangles,
                                   texture_width, texture_height, connectivity_bytes, draco_sorted_bytes, draco_ordered_bytes)
NLOHMANN_DEFINE_TYPE_NON_INTRUSIVE(GeometryRow, clip, codec, library, mode, asked_rms, bytes, parts, apart, kbps,
                                   bits_per_vertex_frame, rms, peak, kg, failed)
NLOHMANN_DEFINE_TYPE_NON_INTRUSIVE(TimingRow, clip, run, set, codec, library, unit_frames, samples, asked_rms, median, lower,
                                   upper, ns_per_point, ratio)
// JSON has no infinity: what equals the truth has no PSNR, written as null.
namespace {
nlohmann::json finite(double v) {
    return std::isfinite(v) ? nlohmann::json(v) : nlohmann::json();
}
double decibels(const nlohmann::json& j) {
    return j.is_null() ? std::numeric_limits<double>::infinity() : j.get<double>();
}
}  // namespace
void to_json(nlohmann::json& j, const TextureRow& r) {
    j = {{"clip", r.clip},
         {"codec", r.codec},
         {"library", r.library},
         {"series", r.series},
         {"asked_kbps", r.asked_kbps},
         {"kbps", r.kbps},
         {"psnr_y", finite(r.psnr_y)},
         {"ssim", r.ssim},
         {"worst_psnr_y", finite(r.worst_psnr_y)},
         {"pulse", r.pulse},
         {"failed", r.failed}};
}
void from_json(const nlohmann::json& j, TextureRow& r) {
    r = {j.at("clip"),
         j.at("codec"),
         j.at("library"),
         j.at("series"),
         j.at("asked_kbps"),
         j.at("kbps"),
         decibels(j.at("psnr_y")),
         j.at("ssim"),
         decibels(j.at("worst_psnr_y")),
         j.value("pulse", 0.0),
         j.at("failed")};
}
void to_json(nlohmann::json& j, const ViewRow& r) {
    j = {{"clip", r.clip},
         {"geometry", r.geometry},
         {"texture", r.texture},
         {"library", r.library},
         {"series", r.series},
         {"asked_kbps", r.asked_kbps},
         {"kbps", r.kbps},
         {"geometry_kbps", r.geometry_kbps},
         {"psnr_y", finite(r.psnr_y)},
         {"ssim", r.ssim},
         {"worst_psnr_y", finite(r.worst_psnr_y)},
         {"pictures", r.pictures},
         {"failed", r.failed}};
}
void from_json(const nlohmann::json& j, ViewRow& r) {
    r = {j.at("clip"),
         j.at("geometry"),
         j.at("texture"),
         j.at("library"),
         j.at("series"),
         j.at("asked_kbps"),
         j.at("kbps"),
         j.at("geometry_kbps"),
         decibels(j.at("psnr_y")),
         j.at("ssim"),
         decibels(j.at("worst_psnr_y")),
         j.at("pictures"),
         j.at("failed")};
}
NLOHMANN_DEFINE_TYPE_NON_INTRUSIVE(Report, commands, version, date, machine, codecs, absent, clips, geometry, timing, texture,
                                   views)

std::string own_library() {
    return "mien " MIEN_VERSION "-" MIEN_SOURCE_HASH;
}

const ClipFacts* Report::clip(const std::string& key) const {
    for (const ClipFacts& facts : clips)
        if (facts.key == key) return &facts;
    return nullptr;
}

std::string to_json(const Report& report) {
    nlohmann::json j = report;
    j["format"] = kFormat;
    return j.dump(1) + "\n";
}

Result<Report> read_json(const std::filesystem::path& path) {
    std::ifstream file(path);
    if (!file) return Error{ErrorCode::missing, "no report '" + path.string() + "'"};
    try {
        const nlohmann::json j = nlohmann::json::parse(file);
        if (j.value("format", "") != kFormat)
            return Error{ErrorCode::damaged,
                         "'" + path.string() + "' is no report of this version of mien-bench; name another file, or use --force"};
        return j.get<Report>();
    } catch (const nlohmann::json::exception& error) {
        return Error{ErrorCode::damaged, "'" + path.string() + "' is no report of mien-bench (" + error.what() +
                                             "); name another file, or use --force"};
    }
}

void write_file(const std::filesystem::path& path, const std::string& text) {
    const std::filesystem::path part = path.string() + ".part";
    const auto complain = [&] { throw EnvironmentError("cannot write '" + path.string() + "': " + std::strerror(errno)); };
    std::ofstream file(part, std::ios::binary);
    if (!file) complain();
    file << text;
    file.close();
    if (!file) complain();
    std::error_code error;
    std::filesystem::rename(part, path, error);
    if (error) throw EnvironmentError("cannot write '" + path.string() + "': " + error.message());
}

std::string to_csv(const Report& report) {
    std::ostringstream out;
    out.precision(9);
    const auto text = [](const std::string& s) {
        if (s.find_first_of(",\"\n") == std::string::npos) return s;
        std::string quoted = "\"";
        for (char c : s) quoted += c == '"' ? "\"\"" : std::string(1, c);
        return quoted + '"';
    };
    out << "table,clip,codec,library,series,asked,kbps,bits_per_vertex_frame,rms,peak,kg_percent,psnr_y_db,ssim,worst_psnr_y_db,"
           "median_s,lower_quartile_s,"
           "upper_quartile_s,ratio,failed\n";
    for (const GeometryRow& r : report.geometry)
        out << "geometry," << text(r.clip) << ',' << r.codec << ',' << text(r.library) << ',' << r.mode << ',' << r.asked_rms
            << ',' << r.kbps << ',' << r.bits_per_vertex_frame << ',' << r.rms << ',' << r.peak << ',' << r.kg << ",,,,,,,,"
            << text(r.failed) << '\n';
    for (const TimingRow& r : report.timing)
        out << "timing," << text(r.clip) << ',' << r.codec << ',' << text(r.library) << ',' << r.set << ',' << r.asked_rms
            << ",,,,,,,,," << r.median << ',' << r.lower << ',' << r.upper << ',' << r.ratio << ",\n";
    for (const TextureRow& r : report.texture)
        out << "texture," << text(r.clip) << ',' << r.codec << ',' << text(r.library) << ',' << r.series << ',' << r.asked_kbps
            << ',' << r.kbps << ",,,,," << r.psnr_y << ',' << r.ssim << ',' << r.worst_psnr_y << ",,,,," << text(r.failed)
            << '\n';
    for (const ViewRow& r : report.views)
        out << "views," << text(r.clip) << ',' << r.geometry << '+' << r.texture << ',' << text(r.library) << ',' << r.series
            << ',' << r.asked_kbps << ',' << r.kbps << ",,,,," << r.psnr_y << ',' << r.ssim << ',' << r.worst_psnr_y << ",,,,,"
            << text(r.failed) << '\n';
    return out.str();
}

}  // namespace mien::bench
