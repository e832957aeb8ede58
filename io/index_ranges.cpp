#include "io/index_ranges.hpp"

#include <fmt/format.h>

#include <cassert>

namespace mien::io {

void IndexRanges::add(std::int64_t first, std::int64_t last) {
    assert(first <= last && (ranges_.empty() || first >= this->last()));
    if (!ranges_.empty() && first <= ranges_.back().second + 1) ranges_.back().second = last;
    else ranges_.emplace_back(first, last);
}

std::int64_t IndexRanges::count() const {
    std::int64_t count = 0;
    for (const auto& [first, last] : ranges_) count += last - first + 1;
    return count;
}

std::string IndexRanges::text(std::size_t most) const {
    std::string text;
    for (std::size_t i = 0; i < ranges_.size(); ++i) {
        if (i > 0) text += ", ";
        if (i == most) return text + fmt::format("... ({} in all)", count());
        const auto& [first, last] = ranges_[i];
        text += first == last ? std::to_string(first) : fmt::format("{}-{}", first, last);
    }
    return text;
}

std::string IndexRanges::text(const char* one, const char* many, std::size_t most) const {
    return fmt::format("{} {}", count() == 1 ? one : many, text(most));
}

std::string IndexRanges::subject(const char* one, const char* many, std::size_t most) const {
    return text(one, many, most) + (count() == 1 ? " is" : " are");
}

void IndexRanges::visit(const std::function<void(std::int64_t)>& see) const {
    for (const auto& [first, last] : ranges_)
        for (std::int64_t index = first; index <= last; ++index) see(index);
}

}  // namespace mien::io
