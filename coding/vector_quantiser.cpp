#include "coding/vector_quantiser.hpp"

#include <algorithm>
#include <cmath>

#include "coding/point_influence.hpp"
#include "coding/vector_coder.hpp"
#include "core/wide.hpp"

namespace mien::coding {
namespace {

// Rounds after the first move a surprise from mending its own point towards mending all it moves, by so much of the way, and by
// so much of a step at most: neighbours overlap, and further would overshoot. Measured on procedural and scanned heads.
constexpr double kRelaxation = 0.7, kFarthest = 0.7;

using Share = PointInfluence::Share;
using Row = std::array<double, 4>;   // a point's coordinates, padded so that they fill a register

/// sum = what the points moved lack, weighted; in four chains, so that no addition waits for the one before it.
MIEN_LOOP weigh_rows_loop(std::span<const Share> shares, const Row* left, Row& sum) {
    std::array<Row, 4> chain{};
    const auto add = [&](Row& to, const Share& share) {
        const Row& row = left[share.point];
        for (std::size_t c = 0; c < 4; ++c) to[c] += double(share.weight) * row[c];
    };
    std::size_t i = 0;
    for (; i + 4 <= shares.size(); i += 4)
        for (std::size_t k = 0; k < 4; ++k) add(chain[k], shares[i + k]);
    for (; i < shares.size(); ++i) add(chain[0], shares[i]);
    for (std::size_t c = 0; c < 4; ++c) sum[c] = (chain[0][c] + chain[1][c]) + (chain[2][c] + chain[3][c]);
}
MIEN_WIDE(weigh_rows, (std::span<const Share> shares, const Row* left, Row& sum), (shares, left, sum))

/// Takes from the points moved what a surprise gives them.
MIEN_LOOP take_rows_loop(std::span<const Share> shares, const Row& given, Row* left) {
    for (const Share& share : shares)
        for (std::size_t c = 0; c < 4; ++c) left[share.point][c] -= double(share.weight) * given[c];
}
MIEN_WIDE(take_rows, (std::span<const Share> shares, const Row& given, Row* left), (shares, given, left))

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
    std::vector<Row> left(s.shape.points, Row{});            // what no surprise has made yet
    for (std::size_t i = 0; i < target.size(); ++i) left[i / coordinates][i % coordinates] = target[i];
    Row product{}, given{};                                  // of the point being coded
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
                if (c == 0) weigh_rows(shares, left.data(), product);
                const double mended = kRelaxation * (product[c] / energy + double(surprise[v.index]) - surprising);
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
            given[c] = double(made - surprise[v.index]);
            // Coordinates do not touch each other: all of a point's are taken at once.
            if (rounds > 1 && c + 1 == coordinates && given != Row{}) take_rows(shares, given, left.data());
            surprise[v.index] = made;
            return best;
        });
    }
    return s.walk;
}

}  // namespace mien::coding
