#include "net/library.hpp"

#include <fmt/format.h>

#include "net/stored_stream.hpp"

namespace mien::net {

namespace fs = std::filesystem;

std::shared_ptr<const protocol::StreamFileReader> Library::read(Known& file) const {
    auto reader = open_stored_stream(file.path);
    if (!reader) {
        file.complaint = reader.error().message;
        return nullptr;
    }
    file.complaint.clear();
    file.remark = reader->complete() ? std::string() : fmt::format("{}: {}", file.path.string(), reader->complaint());
    const protocol::StreamHeader& header = reader->header();
    file.entry.frame_rate = header.frame_rate;
    file.entry.frames = header.frames;
    file.entry.live = false;
    auto shared = std::make_shared<const protocol::StreamFileReader>(std::move(*reader));
    file.open = shared;
    return shared;
}

void Library::look() {
    std::map<std::string, Known> now;
    std::error_code error;
    for (fs::directory_iterator at(folder_, error), end; !error && at != end; at.increment(error)) {
        const fs::path& path = at->path();
        const std::string name = path.stem().string();
        std::error_code gone;
        if (path.extension() != ".mien" || name.empty() || name[0] == '.' || !at->is_regular_file(gone)) continue;
        const auto changed = at->last_write_time(gone);
        const std::uintmax_t size = gone ? 0 : at->file_size(gone);
        if (gone) continue;
        if (now.size() == protocol::kMaxStreams) break;
        const auto known = files_.find(name);
        if (known != files_.end() && known->second.changed == changed && known->second.size == size) {
            now[name] = known->second;
            continue;
        }
        Known& file = now[name] = {.path = path, .changed = changed, .size = size, .entry = {.name = name}};
        if (name.size() > protocol::kMaxName)
            file.complaint = fmt::format("{}: the name is longer than {} bytes", path.string(), protocol::kMaxName);
        else
            read(file);
    }
    files_ = std::move(now);
    folder_complaint_ = error ? fmt::format("{}: {}", folder_.string(), error.message()) : std::string();
}

Library::Listing Library::list() {
    const std::lock_guard lock(mutex_);
    look();
    Listing listing;
    if (!folder_complaint_.empty()) listing.unreadable.push_back(folder_complaint_);
    for (const auto& [name, file] : files_) {
        if (file.complaint.empty())
            listing.streams.push_back(file.entry);
        else
            listing.unreadable.push_back(file.complaint);
        if (!file.remark.empty()) listing.incomplete.push_back(file.remark);
    }
    return listing;
}

Result<std::shared_ptr<const protocol::StreamFileReader>> Library::open(const std::string& name) {
    const std::lock_guard lock(mutex_);
    look();
    const auto found = files_.find(name);
    if (found == files_.end()) return Error{ErrorCode::missing, fmt::format("there is no stream '{}' here", name)};
    Known& file = found->second;
    auto reader = file.open.lock();
    if (!reader && file.complaint.empty()) reader = read(file);
    // The server's own paths are none of the viewer's business.
    if (!reader) return Error{ErrorCode::damaged, fmt::format("the stream '{}' cannot be read", name)};
    return reader;
}

}  // namespace mien::net
