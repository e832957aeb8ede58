#pragma once

#include <cstdint>
#include <span>
#include <vector>

namespace mien::model {

/// Columns of small integers, each with a scale: what a motion basis is before it becomes floats. Some rows of two columns at a time, in as
/// few bits as these need and in the order in which a sum over columns takes them, so that a frame of many points costs one walk through
/// little memory: what such a sum waits for.
class PackedColumns {
public:
    /// Rows that lie together, pair of columns after pair.
    static constexpr std::size_t kTile = 32;

    PackedColumns() = default;
    /// columns: k of d integers each. scales: k. Empty when a number needs more than 16 bits.
    static PackedColumns pack(std::span<const std::vector<std::int32_t>> columns, std::span<const double> scales);

    bool empty() const { return scales_.empty(); }
    std::size_t rows() const { return rows_; }
    std::size_t columns() const { return scales_.size(); }
    std::size_t bytes() const { return values_.size(); }

    /// out = start + sum over j of weights[j] * scale j * column j. start: d; weights: k; out: d, may be start. The factors become integers, those of
    /// columns beyond 8 bits two each, and are summed as such: the same on every processor to the last bit. What that is off by is
    /// less than 1/32 of what one in the column with the largest factor says, or else all factors are two integers: finer than a float.
    void sum(std::span<const float> start, std::span<const float> weights, std::span<float> out) const;
    /// The same without the processor's wide instructions.
    void sum_portable(std::span<const float> start, std::span<const float> weights, std::span<float> out) const;
    /// With floats in plain C++: what sum() is near to.
    void sum_plain(std::span<const float> start, std::span<const float> weights, std::span<float> out) const;

private:
    /// Where a tile's numbers are, and how many of its pairs have 16 bits; the others have 8.
    struct Tile {
        std::uint32_t at, wide;
    };
    /// Tiles alike, one after another in order_.
    struct Run {
        std::uint32_t tiles, wide;
    };
    void run(bool portable, std::span<const float> start, std::span<const float> weights, std::span<float> out) const;

    std::size_t rows_ = 0;
    std::vector<float> scales_;
    std::vector<float> reach_;              ///< largest magnitude of every column
    std::vector<float> narrow_reach_;       ///< and in tiles where it has 8 bits
    std::vector<Tile> tiles_;
    std::vector<std::uint32_t> order_;      ///< tiles as their numbers lie
    std::vector<Run> runs_;                 ///< of the whole tiles
    std::vector<std::int8_t> values_;       ///< tile, pair of columns, row, the two columns; rows and columns are filled up with zeros
};

}  // namespace mien::model
