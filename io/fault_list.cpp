#include "io/fault_list.hpp"

#include <fmt/format.h>

namespace mien::io {

void FaultList::add(std::string fault) {
    if (first_.size() < kShown) first_.push_back(std::move(fault));
    ++count_;
}

void FaultList::add(std::size_t line, std::string_view fault) { add(fmt::format("line {}: {}", line, fault)); }

Error FaultList::error(std::string before) const {
    std::string text = std::move(before);
    for (const std::string& fault : first_) text += (text.empty() ? "" : "; ") + fault;
    if (count_ > first_.size()) text += fmt::format("; and {} more", count_ - first_.size());
    return {ErrorCode::invalid, std::move(text)};
}

}  // namespace mien::io
