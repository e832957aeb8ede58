#include "net/client_state.hpp"

/// What of a face model is left when its stream plays: the refinements, one after another.
namespace mien::net {

const Hash* Client::State::missing_refinement() const {
    if (!options.refine || !statistics.unrefined.empty()) return nullptr;
    for (const protocol::BlobInfo& info : order.blobs)
        if (!blobs.contains(info.hash)) return &info.hash;
    return nullptr;
}

void Client::State::ask_for_part(Connection& c) {
    if (!refining) {
        const Hash* next = missing_refinement();
        if (!next) return;
        refining = Refining{*next};
    }
    part_due = true;
    // The server sends it when no group is due.
    c.send(protocol::WantPart{refining->hash, refining->message.size(), protocol::kMaxPartBytes});
}

void Client::State::take_part(Connection& c, Result<protocol::Message> parsed) {
    part_due = false;
    if (!parsed) return stop_refining(parsed.error().message);
    const auto& part = std::get<protocol::BlobPart>(*parsed);
    Bytes& here = refining->message;
    if (here.empty()) refining->total = part.total;
    if (part.total != refining->total || part.bytes.size() > part.total - here.size()) return refine_anew(c, "its parts do not fit together");
    here.insert(here.end(), part.bytes.begin(), part.bytes.end());
    if (here.size() < part.total) return ask_for_part(c);
    auto message = protocol::parse_message(here);
    if (!message) return refine_anew(c, message.error().message);
    auto* blob = std::get_if<protocol::StaticBlob>(&*message);
    if (!blob || blob->hash != refining->hash) return refine_anew(c, "the server sent something else than it was asked for");
    take_fetched(std::move(*blob));
    refining.reset();
    ask_for_part(c);
}

/// Parts of one connection may be of another packing of the blob than those of the connection before.
void Client::State::refine_anew(Connection& c, std::string why) {
    if (!refining->resumed) return stop_refining(std::move(why));
    refining.reset();
    ask_for_part(c);
}

/// What is damaged on the server stays so: it is not asked for again, and nothing behind it, since stages build on each other.
void Client::State::stop_refining(std::string why) {
    refining.reset();
    part_due = false;
    const std::lock_guard lock(mutex);
    statistics.unrefined = "the face model stays as it is, its next refinement cannot be had: " + why;
}

}  // namespace mien::net
