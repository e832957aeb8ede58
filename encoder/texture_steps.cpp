#include "encoder/texture_steps.hpp"

#include <algorithm>
#include <cmath>

namespace mien::encoder {
namespace {

constexpr double kNearRate = 0.1;     // relative; of the rate that a lane is asked for, what its quality is set by
constexpr int kRateTrials = 4;
constexpr std::int64_t kUsualRuns = kRateTrials + 3;   // for the progress bar
constexpr double kRateSlope = 0.04;   // ln(bits) per point of quality, until two trials tell
constexpr double kLeastShare = 1.0 / 8, kMostShare = 8;   // of the encoder's step

/// The search for one lane's step. At one quality throughout: what rate control does in a few seconds is mostly chance.
struct StepProbe {
    TextureLane lane;       ///< what is tried next
    TextureLane* wanted;
    TextureRun plain;       ///< of the quality, nothing shrunk
    double whole = 0;       ///< the encoder's step
    double best = 0;        ///< error times bits of the best step so far
    double share = 1, factor = 2;
    bool done = false;

    explicit StepProbe(TextureLane& of) : lane(of), wanted(&of) {
        lane.step = wanted->step = 0;
        lane.settings.kbps.reset();
    }
    /// From 1 by factors of two, as long as that is better.
    void judge(double cost) {
        const bool better = cost < best;
        if (better) {
            best = cost;
            wanted->step = lane.step;
        }
        if (share == 1) {
            factor = better ? 2 : 0.5;
        } else if (share == 2 && !better) {   // the way up leads nowhere
            share = 1;
            factor = 0.5;
        } else {
            done = !better;
        }
        share *= factor;
        done = done || share < kLeastShare || share > kMostShare;
        lane.step = share * whole;
    }
};

/// A quality at which bits come nearest to a rate, from trial to trial.
struct QualitySearch {
    double rate;
    double slope = kRateSlope;
    std::optional<double> quality = {}, log_bits = {};   ///< of the trial before

    bool near(double kbps) const { return std::abs(std::log(kbps / rate)) <= kNearRate; }
    double next(double tried, double kbps) {
        const double now = std::log(kbps);
        if (log_bits && tried != *quality && (now - *log_bits) / (tried - *quality) > 0) slope = (now - *log_bits) / (tried - *quality);
        quality = tried;
        log_bits = now;
        return std::clamp(tried + (std::log(rate) - now) / slope, 0.0, media::VideoEncoderSettings::kFinestQuality);
    }
};

}  // namespace

Result<void> choose_steps(TextureSource& source, TextureFill& fill, const std::vector<TextureLane*>& lanes, std::int64_t frames,
                          const Progress& progress) {
    std::vector<StepProbe> probes;
    for (TextureLane* lane : lanes)
        if (lane->shrink) probes.emplace_back(*lane);
    const auto kbps = [&](const StepProbe& probe, const TextureRun& run) { return run.kbps(probe.lane.settings.frame_rate, frames); };
    std::int64_t runs_done = 0;
    const auto report = [&](std::string_view, std::int64_t done, std::int64_t of) {
        if (progress) progress("texture, trials", std::min(runs_done, kUsualRuns - 1) * of + done, kUsualRuns * of);
    };
    const auto run_all = [&](const std::vector<StepProbe*>& open) {
        std::vector<TextureLane*> trials;
        for (StepProbe* probe : open) trials.push_back(&probe->lane);
        auto runs = encode_lanes(source, fill, trials, frames, report);
        ++runs_done;
        return runs;
    };

    std::vector<QualitySearch> searches;
    for (const StepProbe& probe : probes) searches.push_back({probe.wanted->settings.kbps.value_or(0)});
    std::vector<StepProbe*> open;
    for (StepProbe& probe : probes) open.push_back(&probe);
    for (int trial = 0; !open.empty() && trial < kRateTrials; ++trial) {
        MIEN_TRY(runs, run_all(open));
        std::vector<StepProbe*> missed;
        for (std::size_t i = 0; i < open.size(); ++i) {
            StepProbe& probe = *open[i];
            QualitySearch& search = searches[std::size_t(open[i] - probes.data())];
            probe.plain = std::move(runs[i]);
            if (!probe.wanted->settings.kbps || search.near(kbps(probe, probe.plain)) || trial + 1 == kRateTrials) continue;
            double& quality = probe.lane.settings.quality;
            const double next = search.next(quality, kbps(probe, probe.plain));
            if (next == quality) continue;   // the end of the scale
            quality = next;
            missed.push_back(&probe);
        }
        open = std::move(missed);
    }
    for (StepProbe& probe : probes) {
        const auto& asked = probe.wanted->settings.kbps;
        if (asked && probe.lane.settings.quality == media::VideoEncoderSettings::kFinestQuality && kbps(probe, probe.plain) < *asked)
            continue;   // bits are left over as it is
        MIEN_TRY(error, weighted_error(source, fill, probe.lane, probe.plain));
        probe.whole = probe.lane.step = std::sqrt(12 * error);
        probe.best = error * kbps(probe, probe.plain);
        open.push_back(&probe);
    }
    for (;;) {
        std::erase_if(open, [](const StepProbe* probe) { return probe->done; });
        if (open.empty()) return {};
        MIEN_TRY(runs, run_all(open));
        for (std::size_t i = 0; i < open.size(); ++i) {
            MIEN_TRY(error, weighted_error(source, fill, open[i]->lane, runs[i]));
            open[i]->judge(error * kbps(*open[i], runs[i]));
        }
    }
}

}  // namespace mien::encoder
