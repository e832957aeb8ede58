#pragma once

#include <cstdint>
#include <span>
#include <vector>

namespace mien::model {

/// Columns of small integers, each with a scale: what a motion basis is before it becomes floats. Half the bytes of the floats and
/// in the order in which a sum over columns takes them, so that a frame of many points costs one walk through the memory.
class PackedColumns {
public:
    /// Rows that lie together, column after column.
    static constexpr std::size_t kTile = 32;

    PackedColumns() = default;
    /// columns: k of d integers each. scales: k. Empty when a number needs more than 16 bits.
    static PackedColumns pack(std::span<const std::vector<std::int32_t>> columns, std::span<const double> scales);

    bool empty() const { return scales_.empty(); }
    std::size_t rows() const { return rows_; }
    std::size_t columns() const { return scales_.size(); }

    /// out = start + sum over j of weights[j] * scale j * column j. start: d; weights: k; out: d, may be start.
    void sum(std::span<const float> start, std::span<const float> weights, std::span<float> out) const;
    /// The same in plain C++; sum() differs from it by rounding only.
    void sum_plain(std::span<const float> start, std::span<const float> weights, std::span<float> out) const;

private:
    using Sum = void (*)(const std::int16_t* values, const float* factors, std::size_t columns, std::size_t rows, const float* start, float* out);
    void run(Sum add, std::span<const float> start, std::span<const float> weights, std::span<float> out) const;

    std::size_t rows_ = 0;
    std::vector<float> scales_;
    std::vector<std::int16_t> values_;   ///< tile, column, row; the last tile is filled up with zeros
};

}  // namespace mien::model
