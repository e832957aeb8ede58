#include "coding/vector_quantiser.hpp"

#include <algorithm>
#include <cmath>

#include "coding/point_influence.hpp"
#include "coding/vector_coder.hpp"

namespace mien::coding {
namespace {

// Rounds after the first move a surprise from mending its own point towards mending all it moves, by so much of the way, and by
// so much of a step at most: neighbours overlap, and further would overshoot. Measured on procedural and scanned heads.
constexpr double kRelaxation = 0.7, kFarthest = 0.7;

}  // namespace

struct VectorQuantiser::State {
    State(const MotionShape& shape_, const PointOrder& order_, const std::array<std::uint8_t, PointOrder::kLevels>& level_steps)
        : shape(shape_), order(order_), influence(order_), vectors(shape, order, level_steps), walk(std::size_t(shape_.dimension()), 0) {}

    MotionShape shape;
    const PointOrder& order;
    PointInfluence influence;
    VectorCoder vectors;
    std::vector<std::int32_t> walk;
    CostCoder coder;
};

VectorQuantiser::VectorQuantiser(const MotionShape& shape, const PointOrder& order,
                                 const std::array<std::uint8_t, PointOrder::kLevels>& level_steps)
    : state_(std::make_unique<State>(shape, order, level_steps)) {}
VectorQuantiser::~VectorQuantiser() = default;
void VectorQuantiser::learn(std::span<const std::vector<std::int32_t>> vectors) { state_->vectors.learn(vectors); }
double VectorQuantiser::bits() const { return state_->coder.bits(); }

std::vector<std::int32_t> VectorQuantiser::quantise(std::span<const double> values, double lambda, int rounds) {
    State& s = *state_;
    const std::size_t coordinates = s.shape.coordinates;
    std::vector<double> target(values.begin(), values.end());
    for (double& v : target) v = std::clamp(v, -double(1 << 27), double(1 << 27));
    std::vector<double> left = target;                       // what no surprise has made yet
    std::vector<std::int64_t> surprise(values.size(), 0);
    const VectorCoder start = s.vectors;
    for (int round = 0; round < rounds; ++round) {
        if (round > 0) s.vectors = start;
        CostCoder trial;
        CostCoder& coder = round + 1 < rounds ? trial : s.coder;
        s.vectors.code(coder, s.walk, [&](const VectorCoder::Value& v, const IntegerModel::Contexts& contexts, const IntegerModel& model) {
            const auto shares = s.influence.of(v.position);
            const std::size_t c = v.index % coordinates;
            const double energy = s.influence.energy(v.position);
            double surprising = target[v.index] - double(v.base);
            if (round > 0) {
                // Four chains, so that no addition waits for the one before it.
                const auto part = [&](std::size_t i) { return double(shares[i].weight) * left[shares[i].point * coordinates + c]; };
                double p0 = 0, p1 = 0, p2 = 0, p3 = 0;
                std::size_t i = 0;
                for (; i + 4 <= shares.size(); i += 4) p0 += part(i), p1 += part(i + 1), p2 += part(i + 2), p3 += part(i + 3);
                for (; i < shares.size(); ++i) p0 += part(i);
                const double product = (p0 + p1) + (p2 + p3);
                const double mended = kRelaxation * (product / energy + double(surprise[v.index]) - surprising);
                surprising += std::clamp(mended, -kFarthest * v.step, kFarthest * v.step);
            }
            const std::int64_t told = v.prediction - v.base;
            const double wanted = (surprising - double(told)) / v.step;
            const std::int32_t nearest = std::int32_t(std::clamp(std::lround(wanted), -(1l << 26), 1l << 26));
            std::int32_t best = nearest;
            if (nearest != 0 && lambda > 0) {
                // What the mirror will take over from here counts for both.
                const double both = 1 + v.handed_on * v.handed_on;
                const double per_bit = lambda / (energy * v.step * v.step * both);
                double best_cost = 1e300;
                for (int back = 0; back <= std::min(2, std::abs(nearest)); ++back) {
                    const std::int32_t r = nearest > 0 ? nearest - back : nearest + back;
                    const double cost = (wanted - r) * (wanted - r) + per_bit * model.cost(r, contexts);
                    if (cost < best_cost) best_cost = cost, best = r;
                }
            }
            const std::int64_t made = told + std::int64_t(best) * v.step;
            if (rounds > 1 && made != surprise[v.index])
                for (const auto& share : shares) left[share.point * coordinates + c] -= double(share.weight) * double(made - surprise[v.index]);
            surprise[v.index] = made;
            return best;
        });
    }
    return s.walk;
}

}  // namespace mien::coding
