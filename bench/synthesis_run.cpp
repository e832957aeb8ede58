#include "bench/synthesis_run.hpp"

#include <algorithm>
#include <bit>
#include <chrono>
#include <cmath>
#include <optional>
#include <tuple>

#include "bench/timing.hpp"

namespace mien::bench {
namespace {

double seconds(auto&& work) {
    const auto start = std::chrono::steady_clock::now();
    work();
    return std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
}

constexpr Eigen::Index kComponents = 24;

struct Samples {
    std::vector<double> read, fast, plain;
};

/// Reads every coefficient once, as fast as the memory gives them.
std::uint32_t read_all(const std::vector<float>& planes) {
    std::uint32_t sums[16] = {};
    std::size_t i = 0;
    const auto bits = [&](std::size_t at) { return std::bit_cast<std::uint32_t>(planes[at]); };
    for (; i + 16 <= planes.size(); i += 16)
        for (std::size_t j = 0; j < 16; ++j) sums[j] += bits(i + j);
    for (; i < planes.size(); ++i) sums[0] += bits(i);
    std::uint32_t sum = 0;
    for (const std::uint32_t s : sums) sum += s;
    return sum;
}

double median_ratio(const std::vector<double>& a, const std::vector<double>& b) {
    std::vector<double> ratios;
    for (std::size_t i = 0; i < a.size(); ++i) ratios.push_back(a[i] / b[i]);
    return quantile(ratios, 0.5);
}

void finish(SynthesisTimes::Row& row, const Samples& samples) {
    row.read = quantile(samples.read, 0.5);
    row.fast = quantile(samples.fast, 0.5);
    row.plain = quantile(samples.plain, 0.5);
    row.ratio = median_ratio(samples.fast, samples.read);
    row.plain_ratio = median_ratio(samples.plain, samples.fast);
}

}  // namespace

Result<SynthesisTimes> time_synthesis(const model::FaceModel& face, int rounds, const Progress& progress) {
    if (!face.detail) return Error{ErrorCode::invalid, "this stream has no detail layers; `mien train` makes such models"};
    const model::DetailModel& detail = face.detail->model();
    SynthesisTimes out;
    out.vertices = std::int64_t(detail.neutral.positions.rows());
    out.markers = std::int64_t(detail.sites.size());
    out.medium_side = detail.medium_domain.width;
    out.fine_side = detail.fine_domain.width;

    struct Layer {
        const char* name;
        const model::PolynomialMap* map;
        const model::DomainMap* domain;
        Samples samples;
        double difference = 0;
        std::vector<float> values, truth;
    };
    std::vector<Layer> layers;
    for (const auto& [name, map, domain] : {std::tuple{"medium", &detail.medium, &detail.medium_domain},
                                            std::tuple{"fine", &detail.fine, &detail.fine_domain},
                                            std::tuple{"albedo", &detail.albedo, &detail.fine_domain}})
        if (map->texels > 0) {
            Layer layer{name, map, domain, {}, 0, std::vector<float>(std::size_t(map->channels) * map->texels), {}};
            layer.truth = layer.values;
            layers.push_back(std::move(layer));
        }

    if (progress) progress("loading the model", 0, 0);
    const Points still = Points::Zero(Eigen::Index(detail.sites.size()), 3);
    model::FaceModel shell;
    shell.neutral = detail.neutral;
    std::optional<model::DetailLayers> made;
    out.load = seconds([&] {
        shell.base = model::make_shell_base(detail.neutral, detail.sites, still, detail.fixed, nullptr);
        made.emplace(detail);
    });
    const model::DeformationMeter& meter = made->meter();
    const Points& rest = meter.mesh().neutral;
    // What a player evaluates: the response times a basis of marker motion, made once. Which basis does not matter to the time.
    model::LinearMotion basis;
    basis.mean = Eigen::VectorXf::Zero(3 * rest.rows());
    basis.components.resize(3 * rest.rows(), kComponents);
    for (Eigen::Index i = 0; i < basis.components.size(); ++i) basis.components(i) = std::sin(float(i));
    model::LinearMotion composed;
    out.compose = seconds([&] { composed = model::compose(shell, basis); });
    model::Motion motion;
    motion.coefficients = Eigen::VectorXf::Ones(kComponents);

    std::vector<double> base, deformation;
    Points displaced(rest.rows(), 3);
    Eigen::VectorXf offsets;
    volatile std::uint32_t sink = 0;
    for (int round = 0; round < rounds; ++round) {
        // Any smooth motion of some millimetres.
        for (Eigen::Index m = 0; m < rest.rows(); ++m)
            for (int axis = 0; axis < 3; ++axis)
                displaced(m, axis) = 2 * std::sin(0.05f * rest(m, (axis + 1) % 3) + 0.3f * float(round));
        base.push_back(seconds([&] { offsets = model::motion_vector(composed, motion); }));
        const Points markers = rest + displaced;
        model::DomainParameters parameters;
        deformation.push_back(seconds([&] { parameters = model::domain_parameters(meter.mesh(), detail.axes, meter.measure(markers)); }));
        for (Layer& layer : layers) {
            layer.samples.read.push_back(seconds([&] { sink = sink + read_all(layer.map->planes); }));
            layer.samples.fast.push_back(seconds([&] { model::evaluate(*layer.map, *layer.domain, parameters, layer.values.data()); }));
            layer.samples.plain.push_back(seconds([&] { model::evaluate_plain(*layer.map, *layer.domain, parameters, layer.truth.data()); }));
            for (std::size_t i = 0; i < layer.values.size(); ++i)
                layer.difference = std::max(layer.difference, double(std::abs(layer.values[i] - layer.truth[i])));
        }
        if (progress) progress("timing", round + 1, rounds);
    }
    out.base_shape = quantile(base, 0.5);
    out.components = kComponents;
    out.deformation = quantile(deformation, 0.5);

    for (const Layer& layer : layers) {
        SynthesisTimes::Row row;
        row.name = layer.name;
        row.bytes = layer.map->planes.size() * sizeof(float);
        row.values = std::int64_t(layer.values.size());
        row.difference = layer.difference;
        finish(row, layer.samples);
        out.rows.push_back(row);
    }
    if (layers.size() >= 2) {   // the two layers of shape as one: the sums of each round
        SynthesisTimes::Row row;
        row.name = std::string(layers[0].name) + " + " + layers[1].name;
        row.bytes = out.rows[0].bytes + out.rows[1].bytes;
        row.values = out.rows[0].values + out.rows[1].values;
        row.difference = std::max(out.rows[0].difference, out.rows[1].difference);
        Samples both = layers[0].samples;
        const Samples& other = layers[1].samples;
        for (std::size_t i = 0; i < both.read.size(); ++i) {
            both.read[i] += other.read[i];
            both.fast[i] += other.fast[i];
            both.plain[i] += other.plain[i];
        }
        finish(row, both);
        out.rows.insert(out.rows.begin() + 2, row);
    }
    return out;
}

}  // namespace mien::bench
