#include "tools/live_recording.hpp"

#include <algorithm>
#include <cerrno>
#include <cstring>

#include "core/environment_error.hpp"
#include "tools/stored_stream.hpp"

namespace mien::tools {

LiveRecording::LiveRecording(std::filesystem::path path, const protocol::StreamHeader& header, const std::vector<protocol::StaticBlob>& blobs)
    : path_(std::move(path)), part_{path_.string() + ".recording"}, header_(header), blobs_(blobs), file_(std::fopen(part_.path.c_str(), "wbx")), owner_(file_) {
    if (!file_) {
        const int reason = errno;
        throw EnvironmentError("cannot write '" + part_.path.string() + "': " + std::strerror(reason) +
                               (reason == EEXIST ? "; it is what a recording that was broken off has left, so move it away" : ""));
    }
    part_.keep = false;
    writer_.emplace(
        [this](ByteView bytes) {
            if (std::fwrite(bytes.data(), 1, bytes.size(), file_) != bytes.size())
                throw EnvironmentError("cannot write '" + part_.path.string() + "': " + std::strerror(errno));
        },
        header_, blobs_);
}

LiveRecording::Part::~Part() {
    std::error_code ignored;
    if (!keep) std::filesystem::remove(path, ignored);
}

void LiveRecording::add(const protocol::Group& group) {
    writer_->add(group);
    for (const protocol::Object& object : group.objects) payload_[group.slot] += object.bytes.size();
    for (const protocol::Track& track : header_.tracks)
        if (const auto* sound = std::get_if<protocol::SoundInfo>(&track.info); sound && track.rungs.front().slot == group.slot)
            sound_end_ = std::max(sound_end_, group.first_time + std::int64_t(group.objects.size()) * sound->packet_samples - std::int64_t(sound->preroll));
    if (std::fflush(file_) != 0) throw EnvironmentError("cannot write '" + part_.path.string() + "': " + std::strerror(errno));
    part_.keep = true;
}

void LiveRecording::finish(std::uint64_t frames) {
    writer_->finish();
    writer_.reset();
    owner_.reset();
    if (frames == 0) {
        std::filesystem::remove(part_.path);
        throw EnvironmentError("no frame came, so there is nothing to record");
    }
    const auto stream = StoredStream::open(part_.path);
    if (!stream) throw EnvironmentError("what was recorded cannot be read again: " + stream.error().message);
    header_.frames = frames;
    const double seconds = double(frames) / header_.frame_rate.value();
    for (protocol::Track& track : header_.tracks) {
        for (protocol::Rung& rung : track.rungs) rung.bits_per_second = seconds > 0 ? std::uint32_t(std::min(4e9, double(payload_[rung.slot]) * 8 / seconds)) : 0;
        if (auto* sound = std::get_if<protocol::SoundInfo>(&track.info)) sound->samples = std::uint64_t(sound_end_);
    }
    io::OutputFile file(path_);
    protocol::StreamFileWriter writer([&](ByteView bytes) { file.write(bytes); }, header_, blobs_);
    for (const protocol::IndexEntry& entry : stream->reader().index()) {
        const auto group = stream->reader().read_group(entry);
        if (!group) throw EnvironmentError("what was recorded cannot be read again: " + group.error().message);
        writer.add(*group);
    }
    writer.finish();
    file.commit();
    std::filesystem::remove(part_.path);
}

}  // namespace mien::tools
