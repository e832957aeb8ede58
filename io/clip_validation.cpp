#include "io/clip_validation.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

namespace mien::io {
namespace {

// Heads measure 180 to 300 mm, faces of markers 100 to 200, with neck and shoulders up to 700.
constexpr double kSmallest = 50, kLargest = 1000;
// Faces stretch by tenths, units differ by ten at least; markers may be on a part of the face, or of a whole figure's.
constexpr double kLeastOfNeutral = 1.0 / 3, kLeastOfNeutralByMarkers = 1.0 / 50, kMostOfNeutral = 3;
// A kilometre, mm: beyond it, single-precision coordinates are coarser than a twentieth of a millimetre.
constexpr float kFarthest = 1e6f;

/// Finite, and no farther than anything that is captured.
bool all_near(const float* values, std::int64_t count) {
    const Eigen::Map<const Eigen::ArrayXf> all(values, count);
    // NaN is not below anything either.
    return (all.abs() <= kFarthest).all();
}

/// What is wrong with a point, or nothing.
const char* fault_of(const float* p) {
    if (std::isnan(p[0]) || std::isnan(p[1]) || std::isnan(p[2])) return "not a number";
    if (std::isinf(p[0]) || std::isinf(p[1]) || std::isinf(p[2])) return "infinite";
    return all_near(p, 3) ? nullptr : "more than a kilometre away";
}

void check_vertices(const PointSequence& vertices, const ClipSources& sources, Findings& findings) {
    CappedFindings found(findings, Severity::problem, ErrorCode::invalid, "such vertices");
    for (std::int64_t f = 0; f < vertices.frames; ++f) {
        const float* frame = vertices.xyz.data() + f * vertices.points * 3;
        if (all_near(frame, vertices.points * 3)) continue;
        for (std::int64_t v = 0; v < vertices.points; ++v) {
            const char* fault = fault_of(frame + v * 3);
            if (!fault) continue;
            const auto& source = std::size_t(f) < sources.vertex_frames.size() ? sources.vertex_frames[std::size_t(f)] : sources.vertices;
            found.add(fmt::format("{}: vertex {} of frame {} is {}", source, v, f, fault));
        }
    }
}

void check_markers(const PointSequence& markers, const ClipSources& sources, Findings& findings) {
    std::vector<std::int64_t> present(std::size_t(markers.points));
    std::int64_t empty_frames = 0, first_empty = -1;
    {
        CappedFindings found(findings, Severity::problem, ErrorCode::invalid, "such markers");
        CappedFindings half(findings, Severity::problem, ErrorCode::invalid, "markers that are missing in part");
        for (std::int64_t f = 0; f < markers.frames; ++f) {
            std::int64_t shown = 0;
            for (std::int64_t m = 0; m < markers.points; ++m) {
                const float* p = markers.xyz.data() + (f * markers.points + m) * 3;
                const int nan = std::isnan(p[0]) + std::isnan(p[1]) + std::isnan(p[2]);
                if (nan == 0 && !all_near(p, 3))
                    found.add(fmt::format("{}: marker {} of frame {} is {}", sources.markers, m, f, fault_of(p)));
                else if (nan != 0 && nan != 3)
                    half.add(fmt::format("{}: marker {} of frame {} lacks some of its coordinates", sources.markers, m, f));
                if (nan == 0) {
                    ++shown;
                    ++present[std::size_t(m)];
                }
            }
            if (shown == 0 && empty_frames++ == 0) first_empty = f;
        }
    }
    if (empty_frames == markers.frames) return findings.problem(ErrorCode::invalid, fmt::format("{}: no frame has any marker", sources.markers));
    if (empty_frames > 0)
        findings.warn(fmt::format("{}: {} of {} frames have no marker at all, the first is {}", sources.markers, empty_frames, markers.frames, first_empty));
    CappedFindings never(findings, Severity::warning, ErrorCode::invalid, "markers that are never there");
    for (std::size_t m = 0; m < present.size(); ++m)
        if (present[m] == 0) never.add(fmt::format("{}: marker {} is never there", sources.markers, m));
}

std::string weight_name(const WeightSequence& weights, std::int64_t i) {
    return weights.names.empty() ? std::to_string(i) : fmt::format("{} ({})", i, weights.names[std::size_t(i)]);
}

void check_weights(const WeightSequence& weights, const ClipSources& sources, Findings& findings) {
    std::int64_t far = 0, far_frame = 0, far_weight = 0;
    {
        CappedFindings found(findings, Severity::problem, ErrorCode::invalid, "weights that are not finite");
        for (std::int64_t f = 0; f < weights.frames; ++f)
            for (std::int64_t i = 0; i < weights.count; ++i) {
                const float value = weights.frame(f)[i];
                if (!std::isfinite(value))
                    found.add(fmt::format("{}: weight {} of frame {} is {}", sources.weights, weight_name(weights, i), f,
                                          std::isnan(value) ? "not a number" : "infinite"));
                else if (std::abs(value) > 2 && far++ == 0)
                    far_frame = f, far_weight = i;
            }
    }
    if (far > 0)
        findings.warn(fmt::format("{}: {} values are beyond -2 .. 2, the first is weight {} of frame {}: weights are fractions, not percent", sources.weights,
                                  far, weight_name(weights, far_weight), far_frame));
}

void check_mesh(const Mesh& mesh, const ClipSources& sources, Findings& findings) {
    if (!mesh.positions.allFinite()) {
        CappedFindings found(findings, Severity::problem, ErrorCode::invalid, "vertices that are not finite");
        for (Eigen::Index v = 0; v < mesh.positions.rows(); ++v)
            if (!mesh.positions.row(v).allFinite()) found.add(fmt::format("{}: vertex {} is not finite", sources.neutral, v));
    }
    std::size_t folded = 0;
    for (const Triangle& t : mesh.triangles) folded += t[0] == t[1] || t[1] == t[2] || t[2] == t[0];
    if (folded > 0) findings.warn(fmt::format("{}: {} triangles name a vertex twice", sources.neutral, folded));
    std::size_t outside = 0;
    for (const Vec2& uv : mesh.texcoords) outside += !(uv.x() >= -1e-4f && uv.x() <= 1.0001f && uv.y() >= -1e-4f && uv.y() <= 1.0001f);
    if (outside > 0)
        findings.warn(fmt::format("{}: {} of {} texture coordinates are outside 0 .. 1 and show no texel", sources.neutral, outside, mesh.texcoords.size()));
}

void check_counts(const Clip& clip, const ClipSources& sources, Findings& findings) {
    const std::int64_t frames = clip.frame_count();
    const auto mismatch = [&](std::string text) { findings.problem(ErrorCode::mismatch, std::move(text)); };
    const std::string& leader = clip.vertices ? sources.vertices : clip.markers ? sources.markers : sources.weights;
    const auto same_frames = [&](const std::string& name, std::int64_t count) {
        if (count != frames) mismatch(fmt::format("{} has {} frames, but {} has {}", name, count, leader, frames));
    };
    if (clip.markers) same_frames(sources.markers, clip.markers->frames);
    if (clip.weights) same_frames(sources.weights, clip.weights->frames);
    if (!clip.head_pose.empty()) same_frames(sources.head_pose, std::int64_t(clip.head_pose.size()));
    if (!clip.gaze.empty()) same_frames(sources.gaze, std::int64_t(clip.gaze.size()));

    const std::int64_t vertices = clip.neutral ? clip.neutral->positions.rows() : clip.vertices ? clip.vertices->points : 0;
    if (clip.neutral && clip.vertices && clip.vertices->points != vertices)
        mismatch(fmt::format("{} has {} vertices a frame, but {} has {}", sources.vertices, clip.vertices->points, sources.neutral, vertices));
    if (!clip.marker_sites.empty()) {
        if (!clip.markers) findings.warn("marker_sites are given without markers");
        else if (std::int64_t(clip.marker_sites.size()) != clip.markers->points)
            mismatch(fmt::format("marker_sites has {} entries, but {} has {} markers", clip.marker_sites.size(), sources.markers, clip.markers->points));
    }
    if (!clip.blendshapes.empty()) {
        if (clip.weights && std::int64_t(clip.blendshapes.size()) != clip.weights->count)
            mismatch(fmt::format("there are {} blendshapes, but {} has {} weights a frame", clip.blendshapes.size(), sources.weights, clip.weights->count));
        for (const Blendshape& shape : clip.blendshapes) {
            if (clip.neutral && shape.offsets.rows() != vertices)
                mismatch(fmt::format("blendshape {} has {} vertices, but {} has {}", shape.name, shape.offsets.rows(), sources.neutral, vertices));
            if (!shape.offsets.allFinite()) findings.problem(ErrorCode::invalid, fmt::format("blendshape {} is not finite", shape.name));
        }
    }
    const bool of_markers = clip.markers && !clip.vertices;
    const std::int64_t points = of_markers ? clip.markers->points : vertices;
    CappedFindings outside(findings, Severity::problem, ErrorCode::mismatch, "entries of rigid out of range");
    for (const std::uint32_t index : clip.rigid)
        if (index >= points) outside.add(fmt::format("rigid names {} {}, but there are {}", of_markers ? "marker" : "vertex", index, points));
}

void check_media(const Clip& clip, const ClipSources& sources, Findings& findings) {
    const std::int64_t frames = clip.frame_count();
    if (clip.texture) {
        const std::int64_t there = clip.texture->frames();
        if (there != 1 && there < frames)
            findings.problem(ErrorCode::mismatch, fmt::format("{} has {} frames, but the motion has {}", sources.texture, there, frames));
        else if (there != 1 && there > frames)
            findings.warn(fmt::format("{} has {} frames, the motion only {}; the rest is left out", sources.texture, there, frames));
        if (!clip.neutral || !clip.neutral->has_texcoords())
            findings.warn(fmt::format("{} cannot be shown: the neutral mesh has no texture coordinates", sources.texture));
        if (clip.mask && (clip.mask->width != clip.texture->width() || clip.mask->height != clip.texture->height()))
            findings.problem(ErrorCode::mismatch, fmt::format("the mask is {} x {}, but {} is {} x {}", clip.mask->width, clip.mask->height, sources.texture,
                                                              clip.texture->width(), clip.texture->height()));
    }
    if (clip.scans) {
        if (clip.scans->frames() < frames) findings.problem(ErrorCode::mismatch, fmt::format("there are scans of {} frames, but the motion has {}", clip.scans->frames(), frames));
        if (clip.scans->frames() > frames) findings.warn(fmt::format("there are scans of {} frames, the motion has only {}; the rest is left out", clip.scans->frames(), frames));
    }
    if (!clip.takes.empty() && clip.takes.back().first >= frames)
        findings.problem(ErrorCode::mismatch, fmt::format("the last take begins with frame {}, but the motion has {}", clip.takes.back().first, frames));
    if (clip.sound && frames > 0) {
        if (clip.sound->samples.empty()) return findings.problem(ErrorCode::invalid, fmt::format("{} has no samples", sources.sound));
        const double picture = double(frames) / clip.frame_rate.value(), off = clip.sound->seconds() - picture;
        if (std::abs(off) > std::max(0.1, 1.5 / clip.frame_rate.value()))
            findings.warn(fmt::format("{} is {:.2f} s {} than the picture ({:.2f} s)", sources.sound, std::abs(off), off > 0 ? "longer" : "shorter", picture));
    }
}

}  // namespace

std::optional<double> extent(PointsRef points) {
    Vec3 low = Vec3::Constant(INFINITY), high = Vec3::Constant(-INFINITY);
    for (Eigen::Index i = 0; i < points.rows(); ++i) {
        const Vec3 p = points.row(i).transpose();
        if (!p.allFinite()) continue;
        low = low.cwiseMin(p);
        high = high.cwiseMax(p);
    }
    if (!(low.x() <= high.x())) return std::nullopt;
    return double((high - low).maxCoeff());
}

std::optional<double> usual_extent(const PointSequence& points) {
    if (points.points < 4) return std::nullopt;
    const std::int64_t shown = std::min<std::int64_t>(points.frames, 100);
    std::vector<double> sizes;
    for (std::int64_t i = 0; i < shown; ++i)
        if (const auto size = extent(points.frame(i * points.frames / shown))) sizes.push_back(*size);
    if (sizes.empty()) return std::nullopt;
    std::nth_element(sizes.begin(), sizes.begin() + std::ptrdiff_t(sizes.size() / 2), sizes.end());
    return sizes[sizes.size() / 2];
}

std::optional<double> head_size(const Clip& clip) {
    if (clip.neutral)
        if (const auto size = extent(clip.neutral->positions)) return size;
    for (const auto* sequence : {&clip.vertices, &clip.markers}) {
        if (!*sequence) continue;
        if (const auto size = usual_extent(**sequence)) return size;
    }
    return std::nullopt;
}

std::optional<Unit> plausible_unit(double size) {
    if (size >= 80 && size <= 1000) return Unit::mm;
    if (size >= 8 && size < 80) return Unit::cm;
    if (size >= 0.08 && size <= 1) return Unit::m;
    return std::nullopt;
}

namespace {

std::string length(double mm) { return mm >= 1e3 ? fmt::format("{:.4g} m", mm / 1000) : fmt::format("{:.3g} mm", mm); }

/// The motion against its neutral mesh, and the head against what heads measure.
void check_size(const Clip& clip, const ClipSources& sources, Findings& findings) {
    const auto neutral = clip.neutral ? extent(clip.neutral->positions) : std::nullopt;
    const auto compare = [&](const std::optional<PointSequence>& points, const std::string& source, double least) {
        const auto size = points ? usual_extent(*points) : std::nullopt;
        if (!size || !neutral || !(*neutral > 0)) return;
        if (*size >= least * *neutral && *size <= kMostOfNeutral * *neutral) return;
        findings.problem(ErrorCode::mismatch, fmt::format("{} is {} large, but {} is {}: are they in one unit?", source, length(*size), sources.neutral, length(*neutral)));
    };
    compare(clip.vertices, sources.vertices, kLeastOfNeutral);
    compare(clip.markers, sources.markers, kLeastOfNeutralByMarkers);

    const auto size = head_size(clip);
    if (!size || (*size >= kSmallest && *size <= kLargest)) return;
    if (*size == 0) return findings.warn_gravely("all points lie in one place");
    const auto meant = plausible_unit(*size / millimetres(clip.unit));
    if (meant && *meant != clip.unit)
        return findings.warn_gravely(fmt::format("the head is {} large; probably the unit should be {}, not {}: {}", length(*size), name_of(*meant), name_of(clip.unit),
                                                 sources.unit_asked ? fmt::format("ask for {}, or for none", name_of(*meant))
                                                                    : fmt::format("write \"unit\": \"{}\" into clip.json", name_of(*meant))));
    findings.warn_gravely(fmt::format("the head is {} large, which fits no unit; is this a head?", length(*size)));
}

}  // namespace

void validate(const Clip& clip, const ClipSources& sources, Findings& findings) {
    if (!clip.vertices && !clip.markers && !clip.weights) {
        if (!findings.has_problem())
            findings.problem(ErrorCode::missing, "the clip has no motion: at least one of vertices, markers and weights is needed");
        return;
    }
    if (clip.frame_count() == 0) findings.problem(ErrorCode::invalid, "the clip is empty: it has no frames");
    check_counts(clip, sources, findings);
    if (clip.neutral) check_mesh(*clip.neutral, sources, findings);
    if (clip.vertices) check_vertices(*clip.vertices, sources, findings);
    if (clip.markers && clip.markers->frames > 0) check_markers(*clip.markers, sources, findings);
    if (clip.weights) check_weights(*clip.weights, sources, findings);
    for (std::size_t f = 0; f < clip.head_pose.size(); ++f)
        if (!clip.head_pose[f].translation.allFinite() || !clip.head_pose[f].rotation.coeffs().allFinite())
            findings.problem(ErrorCode::invalid, fmt::format("{}: frame {} is not finite", sources.head_pose, f));
    for (std::size_t f = 0; f < clip.gaze.size(); ++f)
        for (int eye = 0; eye < 2; ++eye)
            if (!std::isfinite(clip.gaze[f].yaw[eye]) || !std::isfinite(clip.gaze[f].pitch[eye]))
                findings.problem(ErrorCode::invalid, fmt::format("{}: frame {} is not finite", sources.gaze, f));
    check_size(clip, sources, findings);
    check_media(clip, sources, findings);
}

}  // namespace mien::io
