#include "analysis/evaluation.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include "analysis/frame_predictors.hpp"
#include "core/parallel.hpp"

namespace mien::analysis {
namespace {

constexpr int kPerOctave = 40, kOctaves = 48, kLowest = -34;  // 2^-34 .. 2^14 mm

/// The coefficients [channel][term][texel] that explain a layer one way; none: the base alone.
std::vector<std::pair<std::string, const FittedMap*>> ways(const std::vector<FittedMap>& fitted) {
    std::vector<std::pair<std::string, const FittedMap*>> all = {{"base", nullptr}};
    for (const FittedMap& map : fitted) {
        const char* name = "linear";
        switch (map.predictors) {
            case Predictors::polynomial: name = map.terms == 3 ? "linear" : map.terms == 6 ? "biquadratic" : "bicubic"; break;
            case Predictors::deformation: name = "deformation"; break;
            case Predictors::global: name = "global"; break;
            case Predictors::neutral: name = "neutral"; break;
        }
        all.emplace_back(name, &map);
    }
    return all;
}

class LayerJudge {
public:
    LayerJudge(const std::vector<FittedMap>& fitted, const model::DomainMap& domain, int channels, bool distance)
        : ways_(ways(fitted)), domain_(domain), channels_(channels), distance_(distance), sums_(ways_.size(), std::vector<double>(domain.size())), counts_(domain.size()),
          summaries_(ways_.size()), triangle_(domain.size()) {
        for (const auto& run : domain.runs) std::fill(triangle_.begin() + run.begin, triangle_.begin() + run.end, run.triangle);
    }

    /// target: [channel][texel], NaN: not seen.
    void add(const FramePredictors& frame, const float* target) {
        constexpr std::int64_t kBlocks = 16;
        const std::size_t n = domain_.size();
        std::vector<std::vector<ErrorSummary>> parts(kBlocks, std::vector<ErrorSummary>(ways_.size()));
        parallel_for(kBlocks, [&](std::int64_t block) {
            double x[model::kMaxTerms];
            for (std::size_t i = n * std::size_t(block) / kBlocks; i < n * std::size_t(block + 1) / kBlocks; ++i) {
                bool seen = true;
                for (int c = 0; c < channels_; ++c) seen &= std::isfinite(target[std::size_t(c) * n + i]);
                if (!seen) continue;
                ++counts_[i];
                for (std::size_t w = 0; w < ways_.size(); ++w) {
                    const FittedMap* map = ways_[w].second;
                    if (map && (w == 1 || map->predictors != ways_[w - 1].second->predictors)) frame.at(map->predictors, domain_, triangle_[i], std::uint32_t(i), x);
                    double squares = 0, sum = 0;
                    for (int c = 0; c < channels_; ++c) {
                        double value = 0;
                        for (int k = 0; map && k < map->terms; ++k) value += double(map->planes[std::size_t(c * map->terms + k) * n + i]) * x[k];
                        const double error = double(target[std::size_t(c) * n + i]) - value;
                        squares += error * error;
                        sum += std::abs(error);
                    }
                    const double error = distance_ ? std::sqrt(squares) : sum / channels_;
                    sums_[w][i] += error;
                    parts[std::size_t(block)][w].add(error);
                }
            }
        });
        for (const auto& part : parts)
            for (std::size_t w = 0; w < ways_.size(); ++w) summaries_[w].merge(part[w]);
    }

    std::vector<LayerErrors> result() const {
        std::vector<LayerErrors> all;
        for (std::size_t w = 0; w < ways_.size(); ++w) {
            std::vector<float> mean(domain_.size(), std::numeric_limits<float>::quiet_NaN());
            for (std::size_t i = 0; i < mean.size(); ++i)
                if (counts_[i] > 0) mean[i] = float(sums_[w][i] / counts_[i]);
            all.push_back({ways_[w].first, summaries_[w], std::move(mean)});
        }
        return all;
    }

private:
    std::vector<std::pair<std::string, const FittedMap*>> ways_;
    const model::DomainMap& domain_;
    int channels_;
    bool distance_;
    std::vector<std::vector<double>> sums_;
    std::vector<int> counts_;
    std::vector<ErrorSummary> summaries_;
    std::vector<std::uint32_t> triangle_;
};

}  // namespace

void ErrorSummary::add(double error) {
    if (bins_.empty()) bins_.resize(kPerOctave * kOctaves);
    const double place = error > 0 ? (std::log2(error) - kLowest) * kPerOctave : 0;
    ++bins_[std::size_t(std::clamp(place, 0.0, double(bins_.size() - 1)))];
    ++count_;
    sum_ += error;
    most_ = std::max(most_, error);
}

void ErrorSummary::merge(const ErrorSummary& other) {
    if (other.count_ == 0) return;
    if (bins_.empty()) bins_.resize(other.bins_.size());
    for (std::size_t i = 0; i < bins_.size(); ++i) bins_[i] += other.bins_[i];
    count_ += other.count_;
    sum_ += other.sum_;
    most_ = std::max(most_, other.most_);
}

double ErrorSummary::percentile(double share) const {
    if (count_ == 0) return 0;
    std::int64_t below = 0;
    for (std::size_t i = 0; i < bins_.size(); ++i) {
        below += bins_[i];
        if (double(below) >= share * double(count_)) return std::min(most_, std::exp2(double(i + 1) / kPerOctave + kLowest));
    }
    return most_;
}

Result<Evaluation> evaluate_clip(const TrainedModel& trained, const Clip& clip, std::int64_t stride, const Progress& progress) {
    const model::DetailModel& model = trained.model;
    const bool albedo = clip.scans->has_albedo() && !trained.albedo.empty();
    LayerJudge medium_judge(trained.medium, model.medium_domain, 3, true), fine_judge(trained.fine, model.fine_domain, 1, true),
        albedo_judge(trained.albedo, model.fine_domain, 3, false);
    const auto where = domain_texels(model.medium_domain, make_texel_map(model.neutral, model.medium_domain.width, model.medium_domain.height, 1u << int(Surface::skin)));
    const FineTarget fine_target(model, trained.high_pass_sigma, trained.fine_over);
    const Points rest = markers_at_rest(clip, trained.driver->mesh().neutral);
    Evaluation evaluation;
    std::vector<std::int64_t> frames;
    for (std::int64_t f = 0; f < clip.markers->frames; f += stride) frames.push_back(f);
    struct Ready {
        std::unique_ptr<FramePredictors> drive;
        std::vector<float> medium, fine, albedo;
        std::optional<Error> error;
    };
    const std::size_t at_once = std::size_t(thread_count());
    for (std::size_t first = 0; first < frames.size(); first += at_once) {
        std::vector<Ready> batch(std::min(at_once, frames.size() - first));
        parallel_for(std::int64_t(batch.size()), [&](std::int64_t i) {
            Ready& ready = batch[std::size_t(i)];
            const std::int64_t frame = frames[first + std::size_t(i)];
            auto scan = clip.scans->read(frame, {true, true, albedo});
            if (!scan.ok()) {
                ready.error = scan.error();
                return;
            }
            ready.drive = std::make_unique<FramePredictors>(trained, head_space_markers(clip, frame, rest, trained.driver->mesh().neutral));
            const Points base = ready.drive->base();
            ready.medium.resize(3 * model.medium_domain.size());
            medium_target(scan->medium, model.neutral, model.medium_domain, where, base, ready.medium.data());
            std::vector<float> medium(ready.medium.size());
            model::evaluate(model.medium, model.medium_domain, ready.drive->parameters(), medium.data());
            const std::size_t n = model.fine_domain.size();
            ready.fine.resize(n);
            fine_target.compute(*scan, base, medium.data(), ready.fine.data());
            if (!albedo) return;
            ready.albedo.resize(3 * n);
            for (std::size_t k = 0; k < n; ++k)
                for (std::size_t c = 0; c < 3; ++c) ready.albedo[c * n + k] = scan->albedo.values[3 * std::size_t(model.fine_domain.place[k]) + c];
        });
        for (const Ready& ready : batch) {
            if (ready.error) return *ready.error;
            medium_judge.add(*ready.drive, ready.medium.data());
            fine_judge.add(*ready.drive, ready.fine.data());
            if (albedo) albedo_judge.add(*ready.drive, ready.albedo.data());
            ++evaluation.frames;
        }
        if (progress) progress("measuring", std::int64_t(first + batch.size()), std::int64_t(frames.size()));
    }
    evaluation.medium = medium_judge.result();
    evaluation.fine = fine_judge.result();
    if (albedo) evaluation.albedo = albedo_judge.result();
    return evaluation;
}

}  // namespace mien::analysis
