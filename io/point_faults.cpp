#include "io/point_faults.hpp"

#include <fmt/format.h>

#include <map>

namespace mien::io {

void PointFaults::add(std::int64_t frame, std::int64_t point) {
    if (std::size_t(point) >= frames_of_point_.size()) frames_of_point_.resize(std::size_t(point) + 1);
    frames_of_point_[std::size_t(point)].add(frame);
    ++count_;
}

std::vector<PointFaults::Group> PointFaults::groups() const {
    std::map<IndexRanges, IndexRanges> points_of_frames;
    for (std::size_t point = 0; point < frames_of_point_.size(); ++point)
        if (!frames_of_point_[point].empty()) points_of_frames[frames_of_point_[point]].add(std::int64_t(point));
    std::vector<Group> groups;
    for (const auto& [frames, points] : points_of_frames) groups.push_back({points, frames});
    return groups;
}

std::string PointFaults::text_of(const Group& group, std::size_t most) const {
    std::string points = group.points.text(one_, many_, most);
    // A name says more than a number, and runs have none.
    if (names_ && !names_->empty()) {
        points = group.points.count() == 1 ? one_ : many_;
        std::size_t shown = 0;
        group.points.visit([&](std::int64_t point) {
            if (shown++ < most) points += fmt::format("{} {} ({})", shown == 1 ? "" : ",", point, (*names_)[std::size_t(point)]);
        });
        if (shown > most) points += fmt::format(", ... ({} in all)", shown);
    }
    return fmt::format("{} of {}", points, group.frames.text("frame", "frames", most));
}

std::string PointFaults::text(std::size_t most) const {
    std::string text;
    const std::vector<Group> all = groups();
    for (std::size_t i = 0; i < all.size(); ++i) {
        if (i > 0) text += "; ";
        if (i == most) return text + "...";
        text += text_of(all[i], most);
    }
    return text;
}

void PointFaults::report(Findings& findings, Severity severity, ErrorCode code, const std::string& source, const char* fault) const {
    for (const Group& group : groups()) {
        findings.add_list(severity, code, [&](std::size_t most) {
            return fmt::format("{}: {} {} {}", source, text_of(group, most), group.points.count() == 1 ? "is" : "are", fault);
        });
    }
}

}  // namespace mien::io
