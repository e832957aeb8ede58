#pragma once

#include <functional>
#include <string>
#include <vector>

#include "core/result.hpp"
#include "io/index_ranges.hpp"

namespace mien::io {

/// Something a person should know about a clip.
enum class Severity {
    note,     ///< good to know; nothing to do
    warning,  ///< loads, but perhaps not as meant
    grave,    ///< the same, but surely not as meant: a problem for io::check_clip
    problem,  ///< must be put right before the clip can be used
};
struct Finding {
    Severity severity;
    std::string text;  ///< one sentence without a final full stop, naming file, frame and point where there are any
    ErrorCode code = ErrorCode::invalid;
    std::string brief = {};  ///< the same with its lists cut short; empty: it is short as it stands
};
inline constexpr std::size_t kBriefList = 8;  ///< entries of a list that one reads in passing

/// Collects findings.
class Findings {
public:
    void note(std::string text) { add({Severity::note, std::move(text)}); }
    void warn(std::string text) { add({Severity::warning, std::move(text)}); }
    void warn_gravely(std::string text) { add({Severity::grave, std::move(text)}); }
    void problem(Error error) { add({Severity::problem, std::move(error.message), error.code}); }
    void problem(ErrorCode code, std::string text) { problem({code, std::move(text)}); }
    /// What holds a list: say(most) has no more than `most` entries of it.
    using Say = std::function<std::string(std::size_t most)>;
    void warn_of_list(const Say& say) { add_list(Severity::warning, ErrorCode::invalid, say); }
    void problem_of_list(ErrorCode code, const Say& say) { add_list(Severity::problem, code, say); }
    void add_list(Severity severity, ErrorCode code, const Say& say) { add({severity, say(IndexRanges::kAll), code, say(kBriefList)}); }
    void add(Finding finding) { all_.push_back(std::move(finding)); }

    const std::vector<Finding>& all() const { return all_; }

private:
    std::vector<Finding> all_;
};

}  // namespace mien::io
