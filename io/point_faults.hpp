#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "io/finding.hpp"
#include "io/index_ranges.hpp"

namespace mien::io {

/// Which points of which frames have one and the same fault, said in few words: points that have it in the same frames are
/// named together.
class PointFaults {
public:
    /// What a point is called: "marker", "markers". `names`: one per point, or none; to outlive this.
    PointFaults(const char* one, const char* many, const std::vector<std::string>* names = nullptr) : one_(one), many_(many), names_(names) {}

    void add(std::int64_t frame, std::int64_t point);  ///< frames in ascending order
    bool empty() const { return count_ == 0; }
    std::int64_t count() const { return count_; }      ///< of points in frames
    /// "marker 5 of frames 3-17, 20; markers 6-7 of frame 4"; no more than `most` entries of any list.
    std::string text(std::size_t most = IndexRanges::kAll) const;
    /// "SOURCE: markers 6-7 of frame 4 are FAULT", a finding for each set of frames.
    void report(Findings& findings, Severity severity, ErrorCode code, const std::string& source, const char* fault) const;

private:
    struct Group {
        IndexRanges points, frames;
    };
    std::vector<Group> groups() const;  ///< by frames, then by points
    std::string text_of(const Group& group, std::size_t most) const;

    const char *one_, *many_;
    const std::vector<std::string>* names_;
    std::vector<IndexRanges> frames_of_point_;
    std::int64_t count_ = 0;
};

}  // namespace mien::io
