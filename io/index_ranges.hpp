#pragma once

#include <compare>
#include <cstdint>
#include <functional>
#include <limits>
#include <string>
#include <utility>
#include <vector>

namespace mien::io {

/// Indices as people list them: "3-17, 20".
class IndexRanges {
public:
    static constexpr std::size_t kAll = std::numeric_limits<std::size_t>::max();

    void add(std::int64_t index) { add(index, index); }  ///< not before one that is there; the last one again is nothing new
    void add(std::int64_t first, std::int64_t last);     ///< both included
    bool empty() const { return ranges_.empty(); }
    std::int64_t count() const;
    std::int64_t first() const { return ranges_.front().first; }
    std::int64_t last() const { return ranges_.back().second; }
    /// After `most` ranges "... (57 in all)" stands for the rest.
    std::string text(std::size_t most = kAll) const;
    /// "frame 3", "frames 3-17, 20".
    std::string text(const char* one, const char* many, std::size_t most = kAll) const;
    /// The same as the subject of a sentence: "frame 3 is", "frames 3-17, 20 are".
    std::string subject(const char* one, const char* many, std::size_t most = kAll) const;
    void visit(const std::function<void(std::int64_t)>& see) const;  ///< every index, ascending
    auto operator<=>(const IndexRanges&) const = default;

private:
    std::vector<std::pair<std::int64_t, std::int64_t>> ranges_;  ///< first and last, ascending, never adjoining
};

}  // namespace mien::io
