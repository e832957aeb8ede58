#include "bench/texture_suite.hpp"

#include <algorithm>
#include <cmath>
#include <optional>
#include <set>

#include "bench/picture_score.hpp"
#include "bench/texture_codec.hpp"
#include "bench/view_run.hpp"
#include "core/environment_error.hpp"
#include "encoder/texture_encoder.hpp"
#include "encoder/texture_fill.hpp"

namespace mien::bench {
namespace {

constexpr double kViewRms = 0.1;  // mm, of both motion codecs in drawn views

/// A motion codec's part of the drawn views.
struct ViewGeometry {
    std::string codec;
    double kbps = 0;
    std::vector<Points> positions;  ///< of the sampled frames
};

class TextureSuite {
public:
    TextureSuite(const Clip& clip, const std::string& key, const SuiteOptions& options, Report& report,
                 const std::function<void()>& save, const Progress& progress)
        : clip_(clip),
          key_(key),
          options_(options),
          report_(report),
          save_(save),
          progress_(progress),
          used_(encoder::used_texels(clip, clip.texture->width(), clip.texture->height())) {}

    Result<void> run() {
        for (const std::string& codec : encoder::texture_codecs()) {
            if (!chosen(options_.texture_codecs, codec)) continue;
            for (const double kbps : options_.texture_kbps)
                for (const char* series : {"mien", "plain"}) MIEN_CHECK(run_one(codec, kbps, series));
        }
        return {};
    }

private:
    Result<void> run_one(const std::string& codec, double kbps, const std::string& series) {
        const bool ours = series == "mien", views = wants_views();
        TextureRow row;
        row.clip = key_;
        row.codec = codec;
        row.library = ours ? own_library() : texture_library();
        row.series = series;
        row.asked_kbps = kbps;
        const auto same_texture = [&](const TextureRow& old) {
            return old.clip == key_ && old.codec == codec && old.series == series && old.library == row.library &&
                   old.asked_kbps == kbps;
        };
        const auto same_view = [&](const ViewRow& old) {
            return old.clip == key_ && old.texture == codec && old.series == series && old.asked_kbps == kbps &&
                   (!ours || old.library == row.library);
        };
        const auto done = [&](const auto& rows, const auto& same) {
            return std::any_of(rows.begin(), rows.end(), [&](const auto& old) { return old.failed.empty() && same(old); });
        };
        if (!options_.force && done(report_.texture, same_texture) && (!views || done(report_.views, same_view))) return {};

        auto coded = ours ? encode_ours(clip_, codec, kbps, progress_) : encode_plain(clip_, codec, kbps, progress_);
        std::vector<Image> sampled;
        if (views) MIEN_CHECK(prepare_views());
        const auto measured = coded.ok() ? measure(*coded, row, sampled) : Result<void>(coded.error());
        if (!measured.ok()) row.failed = measured.error().message;
        std::erase_if(report_.texture, same_texture);
        report_.texture.push_back(row);
        if (views && row.failed.empty()) {
            std::erase_if(report_.views, same_view);
            for (const ViewGeometry& geometry : geometries_) {
                // Ours goes with our motion alone; the plain encoder with ours, to tell texture apart, and with the best other.
                if (ours && &geometry != &geometries_.front()) continue;
                add_view(geometry, row, sampled);
            }
        }
        save_();
        return {};
    }

    Result<void> measure(const CodedTexture& coded, TextureRow& row, std::vector<Image>& sampled) {
        PictureScore score;
        std::set<std::int64_t> starts;
        for (const protocol::Group& group : coded.groups) starts.insert(group.first_time);
        double before = 0, pulses = 0;
        const std::int64_t frames = clip_.texture->frames();
        MIEN_CHECK(decode_texture(coded, [&](std::int64_t frame, const Image& picture) -> Result<void> {
            if (progress_) progress_("comparing texture", frame, frames);
            MIEN_TRY(truth, clip_.texture->read(frame));
            score.add(truth, picture, used_);
            const double now = score.last_psnr_y(), jump = frame > 0 && starts.count(frame) ? now - before : 0;
            if (std::isfinite(jump)) pulses += jump;
            before = now;
            if (views_ && sampled.size() < views_->frames().size() && views_->frames()[sampled.size()] == frame)
                sampled.push_back(picture);
            return {};
        }));
        if (score.pictures() != frames) return Error{ErrorCode::mismatch, "the decoder gives another number of pictures back"};
        row.kbps = double(coded.bytes()) * 8 / 1000 * clip_.frame_rate.value() / double(frames);
        row.psnr_y = score.psnr_y();
        row.ssim = score.ssim();
        row.worst_psnr_y = score.worst_psnr_y();
        if (starts.size() > 1) row.pulse = pulses / double(starts.size() - 1);
        return {};
    }

    bool wants_views() const {
        return options_.views && !no_views_ && clip_.vertices && clip_.neutral && clip_.neutral->has_texcoords();
    }

    /// The renderer and both motions, once.
    Result<void> prepare_views() {
        if (views_) return {};
        if (progress_) progress_("drawing the truth", 0, 0);
        try {
            MIEN_TRY(views, ViewComparison::create(clip_, options_.view_pictures));
            views_ = std::move(views);
        } catch (const EnvironmentError& error) {
            no_views_ = true;
            report_.absent.emplace_back("drawn views", error.what());
            return {};
        }
        const GeometryInput input(clip_, protocol::MotionKind::vertices);
        const GeometryCodecs list = geometry_codecs();
        std::optional<ViewGeometry> best;
        for (const auto& codec : list.codecs) {
            const bool subject = codec->name == "mien-file";
            if (!subject &&
                (codec->ours || codec->name == "guenter98" || codec->lossless || !chosen({"zstd", "meshopt-delta"}, codec->name)))
                continue;
            MIEN_TRY(stream, codec->encode(input, kViewRms));
            ViewGeometry geometry{
                codec->name, double(stream->bytes()) * 8 / 1000 * clip_.frame_rate.value() / double(input.frames), {}};
            if (!subject && best && best->kbps <= geometry.kbps) continue;
            MIEN_TRY(positions, views_->sample(*stream));
            geometry.positions = std::move(positions);
            if (subject) geometries_.push_back(std::move(geometry));
            else best = std::move(geometry);
        }
        if (best) geometries_.push_back(std::move(*best));
        return {};
    }

    void add_view(const ViewGeometry& geometry, const TextureRow& texture, const std::vector<Image>& sampled) {
        const PictureScore score = views_->compare(geometry.positions, sampled);
        ViewRow row;
        row.clip = key_;
        row.geometry = geometry.codec;
        row.texture = texture.codec;
        row.library = own_library();
        row.series = texture.series;
        row.asked_kbps = texture.asked_kbps;
        row.geometry_kbps = geometry.kbps;
        row.kbps = geometry.kbps + texture.kbps;
        row.psnr_y = score.psnr_y();
        row.ssim = score.ssim();
        row.worst_psnr_y = score.worst_psnr_y();
        row.pictures = score.pictures();
        report_.views.push_back(std::move(row));
    }

    const Clip& clip_;
    const std::string& key_;
    const SuiteOptions& options_;
    Report& report_;
    const std::function<void()>& save_;
    const Progress& progress_;
    std::vector<std::uint8_t> used_;
    std::unique_ptr<ViewComparison> views_;
    bool no_views_ = false;
    std::vector<ViewGeometry> geometries_;
};

}  // namespace

Result<void> run_textures(const Clip& clip, const std::string& key, const SuiteOptions& options, Report& report,
                          const std::function<void()>& save, const Progress& progress) {
    return TextureSuite(clip, key, options, report, save, progress).run();
}

}  // namespace mien::bench
