#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "core/result.hpp"

namespace mien::io {

/// What is wrong in one file, told as one error: a reader goes on after a fault to find the others.
class FaultList {
public:
    void add(std::string fault);
    void add(std::size_t line, std::string_view fault);  ///< "line 7: FAULT"
    bool empty() const { return count_ == 0; }
    /// invalid: `before` (if it is not empty) and the first faults, one after another, then "and 34 more".
    Error error(std::string before = {}) const;

private:
    static constexpr std::size_t kShown = 20;  ///< who has more to put right has the wrong file

    std::vector<std::string> first_;
    std::size_t count_ = 0;
};

}  // namespace mien::io
