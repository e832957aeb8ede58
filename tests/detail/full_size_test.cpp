#include <gtest/gtest.h>

#include <fmt/format.h>

#include <cstdlib>
#include <map>

#include "analysis/evaluation.hpp"
#include "core/parallel.hpp"
#include "decoder/detail_decoder.hpp"
#include "encoder/detail_encoder.hpp"
#include "encoder/mesh_blobs.hpp"
#include "protocol/messages.hpp"
#include "samples/markers.hpp"
#include "samples/performance_training.hpp"
#include "samples/procedural_actor.hpp"
#include "samples/speech.hpp"
#include "samples/stage_scans.hpp"

namespace mien {
namespace {

constexpr int kMedium = 512, kFine = 1024;

Clip stage_clip(std::shared_ptr<const samples::Actor> actor, const std::vector<samples::Instant>& instants, double noise) {
    Clip clip;
    clip.neutral = actor->neutral();
    clip.marker_sites = samples::place_markers(*actor);
    clip.markers.emplace(std::int64_t(instants.size()), std::int64_t(clip.marker_sites.size()));
    for (std::size_t f = 0; f < instants.size(); ++f) {
        const Points points = actor->deform(instants[f]);
        for (std::size_t m = 0; m < clip.marker_sites.size(); ++m)
            clip.markers->frame(std::int64_t(f)).row(Eigen::Index(m)) = clip.marker_sites[m].position(points).transpose();
        clip.head_pose.push_back({});
    }
    clip.scans = std::make_shared<samples::StageScans>(actor, instants, samples::ScannerOptions{.medium_size = kMedium, .fine_size = kFine, .noise = noise, .seed = 1});
    return clip;
}

/// What one unseen frame's scan asks of the layers: medium, fine, albedo.
struct Target {
    Points markers;
    std::array<std::vector<float>, 3> values;
};

Target target_of(const Clip& clip, std::int64_t frame, const analysis::TrainedModel& trained, const std::vector<TexelMap::Texel>& where, const analysis::FineTarget& fine) {
    const model::DetailModel& model = trained.model;
    const auto scan = clip.scans->read(frame);
    Target target{clip.markers->frame(frame), {}};
    const model::DrivenFrame driven = trained.driver->drive(target.markers, model.axes);
    target.values[0].resize(3 * model.medium_domain.size());
    analysis::medium_target(scan->medium, model.neutral, model.medium_domain, where, driven.base, target.values[0].data());
    std::vector<float> medium(target.values[0].size());
    model::evaluate(model.medium, model.medium_domain, driven.parameters, medium.data());
    const std::size_t n = model.fine_domain.size();
    target.values[1].resize(n);
    fine.compute(*scan, driven.base, medium.data(), target.values[1].data());
    target.values[2].resize(3 * n);
    for (std::size_t k = 0; k < n; ++k)
        for (std::size_t c = 0; c < 3; ++c) target.values[2][c * n + k] = scan->albedo.values[3 * std::size_t(model.fine_domain.place[k]) + c];
    return target;
}

std::array<analysis::ErrorSummary, 3> errors_of(const model::DetailModel& model, const model::DetailModel& trained, const std::vector<Target>& targets) {
    std::array<analysis::ErrorSummary, 3> errors;
    const model::MarkerDriver driver(model.neutral, model.sites, model.fixed, model.marker_triangles);
    const auto numbers = [](const model::DomainMap& domain) {
        std::vector<std::uint32_t> number(std::size_t(domain.width) * std::size_t(domain.height), TexelMap::kNone);
        for (std::uint32_t i = 0; i < domain.size(); ++i) number[domain.place[i]] = i;
        return number;
    };
    const std::vector<std::uint32_t> medium = numbers(trained.medium_domain), fine = numbers(trained.fine_domain);
    for (const Target& target : targets) {
        const auto parameters = driver.drive(target.markers, model.axes).parameters;
        for (std::size_t layer = 0; layer < 3; ++layer) {
            const model::PolynomialMap& map = layer == 0 ? model.medium : layer == 1 ? model.fine : model.albedo;
            const model::DomainMap& domain = layer == 0 ? model.medium_domain : model.fine_domain;
            if (map.texels == 0) continue;  // it has not come yet
            std::vector<float> values(std::size_t(map.channels) * map.texels);
            model::evaluate(map, domain, parameters, values.data());
            const std::size_t all = target.values[layer].size() / std::size_t(map.channels);
            for (std::size_t i = 0; i < map.texels; ++i) {
                const std::uint32_t at = (layer == 0 ? medium : fine)[domain.place[i]];
                double squares = 0, sum = 0;
                for (std::size_t c = 0; c < std::size_t(map.channels); ++c) {
                    const double e = double(target.values[layer][c * all + at]) - double(values[c * map.texels + i]);
                    squares += e * e;
                    sum += std::abs(e);
                }
                if (std::isfinite(squares)) errors[layer].add(layer == 2 ? sum / 3 : std::sqrt(squares));
            }
        }
    }
    return errors;
}

/// The blobs in fetching order, as far as `most` bytes reach.
Result<model::DetailModel> decode_first(const encoder::EncodedDetail& coded, std::size_t most) {
    std::map<Hash, Bytes> blobs;
    for (const auto& blob : coded.blobs) {
        if (blob.bytes.size() > most) break;
        most -= blob.bytes.size();
        blobs[blob.hash] = blob.bytes;
    }
    return decoder::decode_detail(coded.manifest, [&](const Hash& hash) {
        const auto found = blobs.find(hash);
        return found == blobs.end() ? nullptr : &found->second;
    });
}

std::string row(const std::string& name, const std::array<analysis::ErrorSummary, 3>& errors, const std::array<analysis::ErrorSummary, 3>& beside) {
    std::string text = name;
    for (std::size_t l = 0; l < 3; ++l)
        text += fmt::format(" | {:.3g} ({:+.1f} %), {:.3g} ({:+.1f} %)", errors[l].mean(), 100 * (errors[l].mean() / beside[l].mean() - 1), errors[l].percentile(0.99),
                            100 * (errors[l].percentile(0.99) / beside[l].percentile(0.99) - 1));
    return text;
}

// A minute or two of training at full size and 2 GB: MIEN_FULL_SIZE=1 runs it, and docs/detail.md holds what it prints.
// MIEN_FULL_SIZE=0.01 is a scanner of 10 um noise; 1 stands for 5 um.
TEST(FullSize, MeetsItsBarsOnUnseenFramesOfAScannerWithNoise) {
    const char* asked = std::getenv("MIEN_FULL_SIZE");
    if (!asked) GTEST_SKIP() << "skipped: MIEN_FULL_SIZE is not set";
    const double noise = std::atof(asked) == 1 ? 0.005 : std::atof(asked);
    const std::shared_ptr<const samples::Actor> actor = samples::make_procedural_actor(1);
    const samples::TrainingSession session = samples::perform_training(15, 30, 1);
    Clip training = stage_clip(actor, session.performance.instants, noise);
    training.takes = session.takes;
    analysis::TrainingOptions options;
    options.fixed = actor->rigid_vertices();
    options.neutral = *encoder::mesh_as_stored(*training.neutral, encoder::DetailOptions().mesh_step);   // as mien train does
    const auto trained = analysis::train(training, options);
    ASSERT_TRUE(trained.ok()) << trained.error().message;
    const auto spoken = samples::speak(samples::kDefaultText);
    if (!spoken.ok()) GTEST_SKIP() << "skipped: " << spoken.error().message;

    std::vector<Target> targets;
    const auto where = analysis::domain_texels(trained->model.medium_domain, make_texel_map(trained->model.neutral, kMedium, kMedium, 1u << int(Surface::skin)));
    const analysis::FineTarget fine(trained->model, trained->high_pass_sigma, trained->fine_over);
    const auto add = [&](const samples::Performance& performance, std::size_t stride) {
        std::vector<samples::Instant> instants;
        for (std::size_t f = 0; f < performance.instants.size(); f += stride) instants.push_back(performance.instants[f]);
        const Clip clip = stage_clip(actor, instants, noise);
        for (std::int64_t f = 0; f < clip.markers->frames; ++f) targets.push_back(target_of(clip, f, *trained, where, fine));
    };
    add(samples::perform_speech(*spoken, {30, 1}, 0, 3), 25);
    add(samples::perform_unseen(samples::kAsymmetricSmile, 60), 20);
    add(samples::perform_unseen(samples::kRaisedBrow, 60), 20);

    const auto before = errors_of(trained->model, trained->model, targets);
    fmt::print("{} frames trained on, {} unseen; texels {} and {}\n", trained->frames, targets.size(), trained->model.medium_domain.size(), trained->model.fine_domain.size());
    fmt::print("mean (added), 99 % (added): medium mm | fine mm | albedo\n{}\n", row("not coded", before, before));
    const auto measure = [&](const char* name, const model::TermMoments& moments) {
        const auto coded = encoder::encode_detail(trained->model, moments, "actor", encoder::detail_options(trained->fine_stored));
        EXPECT_TRUE(coded.ok());
        const auto back = decode_first(*coded, ~std::size_t(0));
        EXPECT_TRUE(back.ok());
        const auto after = errors_of(*back, trained->model, targets);
        fmt::print("{}\n", row(name, after, before));
        std::array<std::size_t, 3> bytes{};
        for (std::size_t l = 0; l < 3; ++l) {
            fmt::print("  {}:", coded->layers[l].name);
            for (const std::size_t stage : coded->layers[l].stage_bytes) fmt::print(" {}", stage), bytes[l] += stage;
            fmt::print(" = {} bytes, added RMS over the training frames {:.5f}\n", bytes[l], coded->layers[l].error);
        }
        if (&moments != &trained->moments) return;
        for (std::size_t l = 0; l < 3; ++l) {
            EXPECT_LE(after[l].mean(), 1.10 * before[l].mean());
            EXPECT_LE(after[l].percentile(0.99), 1.05 * before[l].percentile(0.99));
        }
        EXPECT_LE(bytes[0] + bytes[1], 200'000u);
        EXPECT_LE(bytes[0] + bytes[1] + bytes[2], 800'000u);
        std::size_t beside = 0;
        for (const auto& blob : coded->blobs)
            if (blob.kind != protocol::BlobKind::detail_map && blob.kind != protocol::BlobKind::refinement) beside += blob.bytes.size();
        fmt::print("  mesh, shell, markers, masks, manifest: {} bytes\n", beside);
        for (const std::size_t most : {std::size_t(200'000), std::size_t(300'000), std::size_t(450'000)}) {
            const auto part = decode_first(*coded, most);
            EXPECT_TRUE(part.ok());
            fmt::print("{}\n", row(fmt::format("first {} kB", most / 1000), errors_of(*part, trained->model, targets), before));
        }
    };
    measure("coded", trained->moments);
    model::TermMoments global = trained->moments;
    global.rowwise() = trained->moments.colwise().mean().eval();
    measure("one basis for all markers", global);
}

}  // namespace
}  // namespace mien
