#include "net/client_state.hpp"

/// What of a face model is left when its stream plays: the refinements, one after another.
namespace mien::net {

const Hash* Client::State::missing_refinement() const {
    if (!options.refine || !statistics.unrefined.empty()) return nullptr;
    for (const protocol::BlobInfo& info : order.blobs)
        if (!blobs.contains(info.hash)) return &info.hash;
    return nullptr;
}

void Client::State::ask_for_refinement(Connection& c) {
    refining.reset();
    const Hash* next = missing_refinement();
    if (!next) return;
    refining = *next;
    // The server sends it when no group is due.
    c.send(protocol::Want{{*next}});
}

void Client::State::take_refinement(Connection& c, Result<protocol::Message> message) {
    if (!message) return stop_refining(message.error().message);
    auto& blob = std::get<protocol::StaticBlob>(*message);
    if (blob.hash != refining) return stop_refining("the server sent another one than it was asked for");
    take_fetched(std::move(blob));
    ask_for_refinement(c);
}

/// What is damaged on the server stays so: it is not asked for again, and nothing behind it, since stages build on each other.
void Client::State::stop_refining(std::string why) {
    refining.reset();
    const std::lock_guard lock(mutex);
    statistics.unrefined = "the face model stays as it is, its next refinement cannot be had: " + why;
}

}  // namespace mien::net
