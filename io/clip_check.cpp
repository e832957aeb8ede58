#include "io/clip_check.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <nlohmann/json.hpp>

#include "io/clip_folder.hpp"
#include "io/clip_validation.hpp"

namespace mien::io {
namespace {

const char* name_of(Severity severity) {
    return severity == Severity::problem ? "problem" : severity == Severity::warning ? "warning" : "note";
}

void measure_box(const Clip& clip, ClipReport& report) {
    Vec3 low = Vec3::Constant(INFINITY), high = Vec3::Constant(-INFINITY);
    const auto add = [&](const float* xyz, std::size_t points) {
        for (std::size_t i = 0; i < points; ++i) {
            const Eigen::Map<const Vec3> p(xyz + 3 * i);
            if (!p.allFinite()) continue;
            low = low.cwiseMin(p);
            high = high.cwiseMax(p);
        }
    };
    if (clip.vertices) add(clip.vertices->xyz.data(), clip.vertices->xyz.size() / 3);
    if (clip.markers) add(clip.markers->xyz.data(), clip.markers->xyz.size() / 3);
    if (clip.neutral && !(low.x() <= high.x())) add(clip.neutral->positions.data(), std::size_t(clip.neutral->positions.rows()));
    report.has_box = low.x() <= high.x();
    if (report.has_box) {
        report.low = low;
        report.high = high;
    }
}

/// Frames of one part that cannot be read, by why: a video that is cut off says the same of many.
class UnreadFrames {
public:
    void add(std::int64_t frame, const Error& why) { frames_of_why_[why.message].add(frame); }
    void report(Findings& findings, const char* one, const char* many) const {
        for (const auto& [why, frames] : frames_of_why_) findings.problem(ErrorCode::damaged, fmt::format("{}: {}", frames.text(one, many), why));
    }

private:
    std::map<std::string, IndexRanges> frames_of_why_;
};

/// Frames that cannot be decoded show only when they are read.
void check_texture(const Clip& clip, Findings& findings, const Progress& progress) {
    if (!clip.texture) return;
    UnreadFrames unread;
    const std::int64_t frames = std::min(clip.texture->frames(), std::max<std::int64_t>(clip.frame_count(), 1));
    for (std::int64_t f = 0; f < frames; ++f) {
        if (const auto image = clip.texture->read(f); !image) unread.add(f, image.error());
        if (progress) progress("checking texture", f + 1, frames);
    }
    unread.report(findings, "texture frame", "texture frames");
}

/// Reads every scan: what cannot be read or is infinite is a problem. Returns the share of texels that were seen.
double check_scans(const Clip& clip, Findings& findings, const Progress& progress) {
    UnreadFrames unread;
    const std::int64_t frames = std::min(clip.scans->frames(), std::max<std::int64_t>(clip.frame_count(), 1));
    std::int64_t seen = 0, all = 0;
    for (std::int64_t f = 0; f < frames; ++f) {
        // Map by map, as all that cannot be read is told.
        for (const ScanParts part : {ScanParts{.medium = true, .fine = false, .albedo = false}, {.medium = false, .fine = true, .albedo = false}, {.medium = false, .fine = false, .albedo = true}}) {
            const auto scan = clip.scans->read(f, part);
            if (!scan) {
                unread.add(f, scan.error());
                continue;
            }
            for (std::size_t i = 0; i < scan->medium.values.size(); i += 3) seen += std::isfinite(scan->medium.values[i]);
            all += std::int64_t(scan->medium.values.size() / 3);
        }
        if (progress) progress("checking scans", f + 1, frames);
    }
    unread.report(findings, "scan", "scans");
    if (all > 0 && seen == 0) findings.problem(ErrorCode::invalid, "the scans show no texel at all");
    return all > 0 ? double(seen) / double(all) : 0;
}

}  // namespace

ClipReport check_clip(const std::filesystem::path& path, const Progress& progress) {
    LoadOptions options;
    options.progress = progress;
    ClipReading reading = read_clip(path, options);
    const Clip& clip = reading.clip;
    check_texture(clip, reading.findings, progress);

    ClipReport report;
    report.name = clip.name;
    report.unit = mien::name_of(clip.unit);
    report.frame_rate = clip.frame_rate;
    report.frames = clip.frame_count();
    report.seconds = double(report.frames) / clip.frame_rate.value();
    if (clip.neutral) {
        report.vertices = clip.neutral->positions.rows();
        report.triangles = std::int64_t(clip.neutral->triangles.size());
        report.texcoords = std::int64_t(clip.neutral->texcoords.size());
    }
    if (clip.vertices) {
        report.vertices = clip.vertices->points;
        report.vertex_frames = clip.vertices->frames;
    }
    if (clip.markers) {
        report.markers = clip.markers->points;
        std::size_t present = 0;
        const std::size_t all = clip.markers->xyz.size() / 3;
        for (std::size_t i = 0; i < all; ++i) present += !std::isnan(clip.markers->xyz[3 * i]);
        report.markers_present = all ? double(present) / double(all) : 0;
    }
    report.marker_sites = std::int64_t(clip.marker_sites.size());
    if (clip.weights) report.weights = clip.weights->count;
    report.blendshapes = std::int64_t(clip.blendshapes.size());
    report.rigid = std::int64_t(clip.rigid.size());
    report.head_pose = !clip.head_pose.empty();
    report.gaze = !clip.gaze.empty();
    report.mask = clip.mask.has_value();
    measure_box(clip, report);
    if (clip.texture) {
        report.texture_width = clip.texture->width();
        report.texture_height = clip.texture->height();
        report.texture_frames = clip.texture->frames();
        if (report.texture_width % 2 || report.texture_height % 2)
            reading.findings.note(fmt::format("the texture is {} x {}; odd sides are padded by one texel when encoded", report.texture_width, report.texture_height));
    }
    if (clip.scans) {
        report.scan_medium_size = clip.scans->medium_size();
        report.scan_fine_size = clip.scans->fine_size();
        report.scan_albedo = clip.scans->has_albedo();
        report.scan_frames = clip.scans->frames();
        report.scan_seen = check_scans(clip, reading.findings, progress);
    }
    report.takes = std::int64_t(clip.takes.size());
    if (clip.sound) {
        report.sound_rate = clip.sound->sample_rate;
        report.sound_channels = clip.sound->channels;
        report.sound_seconds = clip.sound->seconds();
    }
    report.findings = reading.findings.all();
    for (Finding& finding : report.findings)
        if (finding.severity == Severity::grave) finding.severity = Severity::problem;
    std::stable_sort(report.findings.begin(), report.findings.end(), [](const Finding& a, const Finding& b) { return a.severity > b.severity; });
    return report;
}

bool ClipReport::good() const {
    return std::none_of(findings.begin(), findings.end(), [](const Finding& f) { return f.severity == Severity::problem; });
}

std::string ClipReport::text() const {
    std::string s;
    if (!name.empty()) s = fmt::format("{}: {} frame{} at {} Hz, {:.3f} s, unit {}\n", name, frames, frames == 1 ? "" : "s", to_string(frame_rate), seconds, unit);
    const auto line = [&](const char* what, std::string value) { s += fmt::format("  {:<12}{}\n", what, value); };
    if (triangles > 0) line("mesh", fmt::format("{} vertices, {} triangles, {} texture coordinates", vertices, triangles, texcoords));
    if (vertex_frames > 0) line("vertices", fmt::format("{} frame{} of {}", vertex_frames, vertex_frames == 1 ? "" : "s", vertices));
    if (markers > 0) line("markers", fmt::format("{}{}, {:.1f} % present", markers, marker_sites ? " with their places on the mesh" : "", 100 * markers_present));
    if (weights > 0) line("weights", fmt::format("{}, {} target shapes", weights, blendshapes));
    if (rigid > 0) line("rigid", fmt::format("{} points move with the skull", rigid));
    if (head_pose || gaze) line("known", fmt::format("{}{}{}", head_pose ? "head pose" : "", head_pose && gaze ? ", " : "", gaze ? "gaze" : ""));
    if (has_box) {
        const Vec3 size = high - low;
        line("box", fmt::format("{:.1f} x {:.1f} x {:.1f} mm from ({:.1f}, {:.1f}, {:.1f})", size.x(), size.y(), size.z(), low.x(), low.y(), low.z()));
    }
    if (texture_frames > 0) line("texture", fmt::format("{} x {}, {}{}", texture_width, texture_height, texture_frames == 1 ? "static" : fmt::format("{} frames", texture_frames), mask ? ", with a mask" : ""));
    if (scan_frames > 0)
        line("scans", fmt::format("{} frames, {}² medium, {}² fine{}, {:.1f} % of the texels seen", scan_frames, scan_medium_size, scan_fine_size, scan_albedo ? " and albedo" : "", 100 * scan_seen));
    if (takes > 0) line("takes", fmt::format("{}", takes));
    if (sound_rate > 0) line("sound", fmt::format("{} Hz, {} channel{}, {:.3f} s", sound_rate, sound_channels, sound_channels == 1 ? "" : "s", sound_seconds));
    for (const Finding& finding : findings) s += fmt::format("{}: {}\n", name_of(finding.severity), finding.text);
    if (good()) s += "no problems\n";
    return s;
}

std::string ClipReport::json() const {
    nlohmann::ordered_json j;
    j["name"] = name;
    j["good"] = good();
    j["frames"] = frames;
    j["fps"] = to_string(frame_rate);
    j["duration_s"] = seconds;
    j["unit"] = unit;
    j["mesh"] = {{"vertices", vertices}, {"triangles", triangles}, {"texcoords", texcoords}};
    j["vertex_frames"] = vertex_frames;
    j["markers"] = markers;
    j["markers_present"] = markers_present;
    j["marker_sites"] = marker_sites;
    j["weights"] = weights;
    j["blendshapes"] = blendshapes;
    j["rigid"] = rigid;
    j["head_pose"] = head_pose;
    j["gaze"] = gaze;
    j["mask"] = mask;
    if (has_box) j["box_mm"] = {{low.x(), low.y(), low.z()}, {high.x(), high.y(), high.z()}};
    if (texture_frames > 0) j["texture"] = {{"width", texture_width}, {"height", texture_height}, {"frames", texture_frames}};
    if (scan_frames > 0)
        j["scans"] = {{"frames", scan_frames}, {"medium_size", scan_medium_size}, {"fine_size", scan_fine_size}, {"albedo", scan_albedo}, {"seen", scan_seen}};
    if (takes > 0) j["takes"] = takes;
    if (sound_rate > 0) j["sound"] = {{"sample_rate", sound_rate}, {"channels", sound_channels}, {"seconds", sound_seconds}};
    j["findings"] = nlohmann::ordered_json::array();
    for (const Finding& finding : findings) j["findings"].push_back({{"severity", name_of(finding.severity)}, {"text", finding.text}});
    // Names come from files and need not be UTF-8.
    return j.dump(1, ' ', false, nlohmann::ordered_json::error_handler_t::replace);
}

}  // namespace mien::io
