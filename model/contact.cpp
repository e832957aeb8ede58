#include "model/contact.hpp"

#include <Eigen/Core>

namespace mien::model {
namespace {

/// Height h over S becomes h + lift(h).
float lift(float h) {
    constexpr float s = kContactSoftness;
    if (h >= s) return 0;
    if (h <= -s) return -h;
    return (s - h) * (s - h) / (4 * s);
}

}  // namespace

void hold_apart(const Contact& contact, Points& points) {
    if (contact.pairs.empty()) return;
    Eigen::ArrayXf x(contact.pairs.size()), y(contact.pairs.size()), z(contact.pairs.size());
    for (Eigen::Index i = 0; i < x.size(); ++i) {
        const auto& [upper, lower] = contact.pairs[std::size_t(i)];
        const Eigen::RowVector3f middle = (points.row(upper) + points.row(lower)) / 2;
        x[i] = middle.x(), y[i] = middle.y(), z[i] = middle.z();
    }
    // S is a mean of these heights: what lies beyond all of them is on its own side.
    const float lowest = y.minCoeff(), highest = y.maxCoeff();
    Eigen::ArrayXf near(x.size());
    for (const Contact::Member& member : contact.members) {
        auto p = points.row(member.vertex);
        if (member.hold > 0 ? p.y() > highest + kContactSoftness : p.y() < lowest - kContactSoftness) continue;
        near = ((x - p.x()).square() + (z - p.z()).square() + kContactReach * kContactReach).square().inverse();
        const float over = p.y() - (near * y).sum() / near.sum();
        p.y() += member.hold * lift(member.hold > 0 ? over : -over);
    }
}

}  // namespace mien::model
