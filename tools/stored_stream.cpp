#include "tools/stored_stream.hpp"

#include <algorithm>

#include "decoder/model_decoder.hpp"
#include "net/stored_stream.hpp"

namespace mien::tools {

using protocol::TrackKind;

Result<StoredStream> StoredStream::open(const std::filesystem::path& path) {
    MIEN_TRY(reader, net::open_stored_stream(path));
    auto stream = load(std::move(reader));
    if (!stream.ok()) return Error{stream.error().code, "'" + path.string() + "': " + stream.error().message};
    return stream;
}

Result<StoredStream> StoredStream::from_bytes(std::shared_ptr<const Bytes> bytes) {
    const auto read_at = [bytes](std::uint64_t offset, std::span<std::byte> into) -> Result<std::size_t> {
        if (offset >= bytes->size()) return std::size_t(0);
        const std::size_t size = std::min(into.size(), bytes->size() - std::size_t(offset));
        std::copy_n(bytes->begin() + std::ptrdiff_t(offset), size, into.begin());
        return size;
    };
    MIEN_TRY(reader, protocol::StreamFileReader::open(read_at, bytes->size()));
    return load(std::move(reader));
}

Result<StoredStream> StoredStream::load(protocol::StreamFileReader reader) {
    StoredStream stream;
    stream.reader_ = std::make_shared<protocol::StreamFileReader>(std::move(reader));
    for (const protocol::BlobInfo& info : stream.reader_->catalogue().blobs) {
        MIEN_TRY(bytes, stream.reader_->blob(info.hash));
        stream.blobs_.emplace(info.hash, std::move(bytes));
    }
    return stream;
}

const Bytes* StoredStream::blob(const Hash& hash) const {
    const auto found = blobs_.find(hash);
    return found == blobs_.end() ? nullptr : &found->second;
}

Result<model::FaceModel> StoredStream::model() const {
    return decoder::decode_model(header().model, [this](const Hash& hash) { return blob(hash); });
}

const protocol::Track* StoredStream::track(TrackKind kind) const {
    for (const protocol::Track& track : header().tracks)
        if (track.kind == kind) return &track;
    return nullptr;
}

Result<decoder::MotionDecoder> StoredStream::motion_decoder(const model::FaceModel& model, std::size_t highest) const {
    const protocol::Track* track = this->track(TrackKind::motion);
    if (!track) return Error{ErrorCode::missing, "the stream has no motion track"};
    const auto& info = std::get<protocol::MotionInfo>(track->info);
    if (!decoder::fits(model, info)) return Error{ErrorCode::mismatch, "the motion track does not fit the stream's face model"};
    std::vector<ByteView> bases;
    for (const protocol::Rung* rung : protocol::rung_ladder(*track)) {
        if (bases.size() > highest) break;
        const Bytes* bytes = rung->basis ? blob(*rung->basis) : nullptr;
        if (!bytes) return Error{ErrorCode::missing, "the stream lacks a motion basis"};
        bases.push_back(*bytes);
    }
    return decoder::MotionDecoder::create(info, bases, model.neutral.triangles, model.neutral.mirror);
}

Result<void> StoredStream::visit_groups(const protocol::Track& track,
                                        const std::function<Result<void>(const protocol::Group&)>& visit, const Skip& skip) const {
    for (const auto& entry : reader().index()) {
        if (entry.slot != track.rungs.front().slot) continue;
        const auto group = reader().read_group(entry);
        const auto visited = group.ok() ? visit(*group) : Result<void>(group.error());
        if (visited.ok()) continue;
        if (!skip) return visited.error();
        skip(entry, visited.error());
    }
    return {};
}

Result<void> StoredStream::visit_motion(decoder::MotionDecoder& decoder,
                                        const std::function<Result<void>(const model::Motion&)>& visit, const Skip& skip) const {
    const protocol::Track* track = this->track(TrackKind::motion);
    if (!track) return Error{ErrorCode::missing, "the stream has no motion track"};
    const auto ladder = protocol::rung_ladder(*track);
    return visit_groups(*track, [&](const protocol::Group& group) -> Result<void> {
        decoder.begin_group();
        std::vector<protocol::Group> finer;   // each needs all those before it
        const protocol::IndexEntry* lost = nullptr;
        for (std::size_t r = 1; r < decoder.rungs() && !lost; ++r) {
            const protocol::IndexEntry* entry = reader().find(ladder[r]->slot, group.group);
            if (!entry && !reader().complete()) break;
            auto refinement = entry ? reader().read_group(*entry) : Result<protocol::Group>(Error{ErrorCode::missing, "motion: a finer rung lacks a group"});
            if (refinement.ok()) finer.push_back(std::move(*refinement));
            else if (!skip) return refinement.error();
            else if ((lost = entry)) skip(*entry, refinement.error());
            else break;
        }
        std::int64_t frame = group.first_time;
        for (std::size_t i = 0; i < group.objects.size(); ++i) {
            std::vector<const protocol::Object*> refinements;
            for (const auto& refinement : finer) refinements.push_back(i < refinement.objects.size() ? &refinement.objects[i] : nullptr);
            MIEN_TRY(motions, decoder.decode(group.objects[i], frame, refinements));
            if (decoder.refined() != 1 + finer.size() && reader().complete() && !skip)
                return Error{ErrorCode::damaged, "motion: a finer rung of frame " + std::to_string(frame) + " is damaged or missing"};
            for (const model::Motion& motion : motions) MIEN_CHECK(visit(motion));
            frame += group.objects[i].frames;
        }
        return {};
    }, skip);
}

}  // namespace mien::tools
