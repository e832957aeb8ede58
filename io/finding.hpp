#pragma once

#include <string>
#include <vector>

#include "core/result.hpp"

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
};

/// Collects findings; lists longer than a screen end in "and N more".
class Findings {
public:
    void note(std::string text) { add({Severity::note, std::move(text)}); }
    void warn(std::string text) { add({Severity::warning, std::move(text)}); }
    void warn_gravely(std::string text) { add({Severity::grave, std::move(text)}); }
    void problem(Error error) { add({Severity::problem, std::move(error.message), error.code}); }
    void problem(ErrorCode code, std::string text) { problem({code, std::move(text)}); }
    void add(Finding finding) { all_.push_back(std::move(finding)); }

    bool has_problem() const {
        for (const Finding& finding : all_)
            if (finding.severity == Severity::problem) return true;
        return false;
    }
    const std::vector<Finding>& all() const { return all_; }

private:
    std::vector<Finding> all_;
};

/// The first few of many findings of one kind, then one that says how many more there were.
class CappedFindings {
public:
    CappedFindings(Findings& findings, Severity severity, ErrorCode code, std::string of_what)
        : findings_(findings), severity_(severity), code_(code), of_what_(std::move(of_what)) {}
    CappedFindings(const CappedFindings&) = delete;
    CappedFindings& operator=(const CappedFindings&) = delete;
    ~CappedFindings() {
        if (count_ > kShown) findings_.add({severity_, "and " + std::to_string(count_ - kShown) + " more " + of_what_, code_});
    }
    bool wants_text() const { return count_ < kShown; }  ///< whether the next one will be shown
    void add(std::string text) {
        if (count_++ < kShown) findings_.add({severity_, std::move(text), code_});
    }
    void add_unseen() { ++count_; }

private:
    static constexpr std::size_t kShown = 8;
    Findings& findings_;
    Severity severity_;
    ErrorCode code_;
    std::string of_what_;
    std::size_t count_ = 0;
};

}  // namespace mien::io
