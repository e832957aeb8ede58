#include <fmt/core.h>

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>

#include "core/picture_measures.hpp"
#include "core/texel_map.hpp"
#include "io/clip_folder.hpp"
#include "tools/commands.hpp"
#include "tools/console.hpp"
#include "tools/motion_error.hpp"
#include "tools/options.hpp"
#include "tools/stored_stream.hpp"
#include "tools/stream_clip.hpp"

namespace mien::tools {
namespace {

using nlohmann::ordered_json;
using protocol::MotionKind;

/// Neutral shapes further apart are of two faces, or of two fits: what is stored is within a tenth of the motion error.
constexpr double kSameNeutral = 1.0;  // mm RMS
/// Errors below these may exceed the motion itself, of a clip that hardly moves.
constexpr double kNoticeable = 0.5, kNoticeableWeight = 0.05;  // mm RMS; weight
constexpr double kOther = 1.2;  // times the error of a still face; that of another performance about the same mean is 1.4 times it

struct Request {
    std::string file, clip;
    bool json = false, no_texture = false;
    std::optional<double> max_rms, max_peak;
    Rungs rungs;
};

Error differ(const std::string& what, std::int64_t stream, std::int64_t clip) {
    return {ErrorCode::mismatch, fmt::format("the stream has {} {} but the clip has {}", stream, what, clip)};
}

Result<MotionError> compare_motion(const Clip& truth, const Clip& received, MotionKind kind) {
    MotionError error;
    const auto points = [&](const std::optional<PointSequence>& a, const std::optional<PointSequence>& b, const char* what) -> Result<void> {
        if (!a) return Error{ErrorCode::mismatch, std::string("the stream carries ") + what + ", which the clip does not have"};
        if (a->points != b->points) return differ(what, b->points, a->points);
        if (a->frames != b->frames) return differ("frames", b->frames, a->frames);
        for (std::int64_t f = 0; f < a->frames; ++f) error.add(a->frame(f).data(), b->frame(f).data(), a->points, 3);
        return {};
    };
    if (kind == MotionKind::vertices) MIEN_CHECK(points(truth.vertices, received.vertices, "vertices"));
    if (kind == MotionKind::markers) MIEN_CHECK(points(truth.markers, received.markers, "markers"));
    if (kind == MotionKind::weights) {
        if (!truth.weights) return Error{ErrorCode::mismatch, "the stream carries weights, which the clip does not have"};
        if (truth.weights->count != received.weights->count) return differ("weights", received.weights->count, truth.weights->count);
        if (truth.weights->frames != received.weights->frames) return differ("frames", received.weights->frames, truth.weights->frames);
        for (std::int64_t f = 0; f < truth.weights->frames; ++f) error.add(truth.weights->frame(f), received.weights->frame(f), truth.weights->count, 1);
    }
    return error;
}

/// RMS distance of the two neutral meshes, mm; none where there is no such pair.
std::optional<double> neutral_distance(const Clip& truth, const Clip& received) {
    if (!truth.neutral || !received.neutral || truth.neutral->positions.rows() != received.neutral->positions.rows() || truth.neutral->vertex_count() == 0) return {};
    return std::sqrt((truth.neutral->positions - received.neutral->positions).rowwise().squaredNorm().cast<double>().mean());
}

double still_error(const Clip& truth, MotionKind kind) {
    if (kind == MotionKind::weights) return still_rms(truth.weights->values, truth.weights->count, 1);
    const PointSequence& points = kind == MotionKind::vertices ? *truth.vertices : *truth.markers;
    return still_rms(points.xyz, points.points, 3);
}

/// The drawn mesh against the clip's own vertices: what markers or weights leave of the truth.
Result<std::optional<MotionError>> compare_mesh(const StoredStream& stream, const Clip& truth, std::size_t rung) {
    MIEN_TRY(model, stream.model());
    if (!truth.vertices || model.point_count() != truth.vertices->points) return std::optional<MotionError>{};
    MIEN_TRY(decoder, stream.motion_decoder(model, rung));
    const model::LinearMotion composed = model::compose(model, decoder.basis());
    MotionError error;
    MIEN_CHECK(stream.visit_motion(decoder, [&](const model::Motion& motion) -> Result<void> {
        if (motion.frame >= truth.vertices->frames) return {};
        const Points drawn = model::evaluate(model, composed, motion);
        error.add(truth.vertices->frame(motion.frame).data(), drawn.data(), drawn.rows(), 3);
        return {};
    }));
    return std::optional(error);
}

/// Bilinear, as a GPU samples it.
Image enlarged(const Image& picture, int width, int height) {
    if (picture.width == width && picture.height == height) return picture;
    Image large(width, height, picture.channels);
    const auto place = [](int at, int to, int from) { return std::clamp((at + 0.5f) * float(from) / float(to) - 0.5f, 0.0f, float(from - 1)); };
    for (int y = 0; y < height; ++y)
        for (int x = 0; x < width; ++x) {
            const float u = place(x, width, picture.width), v = place(y, height, picture.height);
            const int u0 = int(u), v0 = int(v), u1 = std::min(u0 + 1, picture.width - 1), v1 = std::min(v0 + 1, picture.height - 1);
            for (int c = 0; c < picture.channels; ++c) {
                const float above = std::lerp(float(picture.at(u0, v0)[c]), float(picture.at(u1, v0)[c]), u - float(u0));
                const float below = std::lerp(float(picture.at(u0, v1)[c]), float(picture.at(u1, v1)[c]), u - float(u0));
                large.at(x, y)[c] = std::uint8_t(std::lround(std::lerp(above, below, v - float(v0))));
            }
        }
    return large;
}

Result<std::optional<ordered_json>> compare_texture(const Clip& truth, const Clip& received, const Progress& progress) {
    if (!truth.texture || !received.texture) return std::optional<ordered_json>{};
    const int width = truth.texture->width(), height = truth.texture->height();
    // A rung may have fewer texels than the clip: it is compared as it is drawn.
    if (width < received.texture->width() || height < received.texture->height())
        return Error{ErrorCode::mismatch, fmt::format("the stream's texture is {} x {} but the clip's is {} x {}", received.texture->width(),
                                                      received.texture->height(), width, height)};
    std::vector<std::uint8_t> used;
    if (truth.mask && truth.mask->width == width && truth.mask->height == height) {
        used = truth.mask->pixels;
    } else if (truth.neutral && truth.neutral->has_texcoords()) {
        const TexelMap map = make_texel_map(*truth.neutral, width, height);
        for (const auto& texel : map.texels) used.push_back(texel.triangle != TexelMap::kNone);
    }
    PictureComparison comparison(width, height, used);
    const std::int64_t frames = std::min(truth.texture->frames(), received.texture->frames());
    for (std::int64_t f = 0; f < frames; ++f) {
        if (progress) progress("comparing texture", f, frames);
        MIEN_TRY(a, truth.texture->read(f));
        MIEN_TRY(b, received.texture->read(f));
        comparison.add(a, enlarged(b, width, height));
    }
    return std::optional(ordered_json{{"psnr_y_db", comparison.psnr_y()}, {"ssim", comparison.ssim()}, {"frames", comparison.frames()}});
}

/// What the stream lacks of the sound that goes with the picture. At another rate than the clip's it ends within a sample of the clip's.
double missing_seconds(const Clip& truth, const Clip& received) {
    const double picture = double(truth.frame_count()) / truth.frame_rate.value();
    const double missing = std::min(truth.sound->seconds(), picture) - (received.sound ? received.sound->seconds() : 0);
    const double sample = 1.0 / std::min(truth.sound->sample_rate, received.sound ? received.sound->sample_rate : truth.sound->sample_rate);
    return missing > sample ? missing : 0;
}

Result<int> compare(const Request& request, const StoredStream& stream, const Progress& progress) {
    MIEN_TRY(loaded, io::load_clip(request.clip, {.frame_rate = {}, .unit = {}, .progress = progress}));
    MIEN_TRY(received, decode_stream(stream, progress, request.no_texture ? Keep::bare : Keep::textured, nullptr, request.rungs));
    const Clip& truth = loaded.clip;
    const auto kind = std::get<protocol::MotionInfo>(stream.track(protocol::TrackKind::motion)->info).kind;
    const bool weights = kind == MotionKind::weights;

    ordered_json report;
    std::vector<std::string> complaints, not_compared;
    if (!stream.reader().complete()) complaints.push_back(stream.reader().complaint());
    // A trained model may be driven by the markers of whoever.
    const auto& layers = stream.reader().manifest().layers;
    const bool trained = std::any_of(layers.begin(), layers.end(), [](const auto& layer) { return layer.kind == protocol::LayerKind::marker_domain; });
    if (const auto apart = neutral_distance(truth, received); apart && !trained && !(*apart <= kSameNeutral))
        complaints.push_back(fmt::format("the stream is of another face: its neutral mesh is {:.2f} mm RMS from the clip's", *apart));
    MIEN_TRY(motion, compare_motion(truth, received, kind));
    report["motion"] = {{"rms_mm", motion.rms()}, {"peak_mm", motion.peak()}, {"mean_mm", motion.mean()}, {"kg_percent", motion.kg_percent()},
                        {"unit", weights ? "weight" : "mm"}, {"points", motion.points()}};
    if (!std::isfinite(motion.peak())) complaints.push_back("the decoded motion has numbers that are not finite");
    // Whoever names a bound, or asks for a coarse rung, knows what to expect.
    if (!request.max_rms && request.rungs.motion == StoredStream::kAllRungs)
        if (const double still = still_error(truth, kind); motion.rms() > kOther * std::max(still, weights ? kNoticeableWeight : kNoticeable))
            complaints.push_back(fmt::format("RMS error {:.3f} exceeds that of a still face, {:.3f}: the stream shows another performance, or very little of this one; --max-rms says what may pass",
                                             motion.rms(), still));
    if (request.max_rms && !(motion.rms() <= *request.max_rms)) complaints.push_back(fmt::format("RMS error {} exceeds {}", motion.rms(), *request.max_rms));
    if (request.max_peak && !(motion.peak() <= *request.max_peak)) complaints.push_back(fmt::format("peak error {} exceeds {}", motion.peak(), *request.max_peak));
    if (kind != MotionKind::vertices) {
        MIEN_TRY(mesh, compare_mesh(stream, truth, request.rungs.motion));
        if (mesh) report["mesh"] = {{"mean_mm", mesh->mean()}, {"rms_mm", mesh->rms()}, {"peak_mm", mesh->peak()}};
    }
    if (!request.no_texture) {
        MIEN_TRY(texture, compare_texture(truth, received, progress));
        if (texture) report["texture"] = *texture;
        else if (stream.track(protocol::TrackKind::texture)) not_compared.push_back(truth.texture ? "texture: the stream holds nothing whole of it" : "texture: the clip has none");
    }
    if (truth.sound && stream.track(protocol::TrackKind::sound)) {
        const double missing = missing_seconds(truth, received);
        report["sound"] = {{"seconds", received.sound ? received.sound->seconds() : 0}, {"missing_s", missing}};
        if (missing > 0) complaints.push_back(fmt::format("the stream lacks {:.3f} s of the sound", missing));
    }
    if (!truth.sound && received.sound) not_compared.push_back("sound: the clip has none");
    report["not_compared"] = not_compared;
    report["ok"] = complaints.empty();
    end_progress();

    if (request.json) {
        fmt::print("{}\n", report.dump(2));
    } else {
        const char* unit = weights ? "" : " mm";
        fmt::print("motion   RMS {:.5f}{}, peak {:.4f}{}, mean {:.5f}{}, KG {:.4f} %\n", motion.rms(), unit, motion.peak(), unit, motion.mean(), unit, motion.kg_percent());
        if (report.contains("mesh"))
            fmt::print("mesh     mean {:.4f} mm, RMS {:.4f} mm, peak {:.3f} mm from the clip's vertices\n", report["mesh"]["mean_mm"].get<double>(),
                       report["mesh"]["rms_mm"].get<double>(), report["mesh"]["peak_mm"].get<double>());
        if (report.contains("texture"))
            fmt::print("texture  PSNR-Y {:.2f} dB, SSIM {:.4f} over {} frames\n", report["texture"]["psnr_y_db"].get<double>(),
                       report["texture"]["ssim"].get<double>(), report["texture"]["frames"].get<std::int64_t>());
        if (report.contains("sound")) {
            const double missing = report["sound"]["missing_s"].get<double>();
            fmt::print("sound    {:.3f} s{}\n", report["sound"]["seconds"].get<double>(), missing > 0 ? fmt::format(", {:.3f} s missing", missing) : "");
        }
    }
    for (const std::string& text : not_compared) warn("not compared: " + text);
    for (const std::string& text : complaints) fail(text);
    return complaints.empty() ? kDone : kFailed;
}

Result<int> verify(const Request& request) {
    const Progress progress = progress_bar(request.json);
    MIEN_TRY(stream, StoredStream::open(request.file));
    const auto compared = compare(request, stream, progress);
    // What does not fit follows from the cut.
    if (!compared && !stream.reader().complete()) return Error{compared.error().code, stream.reader().complaint() + ": " + compared.error().message};
    return compared;
}

}  // namespace

void add_verify(CLI::App& mien, int& code) {
    auto request = std::make_shared<Request>();
    CLI::App* command = mien.add_subcommand("verify", "Measure a stream file against the clip it was made from");
    command->add_option("file", request->file, "Stream file")->required();
    command->add_option("clip", request->clip, "The original clip")->required();
    command->add_flag("--json", request->json, "As JSON");
    command->add_option("--texture-rung", request->rungs.texture, "Rung of texture to use, 0 the coarsest (default: the finest)")->check(CLI::Range(0, 63));
    command->add_flag("--no-texture", request->no_texture, "Motion only");
    command->add_option("--rung", request->rungs.motion, "Highest rung of motion to use, 0 the coarsest (default: all)")->check(CLI::Range(0, 63));
    command->add_option("--max-rms", request->max_rms, "Fail above this RMS motion error")->check(not_negative());
    command->add_option("--max-peak", request->max_peak, "Fail above this peak motion error")->check(not_negative());
    command->callback([request, &code] { code = guarded([&] { return verify(*request); }, request->json); });
}

}  // namespace mien::tools
