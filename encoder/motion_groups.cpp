#include "encoder/motion_groups.hpp"

#include <Eigen/Cholesky>
#include <algorithm>
#include <array>
#include <cmath>

#include "coding/motion_frames.hpp"
#include "core/parallel.hpp"
#include "encoder/frame_decision.hpp"

namespace mien::encoder {
namespace {

using coding::IntegerModel;
using coding::MotionBasis;
using coding::MotionFrames;
using coding::MotionScheme;

struct GroupTask {
    const MotionBasis& basis;
    const coding::MotionShape& shape;
    const GroupPlan& plan;
    const Eigen::MatrixXd& targets;
    const std::vector<std::uint8_t>& presence;
    const GroupOptions& options;
    CodedGroups& out;

    struct Training {
        std::vector<std::uint32_t> seen;
        std::vector<std::int32_t> weights;
    };

    bool settled(int channel) const { return channel < options.settled_channels; }

    // One channel of a transform group; returns squared error + lambda * bits in squared steps.
    template <class Coder>
    double code_channel(Coder& coder, MotionFrames& frames, std::int64_t first, std::uint32_t n, int channel, int split,
                        double bits_before) const {
        std::array<double, coding::CosineTransform::kMaxLength> samples, wanted;
        MotionFrames::Block block;
        double error = 0;
        frames.code_channel(
            coder, channel, n, split,
            [&](const MotionFrames::Block& next) {
                block = next;
                for (std::uint32_t t = 0; t < block.length; ++t)
                    samples[t] = targets(channel, first + block.first + t) - double(block.base) / MotionBasis::kFraction;
                coding::CosineTransform::of(int(block.length)).forward(samples.data(), wanted.data());
            },
            [&](int f, const IntegerModel::Contexts& contexts, const IntegerModel& model) {
                const double y = wanted[std::size_t(f)];
                const std::int32_t q =
                    settled(channel)
                        ? options.settled->numbers[std::size_t(channel)][std::size_t(first + block.first + f)]
                        : decide(y, options.lambda, [&](std::int32_t v) { return model.cost(v, contexts); });
                error += (y - q) * (y - q);
                return q;
            });
        if constexpr (std::is_same_v<Coder, coding::CostCoder>)
            return error + options.lambda * (coder.bits() - bits_before);
        else
            return error;
    }

    void transform_group(std::int64_t group, MotionFrames& frames, std::vector<double>& bits) const {
        const std::int64_t first = plan.first(group);
        const std::uint32_t n = std::uint32_t(plan.length(group));
        Metered coder;
        write_presence(coder, frames, first, n, bits);
        frames.begin_object(n);
        set_below(frames, group, first);
        coding::MotionCorrections corrections(basis, shape);
        for (int c = 0; c < frames.layout().total(); ++c) {
            int split = 0;
            if (frames.layout().refines(c)) {
                split = options.below->splits[std::size_t(options.below_sides + c)][std::size_t(group)];
            } else if (options.settled && (settled(c) || !options.choose_splits)) {
                split = options.settled->splits[std::size_t(c)][std::size_t(group)];
            } else {
                const MotionFrames::Learnt before = frames.learnt();
                double best = 1e300;
                for (int tried = 0; tried < MotionFrames::kSplits; ++tried) {
                    if (tried > 0 && (n >> tried) < 4) break;
                    coding::CostCoder cost;
                    const double total = code_channel(cost, frames, first, n, c, tried, 0);
                    frames.restore(before);
                    if (total < best) best = total, split = tried;
                }
            }
            code_channel(coder, frames, first, n, c, split, 0);
            bits[std::size_t(c)] += coder.take_bits();
            out.numbers.splits[std::size_t(c)][std::size_t(group)] = std::uint8_t(split);
            const auto numbers = frames.numbers(c, n);
            std::copy(numbers.begin(), numbers.end(), out.numbers.numbers[std::size_t(c)].begin() + first);
            for (std::uint32_t f = 0; f < n; ++f)
                out.samples(c, first + f) = double(frames.sample(c, f, n)) / MotionBasis::kFraction;
        }
        write_corrections(coder, corrections, first, n, bits);
        store_object(group, first, n, coder);
    }

    // The numbers of a causal frame.
    std::vector<std::int32_t> numbers_of(MotionFrames& frames, const Metered& begun, std::int64_t at) const {
        const auto target = [&](int c) { return targets(c, at); };
        const auto given = [&](int c) {
            return settled(c) ? std::optional(options.settled->numbers[std::size_t(c)][std::size_t(at)]) : std::nullopt;
        };
        if (options.whole_bytes) return choose_packet(frames, begun, options.lambda, target, given).numbers;
        FrameCosts costs(frames);
        return choose_path(costs, frames.layout().total(), options.lambda, target, given).numbers;
    }

    void frame_group(std::int64_t group, MotionFrames& frames, std::vector<double>& bits) const {
        const std::int64_t first = plan.first(group);
        const std::uint32_t n = std::uint32_t(plan.length(group));
        const bool single = basis.scheme == MotionScheme::causal;
        Metered coder;
        coding::MotionCorrections corrections(basis, shape);
        if (!single) write_presence(coder, frames, first, n, bits);
        if (!single) frames.begin_object(n);
        for (std::uint32_t f = 0; f < n; ++f) {
            const std::int64_t at = first + f;
            std::vector<std::int32_t> chosen;
            if (single) {
                coder = Metered();
                write_presence(coder, frames, at, 1, bits);
                frames.begin_object(1);
                set_below(frames, group, at);
                chosen = numbers_of(frames, coder, at);
            }
            int last = -1;
            const auto account = [&](int c) {
                if (last >= 0) bits[std::size_t(last)] += coder.take_bits();
                last = c;
            };
            const auto keep = [&](int c, std::int32_t v) { return out.numbers.numbers[std::size_t(c)][std::size_t(at)] = v; };
            if (single)
                frames.code_frame(coder, [&](int c) {
                    account(c);
                    return keep(c, chosen[std::size_t(c)]);
                });
            else
                frames.code_guenter_frame(coder, [&](int c, std::int64_t prediction) {
                    account(c);
                    if (settled(c)) return keep(c, options.settled->numbers[std::size_t(c)][std::size_t(at)]);
                    const double wanted = targets(c, at) - double(prediction) / MotionBasis::kFraction;
                    return keep(c, decide(wanted, 0, [](std::int32_t) { return 0.0; }));
                });
            account(-1);
            frames.store_frame(single ? 0 : f, single ? 1 : n);
            for (int c = 0; c < frames.layout().total(); ++c)
                out.samples(c, at) = double(frames.sample(c, single ? 0 : f, single ? 1 : n)) / MotionBasis::kFraction;
            if (single) write_corrections(coder, corrections, at, 1, bits);
            if (single) store_object(group, at, 1, coder);
        }
        if (!single) write_corrections(coder, corrections, first, n, bits);
        if (!single) store_object(group, first, n, coder);
    }

    void write_presence(Metered& coder, MotionFrames& frames, std::int64_t first, std::uint32_t n,
                        std::vector<double>& bits) const {
        if (!shape.presence) return;
        std::vector<std::uint8_t> here(presence.begin() + first * shape.points, presence.begin() + (first + n) * shape.points);
        frames.code_presence(coder, n, here);
        bits[bits.size() - 2] += coder.take_bits();
    }

    void set_below(MotionFrames& frames, std::int64_t group, std::int64_t first) const {
        if (!options.below) return;
        MotionFrames::Below below;
        for (std::size_t c = std::size_t(options.below_sides); c < options.below->numbers.size(); ++c) {
            below.numbers.push_back(options.below->numbers[c].data() + first);
            below.splits.push_back(options.below->splits[c][std::size_t(group)]);
        }
        frames.set_below(std::move(below));
    }

    void write_corrections(Metered& coder, coding::MotionCorrections& corrections, std::int64_t first, std::uint32_t n,
                           std::vector<double>& bits) const {
        if (basis.corrected.empty()) return;
        for (std::uint32_t f = 0; f < n; ++f) {
            auto changes = (*options.corrections)[std::size_t(first + f)];
            corrections.code(coder, changes);
        }
        bits.back() += coder.take_bits();
    }

    void store_object(std::int64_t group, std::int64_t first, std::uint32_t n, Metered& coder) const {
        const bool single = basis.scheme == MotionScheme::causal;
        out.state_hashes[std::size_t(single ? first : group)] = coder.digest();
        out.groups[std::size_t(group)].objects.push_back({.frames = n, .bytes = coder.finish()});
    }

    void run(std::int64_t group, std::vector<double>& bits, Training* training) const {
        MotionFrames frames(basis, shape);
        if (training) frames.model().start_counting();
        out.groups[std::size_t(group)] = {.slot = 0, .group = std::uint32_t(group), .first_time = plan.first(group), .objects = {}};
        if (basis.scheme == MotionScheme::transform) transform_group(group, frames, bits);
        else frame_group(group, frames, bits);
        if (training) {
            training->seen.assign(frames.model().seen().begin(), frames.model().seen().end());
            coding::IntegerModel& model = frames.model();
            for (std::size_t i = 0; i < model.weight_count(); ++i) training->weights.push_back(model.weight(i));
        }
    }
};

}  // namespace

CodedGroups code_groups(const MotionBasis& basis, const coding::MotionShape& shape, const GroupPlan& plan,
                        const Eigen::MatrixXd& targets, const std::vector<std::uint8_t>& presence,
                        const GroupOptions& options) {
    const std::size_t groups = std::size_t(plan.count());
    const std::size_t channels = std::size_t(basis.channels(shape));
    CodedGroups out;
    out.groups.resize(groups);
    out.state_hashes.resize(basis.scheme == MotionScheme::causal ? std::size_t(plan.frames) : groups);
    out.samples = Eigen::MatrixXd::Zero(Eigen::Index(channels), plan.frames);
    out.numbers.numbers.assign(channels, std::vector<std::int32_t>(std::size_t(plan.frames), 0));
    out.numbers.splits.assign(channels, std::vector<std::uint8_t>(groups, 0));

    // Groups in batches, so that training data of a long clip does not pile up.
    const GroupTask task{basis, shape, plan, targets, presence, options, out};
    out.bits = Eigen::VectorXd::Zero(Eigen::Index(channels));
    constexpr std::size_t kBatch = 32;
    for (std::size_t begin = 0; begin < groups; begin += kBatch) {
        const std::size_t n = std::min(kBatch, groups - begin);
        std::vector<std::vector<double>> bits(n, std::vector<double>(channels + 2, 0.0));
        std::vector<GroupTask::Training> training(options.train ? n : 0);
        parallel_for(std::int64_t(n), [&](std::int64_t i) {
            task.run(std::int64_t(begin) + i, bits[std::size_t(i)], options.train ? &training[std::size_t(i)] : nullptr);
        });
        for (const auto& here : bits) {
            for (std::size_t c = 0; c < channels; ++c) out.bits[Eigen::Index(c)] += here[c];
            out.presence_bits += here[channels];
            out.correction_bits += here[channels + 1];
        }
        for (const auto& here : training) {
            out.seen.resize(here.seen.size(), 0);
            out.weights.resize(here.weights.size(), 0);
            for (std::size_t i = 0; i < here.seen.size(); ++i) out.seen[i] += here.seen[i];
            for (std::size_t i = 0; i < here.weights.size(); ++i) out.weights[i] += here.weights[i];
        }
    }
    for (const auto& group : out.groups)
        for (const auto& object : group.objects) out.bytes += object.bytes.size();
    return out;
}

coding::MotionStart train_start(const CodedGroups& pass, std::int64_t groups, int fewest) {
    coding::MotionStart start;
    start.confidence = 20;
    for (std::size_t at = 0; at * 2 < pass.seen.size(); ++at) {
        const double zeros = pass.seen[2 * at], ones = pass.seen[2 * at + 1];
        if (zeros + ones < fewest) continue;
        const double logit = 256 * std::log((ones + 0.4) / (zeros + 0.4));
        const long level = std::clamp(std::lround(logit / coding::MotionStart::kLevelUnit), -30l, 30l);
        start.chances.push_back({std::uint32_t(at), std::int8_t(level)});
    }
    if (!pass.weights.empty() && groups > 0) {
        const std::int64_t neutral = 65536 * 4 / std::int64_t(coding::MotionChannels::kInputs * 3);
        start.weights.resize(pass.weights.size());
        for (std::size_t i = 0; i < pass.weights.size(); ++i) {
            const double mean = double(pass.weights[i]) / double(groups);
            start.weights[i] = std::int8_t(std::clamp(std::lround((mean - double(neutral)) / 2048), -127l, 127l));
        }
    }
    return start;
}

void train_predictors(MotionBasis& basis, const GroupPlan& plan, const Eigen::MatrixXd& targets) {
    basis.predictors.assign(std::size_t(targets.rows()), {});
    parallel_for(targets.rows(), [&](std::int64_t c) {
        constexpr int kOrder = MotionBasis::kMaxOrder;
        Eigen::Matrix<double, kOrder + 1, kOrder + 1> products = Eigen::Matrix<double, kOrder + 1, kOrder + 1>::Zero();
        double count = 0;
        for (std::int64_t g = 0; g < plan.count(); ++g)
            for (std::int64_t i = 1; i < plan.length(g); ++i) {
                Eigen::Matrix<double, kOrder + 1, 1> x;
                for (int o = 0; o <= kOrder; ++o) x[o] = targets(c, plan.first(g) + std::max<std::int64_t>(0, i - o));
                products += x * x.transpose();
                count += 1;
            }
        auto& row = basis.predictors[std::size_t(c)];
        if (count == 0) {
            row[0] = 256;
            return;
        }
        // The past is known with the quantiser's error only: 1/12 of a squared step.
        Eigen::Matrix<double, kOrder, kOrder> normal = products.bottomRightCorner<kOrder, kOrder>();
        normal.diagonal().array() += count * 0.12;
        const Eigen::Matrix<double, kOrder, 1> right = products.block<kOrder, 1>(1, 0);
        const Eigen::Matrix<double, kOrder, 1> a = normal.ldlt().solve(right);
        for (int o = 0; o < kOrder; ++o) row[std::size_t(o)] = std::int16_t(std::clamp(std::lround(a[o] * 256), -1024l, 1024l));
    });
}

}  // namespace mien::encoder
